"""The page of a suite: tables, relations, plots and what runs cost."""

from collections.abc import Sequence
import math
from pathlib import Path
from typing import Any

import pandas as pd

from hunav_drake.benchmark.comparison.relations import (
    Judgement,
    share_that_holds,
)
from hunav_drake.benchmark.comparison.tables import (
    Table as SuiteTable,
    behavior_tables,
    scenario_tables,
)
from hunav_drake.benchmark.running.recordings import recording_path
from hunav_drake.benchmark.suite_result import SuiteResult
from hunav_drake.report.batch_tables import paired_tables
from hunav_drake.report.environment import template_environment
from hunav_drake.report.figures import ReportFigure, run_figures
from hunav_drake.report.tables import Table, number, provenance_table
from hunav_drake.results.provenance import MakeProvenance
from hunav_drake.results.statistics import LEAST_PAIRS
from hunav_drake.systems.evaluation.recording import Recording

# The height of a plot over time, in inches.
_SERIES = 2.4

# More lines than this in a plot over time could not be told apart.
_MOST_LINES = 6


def suite_page(result: SuiteResult, judgements: Sequence[Judgement]) -> str:
    """Returns the report of a suite as one HTML page."""
    suite = result.suite
    scenarios = list(dict.fromkeys(cell.scenario for cell in result.cells))
    provenance = MakeProvenance(suite.name, seed=0)
    for key in ("seed", "planner", "scenario_sha256"):
        provenance.pop(key, None)
    cells = {f"{cell.name} (SHA-256)": cell.sha256 for cell in result.cells}
    return (
        template_environment()
        .get_template("suite.html")
        .render(
            title=f"Benchmark {suite.name}",
            about=[
                f"version {suite.version}",
                f"{len(result.cells)} cells",
                f"{len(result.rows)} runs",
                f"{len(result.failures)} failures",
            ],
            description=suite.description,
            replay=None,
            left_out={},
            duplicates=[],
            tables=[_page_table(t) for t in scenario_tables(result)],
            behaviors=[_page_table(t) for t in behavior_tables(result)],
            relations=_relations(judgements),
            strong=share_that_holds(judgements),
            pairs=[
                {"scenario": name, "pairs": _pairs(result, name)}
                for name in scenarios
            ],
            least_pairs=LEAST_PAIRS,
            figures=[
                {"scenario": name, "figures": _figures(result, name, f"s{i}-")}
                for i, name in enumerate(scenarios)
            ],
            costs=_costs(result),
            failures=[
                f"{row.cell}, seed {row.seed}: {row.end_message}"
                for row in result.failures
            ],
            provenance=provenance_table({**provenance, **cells}),
        )
    )


def _page_table(table: SuiteTable) -> Table:
    last = len(table.header) - 1
    return Table(
        ["metric", *table.header[1:]],
        {"": [list(row) for row in table.rows]},
        numbers=range(1, last),
        caption=table.title,
    )


def _relations(judgements: Sequence[Judgement]) -> Table | None:
    if not judgements:
        return None
    rows: dict[str, list[list[str]]] = {}
    for it in judgements:
        share = "" if math.isnan(it.share) else f"{100 * it.share:.0f} %"
        rows.setdefault(it.scenarios, []).append(
            [
                str(it.number),
                it.text,
                it.strength,
                it.verdict,
                share,
                it.numbers,
            ]
        )
    head = ["", "relation", "strength", "verdict", "resamples", "numbers"]
    return Table(head, rows, kind="relations")


def _pairs(result: SuiteResult, scenario: str) -> list[dict[str, Any]]:
    runs = result.runs()
    if runs.empty:
        return []
    part = runs[(runs.scenario == scenario) & (runs.repetition == 0)]
    names = part.planner + part.setting.map(lambda s: f", {s}" if s else "")
    part = part.assign(contender=names)
    part.attrs = runs.attrs
    if part["contender"].nunique() < 2:
        return []
    return paired_tables(part, ["time_to_reach_goal", "min_dist_to_people"])


def _figures(
    result: SuiteResult, scenario: str, key: str
) -> list[ReportFigure]:
    """Returns plots like Figs. 5 and 6 of the paper, of one seed."""
    if result.folder is None:
        return []
    runs: dict[str, Recording] = {}
    seed = result.suite.seed_list(scenario)[0]
    for cell in result.cells:
        path = recording_path(Path(result.folder), cell.name, seed)
        if cell.scenario == scenario and path.is_file():
            name = ", ".join(p for p in (cell.planner, cell.setting) if p)
            runs[name] = Recording.load(path)
    if not runs:
        return []
    runs = dict(list(runs.items())[:_MOST_LINES])
    captions = (
        f"Trajectories of the robots and, dotted, of the people (seed {seed}).",
        f"Distance to the closest person, surface to surface (seed {seed}).",
        f"Forward speed of the robot (seed {seed}).",
        f"Share of time in each proxemic zone (seed {seed}).",
    )
    return run_figures(runs, key, captions, _SERIES)


def _costs(result: SuiteResult) -> Table | None:
    costs = result.costs()
    names = [
        name
        for name in ("wall", "cpu", "cycle_median", "cycle_p95")
        if name in costs
    ]
    if costs.empty or not names:
        return None
    rows = []
    keys = ["scenario", "planner", "setting"]
    for place, part in costs.groupby(keys, sort=False):
        rate = float((part.end_time / part.wall).median())
        medians = [_milliseconds(part[name]) for name in names]
        label = "/".join(word for word in place if word)
        rows.append([label, str(len(part)), *medians, f"{rate:.0f}"])
    titles = {
        "wall": "run (ms)",
        "cpu": "CPU of it (ms)",
        "cycle_median": "planner cycle, median (ms)",
        "cycle_p95": "planner cycle, 95 % (ms)",
    }
    head = ["cell", "runs", *(titles[n] for n in names), "times real time"]
    return Table(head, {"": rows}, numbers=range(1, len(head)))


def _milliseconds(seconds: pd.Series) -> str:
    return number(1e3 * float(seconds.median()), "ms")
