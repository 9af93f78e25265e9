"""The page about several runs, of a suite or single ones."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pandas as pd

from hunav_drake.report.comparison_figures import comparison_figures
from hunav_drake.report.environment import address_of, write_page
from hunav_drake.report.figures import ReportFigure, make_figure, run_figures
from hunav_drake.report.plots.approaches import NEAR
from hunav_drake.report.plots.comparison import (
    comparison_height,
    plot_comparison,
)
from hunav_drake.report.plots.runs import telling_names
from hunav_drake.report.runs_tables import (
    Printed,
    ambiguous_seeds,
    headline_table,
    paired_tables,
    planner_tables,
    responsibility_table,
)
from hunav_drake.report.suite_sections import (
    cost_heads,
    cost_table,
    cost_text,
    relation_table,
    tallies,
    total_cost,
)
from hunav_drake.report.summary import main_metrics, runs_summary
from hunav_drake.report.tables import (
    Cell,
    Table,
    number,
    outcome_table,
    provenance_table,
)
from hunav_drake.report.trial_page import is_about_robot_alone
from hunav_drake.runs.comparison.relations import Judgement
from hunav_drake.runs.comparison.tables import others_of
from hunav_drake.runs.independent_runs import draws_nothing
from hunav_drake.runs.outcomes import count_outcomes
from hunav_drake.runs.run_row import FAILED
from hunav_drake.runs.settings import contenders
from hunav_drake.runs.statistics import LEAST_PAIRS
from hunav_drake.systems.common.suggest import counted
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.trial.metric_facts import FACTS, Facts, headline_of, unit_of
from hunav_drake.trial.quantity_text import label_text

# The maximum number of lines in a plot over time.
_MOST_LINES = 6

# The height of a plot over time, in inches.
_SERIES = 2.4

# If there are more pairs of planners, or more runs, they are folded. The page
# lists at most _MOST_LISTED runs.
_MOST_OPEN = 3
_MOST_RUNS = 30
_MOST_LISTED = 2000

# The addresses of the pages of runs, by index and kind.
_Links = Mapping[Any, Mapping[str, str]]


@dataclass(frozen=True, kw_only=True)
class ManyRuns:
    """Runs, with the other content of the page.

    Attributes:
        runs: The table of `ReadRuns`.
        by_behavior: The same table by behavior; may be empty.
        recording: Returns the recording of a run by its index in `runs`; None
            if there is none.
        provenance: What determines the results.
        pages: The files of pages of runs, by index, then by kind, "report"
            and "replay".
        about: Texts for the first line of the page.
        description: The purpose of the runs.
        printed: Returns the values of a paper for a scenario and a behavior
            ("" for all people), by planner and metric.
        judgements: The tested relations between planners.
        costs: The computing time of each run, by the index of `runs`: see
            `SuiteResult.costs`.
        made_by: The suite and the versions, for captions.
    """

    runs: pd.DataFrame
    by_behavior: pd.DataFrame
    recording: Callable[[Any], Recording | None]
    provenance: Mapping[str, Any]
    pages: Mapping[Any, Mapping[str, Path]] = field(default_factory=dict)
    about: Sequence[str] = ()
    description: str = ""
    printed: Callable[[str, str], Printed] = lambda scenario, behavior: {}
    judgements: Sequence[Judgement] = ()
    costs: pd.DataFrame = field(default_factory=pd.DataFrame)
    made_by: str = ""


def WriteRunsPage(
    many: ManyRuns,
    filename: Path,
    title: str,
    *,
    left_out: Mapping[str, str] = MappingProxyType({}),
    duplicates: Sequence[str] = (),
) -> Path:
    """Writes the page about several runs as one HTML file.

    Args:
        many: The runs.
        filename: The file to write; an existing one is replaced.
        title: The heading.
        left_out: The reasons of omitted runs, by tag.
        duplicates: Texts about omitted duplicates.

    Returns:
        The path of the file.

    Raises:
        OSError: If it cannot be written.
    """
    links = {
        i: {kind: address_of(path, filename) for kind, path in its.items()}
        for i, its in many.pages.items()
    }
    runs, by_behavior = map(_with_contenders, (many.runs, many.by_behavior))
    headline = headline_table(runs) if headline_of(runs) else None
    scenarios = [
        _scenario(
            many,
            links,
            # The names depend on all runs, so they are equal in all scenarios.
            _own_metrics(runs, runs["scenario"] == name),
            by_behavior[by_behavior["scenario"] == name],
            f"s{i}",
        )
        for i, name in enumerate(dict.fromkeys(runs["scenario"]))
    ]
    failed = runs[runs["end_reason"].isin(FAILED)]
    sections: dict[str, Any] = {
        "failures": [
            f"{', '.join(filter(None, (it.scenario, it.contender)))}, seed"
            f" {it.seed}: {it.end_message}"
            for it in failed.itertuples()
        ],
        "headline": headline,
        "outcomes": outcome_table(
            count_outcomes(runs, ["scenario", "contender"]),
            {"scenario": "scenario", "contender": "planner"},
        ),
        "responsibility": responsibility_table(runs, links),
        "relations": relation_table(many.judgements),
        "runs": _listed_runs(runs, many.costs, links) if len(runs) else None,
        "cost": cost_table(runs, many.costs),
    }
    return write_page(
        filename,
        "runs.html",
        title=title,
        about=_about(many),
        summary=runs_summary(runs) if len(runs) else [],
        description=many.description,
        replay=None,
        left_out=left_out,
        duplicates=duplicates,
        **sections,
        contents=_contents(sections, scenarios),
        scenarios=scenarios,
        tallies=tallies(many.judgements),
        least_pairs=LEAST_PAIRS,
        most_open=_MOST_OPEN,
        most_runs=_MOST_RUNS,
        most_listed=_MOST_LISTED,
        run_count=len(runs),
        total_cost=total_cost(runs, many.costs),
        provenance=provenance_table(many.provenance),
    )


def _with_contenders(table: pd.DataFrame) -> pd.DataFrame:
    """Returns a table of runs with the column `contender`.

    A contender is a planner with its setting, if there are several settings.
    """
    if table.empty:
        nothing = pd.DataFrame(columns=["scenario", "contender", "end_reason"])
        nothing.attrs |= {key: {} for key in FACTS.values()}
        return nothing
    same = table["setting"].nunique() < 2
    told = table.drop(columns="setting") if same else table
    # A copy has its columns in one piece: many that were read are not.
    return table.copy().assign(contender=contenders(told))


def _about(many: ManyRuns) -> list[str]:
    runs = many.runs
    told = [*many.about, counted(len(runs), "run")]
    for key in ("scenario", "planner", "setting", "seed"):
        values = runs[key].unique() if len(runs) else []
        if len(values) > 1:
            told.append(f"{len(values)} {key}s")
        elif len(values) and str(values[0]):
            told.append(f"{key} {values[0]}")
    return told


def _contents(
    sections: Mapping[str, Any], scenarios: Sequence[Mapping[str, Any]]
) -> list[dict[str, Any]]:
    """Returns the sections of the page, with the parts of each."""
    found: list[dict[str, Any]] = []
    for it in scenarios:
        parts = [
            {"id": f"{it['key']}-{name}", "title": title}
            for name, title in (
                ("means", "all metrics"),
                ("pairs", "equal seeds"),
                ("bars", "comparison"),
                ("examples", "example runs"),
            )
            if it[name]
        ]
        title = it["name"] or "Trials"
        found.append({"id": it["key"], "title": title, "parts": parts})
    named = [
        {"id": key, "title": key.capitalize(), "parts": []}
        for key, content in (*sections.items(), ("provenance", True))
        if content
    ]
    last = [it for it in named if it["id"] in ("runs", "cost", "provenance")]
    return [*(it for it in named if it not in last), *found, *last]


def _own_metrics(runs: pd.DataFrame, own: pd.Series) -> pd.DataFrame:
    """Returns some runs, without metrics that only others have."""
    part = runs[own]
    others = others_of(part, runs) & {*runs.attrs.get("units", ())}
    part = part.drop(columns=[*others])
    part.attrs = {
        key: Facts((it, facts[it]) for it in facts if it not in others)
        for key, facts in runs.attrs.items()
    }
    return part


def _scenario(
    many: ManyRuns,
    links: _Links,
    runs: pd.DataFrame,
    by_behavior: pd.DataFrame,
    key: str,
) -> dict[str, Any]:
    """Returns the content about the runs in one scenario."""
    name = str(runs["scenario"].iloc[0])
    metrics = headline_of(runs)
    several = runs["contender"].nunique() > 1
    # Metrics that are always zero are only listed.
    drawn = [it for it in metrics if runs[it].fillna(0.0).any()]
    means, spread = planner_tables(runs, many.printed(name, "")) or (None, None)
    return {
        "key": key,
        "name": name,
        "ambiguous_seeds": ambiguous_seeds(runs),
        "same_seeds": list(
            dict.fromkeys(runs.loc[draws_nothing(runs), "contender"])
        ),
        "means": means,
        "spread": spread,
        "printed": bool(many.printed(name, "")),
        "behaviors": _behaviors(many, by_behavior, name),
        "pairs": paired_tables(runs, metrics),
        "bars": [
            _bars(runs, it, f"{key}-bars{i}")
            for i, it in enumerate(metrics)
            if several and it in drawn
        ],
        "compared": [
            make_figure(f"{key}-{it.name}{i}", it.caption, it.size, it.draw)
            for i, metric in enumerate(main_metrics(runs))
            for it in comparison_figures(runs, metric)
            # (There are bars of each headline metric.)
            if several and it.name != "means"
        ],
        "not_drawn": [it for it in metrics if it not in drawn],
        "several": several,
        **_examples(many, links, runs, key),
    }


def _behaviors(
    many: ManyRuns, runs: pd.DataFrame, scenario: str
) -> dict[str, Table]:
    """Returns the means for each behavior, if there are several."""
    if runs.empty or runs["behavior"].nunique() < 2:
        return {}
    alone = [it for it in runs.columns if is_about_robot_alone(it)]
    found = {}
    for behavior in dict.fromkeys(runs["behavior"]):
        own = runs[runs["behavior"] == behavior].drop(columns=alone)
        if tables := planner_tables(own, many.printed(scenario, behavior)):
            found[str(behavior)] = tables[0]
    return found


def _bars(runs: pd.DataFrame, name: str, key: str) -> ReportFigure:
    return make_figure(
        key,
        f"{name}: means and 95 % confidence intervals by planner.",
        (2.3, comparison_height(runs["contender"].nunique())),
        lambda ax: plot_comparison(runs, name, by="contender", ax=ax),
    )


def _examples(
    many: ManyRuns, links: _Links, runs: pd.DataFrame, key: str
) -> dict[str, Any]:
    """Returns plots of one run of each contender, if possible of one seed."""
    others = (runs["seed"] != runs["seed"].iloc[0]).sort_values(kind="stable")
    chosen = runs.loc[others.index].drop_duplicates("contender")
    replays = {
        str(runs.at[i, "contender"]) or "replay": links[i]["replay"]
        for i in chosen.index
        if "replay" in links.get(i, {})
    }
    # The first runs of a single contender are shown. Runs with the same path
    # of the robot would hide each other.
    rows: dict[bytes, tuple[Any, Recording]] = {}
    lines = 0
    for i in chosen.index if len(chosen) > 1 else runs.index:
        if lines < _MOST_LINES and (run := many.recording(i)) is not None:
            paths = b"".join(it.robot.tobytes() for it in run.robots)
            lines += len(run.robots) * (paths not in rows)
            rows.setdefault(paths, (i, run))
    if not rows:
        return {"examples": [], "replays": replays}
    shown = runs.loc[[i for i, _ in rows.values()]]
    names = telling_names(
        [
            (contender, f"seed {seed}" if seed != "" else "")
            for contender, seed in zip(
                shown["contender"], shown["seed"], strict=True
            )
        ]
    )
    recordings = dict(zip(names, (r for _, r in rows.values()), strict=True))
    which = ", ".join(
        dict.fromkeys(f"seed {s if s != '' else '?'}" for s in shown["seed"])
    )
    if len(chosen) > len(rows) and lines >= _MOST_LINES:
        which += f", the first {len(rows)} of {len(chosen)} planners"
    captions = (
        f"Trajectories of the robot and of the people ({which})."
        if len(recordings) == 1
        else "Trajectories of the robots and, in gray, of the people of the"
        f" first run ({which}).",
        "Distance to the closest person, from surface to surface"
        f" ({which}). A triangle marks the closest point of each approach"
        f" within {NEAR:g} m.",
        f"Forward speed of the robot ({which}). Strips mark when a person is"
        f" within {NEAR:g} m.",
        "Share of time that the robot spent in each proxemic zone of the"
        f" closest person ({which}).",
    )
    figures = run_figures(recordings, f"{key}-", captions, _SERIES)
    return {"examples": figures, "replays": replays}


def _listed_runs(
    runs: pd.DataFrame, costs: pd.DataFrame, links: _Links
) -> Table:
    """Returns a row for each run: its end, key metrics, and its cost."""
    metrics, paid = headline_of(runs), cost_heads(costs)
    texts = ["scenario", "planner", "seed"]
    if runs["setting"].nunique() > 1:
        texts.insert(2, "setting")
    if "repetition" in runs and runs["repetition"].any():
        texts.append("repetition")
    head: list[Cell] = [*texts, "outcome", "end time (s)"]
    head += [
        label_text(name.replace("_", " "), unit_of(runs, name))
        for name in metrics
    ]
    head += paid.values()
    rows: list[list[Cell]] = []
    for i, row in runs.iloc[:_MOST_LISTED].iterrows():
        rows.append(
            [
                *(str(row[key]) for key in texts),
                row["end_reason"],
                number(float(row["end_time"])),
                *(number(float(row[n]), unit_of(runs, n)) for n in metrics),
                *(cost_text(costs.at[i, name]) for name in paid),
            ]
        )
    if any(links.values()):
        # In this column they are visible without scrolling.
        head.insert(2, "pages")
        for row, i in zip(rows, runs.index, strict=False):
            row.insert(2, links.get(i, {}))
    numbers = range(head.index("seed"), len(head))
    return Table(head, {"": rows}, numbers, kind="listed")
