"""The page of a suite: tables, relations, plots and what runs cost."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
import re
from typing import Any
from urllib.parse import quote

from hunav_drake.report.environment import template_environment
from hunav_drake.report.figures import ReportFigure, run_figures
from hunav_drake.report.suite_tables import (
    cost_table,
    each_cost_table,
    page_table,
    pair_tables,
    relation_table,
    tallies,
    total_cost,
)
from hunav_drake.report.tables import (
    Cell,
    Table,
    outcome_table,
    provenance_table,
)
from hunav_drake.runs.comparison.relations import Judgement
from hunav_drake.runs.comparison.tables import (
    NOTE,
    Table as SuiteTable,
    behavior_tables,
    scenario_tables,
)
from hunav_drake.runs.outcomes import outcome_text
from hunav_drake.runs.run_folders import recording_path, replay_path
from hunav_drake.runs.statistics import LEAST_PAIRS
from hunav_drake.runs.suite_result import KEYS, SuiteResult
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.trial.provenance import MakeProvenance

# The height of a plot over time, in inches.
_SERIES = 2.4

# More lines than this in a plot over time could not be told apart: there are
# as many colors.
_MOST_LINES = 7

# A part of a section: id, title, and what is shown.
_Part = Mapping[str, Any]


def suite_page(result: SuiteResult, judgements: Sequence[Judgement]) -> str:
    """Returns the report of a suite as one HTML page."""
    suite = result.suite
    scenarios = list(dict.fromkeys(cell.scenario for cell in result.cells))
    provenance = MakeProvenance(suite.name, seed=0)
    for key in ("seed", "planner", "scenario_sha256"):
        provenance.pop(key, None)
    provenance["code_sha256"] = result.code_sha256
    cells = {f"{cell.name} (SHA-256)": cell.sha256 for cell in result.cells}
    costs = result.costs()
    outcomes = result.outcomes()
    sections: dict[str, Any] = {
        "outcomes": outcome_table(
            outcomes, {it: it for it in KEYS if any(outcomes[it])}
        ),
        "tables": _table_parts("table", scenario_tables(result)),
        "behaviors": _table_parts("behavior", behavior_tables(result)),
        "relations": relation_table(judgements),
        "figures": _parts(
            "plots",
            scenarios,
            "figures",
            (
                _figures(result, name, f"s{i}-")
                for i, name in enumerate(scenarios)
            ),
        ),
        "replays": _replays(result),
        "pairs": _parts(
            "seeds",
            scenarios,
            "pairs",
            (pair_tables(result, name) for name in scenarios),
        ),
        "costs": cost_table(costs),
    }
    return (
        template_environment()
        .get_template("suite.html")
        .render(
            title=f"Benchmark {suite.name}",
            about=[
                f"version {suite.version}",
                f"{len(result.cells)} cells",
                f"{len(result.rows)} runs: {outcome_text(outcomes)}",
            ],
            description=suite.description,
            replay=None,
            left_out={},
            duplicates=[],
            note=NOTE,
            same_seeds=result.same_seeds(),
            contents=_contents(sections, bool(result.failures)),
            **sections,
            tallies=tallies(judgements),
            least_pairs=LEAST_PAIRS,
            total_cost=total_cost(costs),
            each_cost=each_cost_table(costs),
            failures=[
                f"{row.cell}, seed {row.seed}: {row.end_message}"
                for row in result.failures
            ],
            provenance=provenance_table({**provenance, **cells}),
        )
    )


# The sections of the page, with the ids of their headings.
_SECTIONS = (
    ("outcomes", "outcomes", "Outcomes"),
    ("tables", "tables", "Tables"),
    ("behaviors", "behaviors", "By behavior"),
    ("relations", "relations", "Relations"),
    ("figures", "plots", "Plots"),
    ("replays", "replays", "Replays"),
    ("pairs", "equal-seeds", "On equal seeds"),
    ("costs", "cost", "Cost"),
)


def _contents(
    sections: Mapping[str, Any], has_failures: bool
) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    if has_failures:
        found.append({"id": "failures", "title": "Failures", "parts": []})
    for key, anchor, title in _SECTIONS:
        if content := sections[key]:
            parts = content if isinstance(content, list) else []
            found.append({"id": anchor, "title": title, "parts": parts})
    found.append({"id": "provenance", "title": "Provenance", "parts": []})
    return found


def _table_parts(key: str, tables: Iterable[SuiteTable]) -> list[_Part]:
    return [
        {
            "id": _anchor(key, table.title),
            "title": table.title,
            "table": page_table(table),
        }
        for table in tables
    ]


def _parts(
    key: str, names: Sequence[str], kind: str, contents: Iterable[Any]
) -> list[_Part]:
    return [
        {"id": _anchor(key, name), "title": name, kind: content}
        for name, content in zip(names, contents, strict=True)
        if content
    ]


def _anchor(key: str, title: str) -> str:
    return f"{key}-" + re.sub(r"\W+", "-", title)


def _replays(result: SuiteResult) -> Table | None:
    """Returns links to the replays that there are."""
    if result.folder is None:
        return None
    folder = Path(result.folder)
    rows: dict[str, dict[str, str]] = {}
    for cell in result.cells:
        seed = result.suite.seed_list(cell.scenario)[0]
        path = replay_path(folder, cell.name, seed)
        if path.is_file():
            name = ", ".join(p for p in (cell.planner, cell.setting) if p)
            address = quote(path.relative_to(folder).as_posix())
            rows.setdefault(cell.scenario, {})[name] = address
    if not rows:
        return None
    table: list[list[Cell]] = [[name, links] for name, links in rows.items()]
    return Table(["scenario", "planner"], {"": table})


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
    about = f"seed {seed}"
    if len(runs) > _MOST_LINES:
        about += f", the first {_MOST_LINES} of {len(runs)}"
    runs = dict(list(runs.items())[:_MOST_LINES])
    captions = (
        f"Trajectories of the robots and, dotted, of the people ({about}).",
        f"Distance to the closest person, surface to surface ({about}).",
        f"Forward speed of the robot ({about}).",
        f"Share of time in each proxemic zone ({about}).",
    )
    return run_figures(runs, key, captions, _SERIES)
