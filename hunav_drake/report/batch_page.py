"""What a report on many trials shows."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from hunav_drake.report.batch_tables import (
    ambiguous_seeds,
    headline_table,
    paired_tables,
    planner_tables,
)
from hunav_drake.report.figures import ReportFigure, make_figure, run_figures
from hunav_drake.report.plots.approaches import NEAR
from hunav_drake.report.plots.comparison import (
    comparison_height,
    plot_comparison,
)
from hunav_drake.report.plots.runs import run_names
from hunav_drake.report.tables import (
    Cell,
    Table,
    number,
    outcome_table,
    provenance_table,
    split_by_family,
)
from hunav_drake.runs.independent_runs import draws_nothing
from hunav_drake.runs.outcomes import count_outcomes
from hunav_drake.runs.run_table import tabulate_runs
from hunav_drake.runs.settings import contenders, has_settings
from hunav_drake.runs.statistics import LEAST_PAIRS
from hunav_drake.trial.metric_facts import headline_of, unit_of
from hunav_drake.trial.quantity_text import label_text
from hunav_drake.trial.result import TrialResult

# More lines than this in a plot over time could not be told apart.
_MOST_LINES = 6

# The height of a plot over time, in inches.
_SERIES = 2.4

# At most this many different values of an entry are listed.
_MOST_VALUES = 4

# More pairs of planners, and more runs, are folded: the page is for reading.
_MOST_OPEN = 3
_MOST_RUNS = 30


def batch_content(
    trials: Sequence[TrialResult], pages: Sequence[Mapping[str, str]]
) -> dict[str, Any]:
    """Returns what the template `batch.html` shows.

    `pages` are the addresses of the pages of each trial, by their kinds.
    """
    runs = _tabulate(trials)
    told = [f"{len(trials)} runs"]
    for key, plural in (
        ("scenario", "scenarios"),
        ("planner", "planners"),
        ("setting", "settings"),
        ("seed", "seeds"),
    ):
        count = runs[key].nunique()
        if count > 1:
            told.append(f"{count} {plural}")
        elif str(runs[key].iloc[0]):
            told.append(f"{key} {runs[key].iloc[0]}")
    headline = headline_table(runs) if headline_of(runs) else None
    scenarios = [
        _scenario(
            [t for t in trials if t.scenario_name == name],
            # The names come from all runs, so that they are the same here.
            runs[runs["scenario"] == name],
            f"s{i}",
        )
        for i, name in enumerate(dict.fromkeys(runs["scenario"]))
    ]
    return {
        "about": told,
        "outcomes": outcome_table(
            count_outcomes(runs, ["scenario", "contender"]),
            {"scenario": "scenario", "contender": "planner"},
        ),
        "headline": headline,
        "least_pairs": LEAST_PAIRS,
        "most_open": _MOST_OPEN,
        "most_runs": _MOST_RUNS,
        "run_count": len(runs),
        "contents": _contents(scenarios, headline is not None),
        "scenarios": scenarios,
        "runs": _runs(runs, pages),
        "provenance": provenance_table(_common_provenance(trials)),
    }


def _contents(
    scenarios: Sequence[Mapping[str, Any]], has_headline: bool
) -> list[dict[str, Any]]:
    """Returns the sections of the page, with the parts of each."""
    found: list[dict[str, Any]] = [
        {"id": "outcomes", "title": "Outcomes", "parts": []}
    ]
    if has_headline:
        found.insert(0, {"id": "headline", "title": "Headline", "parts": []})
    for it in scenarios:
        parts = [
            {"id": f"{it['key']}-{name}", "title": title}
            for name, title, shown in (
                ("means", "means", it["means"]),
                ("pairs", "equal seeds", it["pairs"]),
                ("bars", "comparison", it["bars"]),
                ("examples", "example runs", it["examples"]),
            )
            if shown
        ]
        title = it["name"] or "Trials"
        found.append({"id": it["key"], "title": title, "parts": parts})
    return [
        *found,
        {"id": "runs", "title": "Runs", "parts": []},
        {"id": "provenance", "title": "Provenance", "parts": []},
    ]


def _tabulate(trials: Sequence[TrialResult]) -> pd.DataFrame:
    """Returns the table of runs; `contender` is a planner with its settings."""
    runs = tabulate_runs(trials)
    return runs.assign(contender=contenders(runs))


def _scenario(
    trials: list[TrialResult], runs: pd.DataFrame, key: str
) -> dict[str, Any]:
    """Returns what is shown of the trials of one scenario."""
    metrics = headline_of(runs)
    several = runs["contender"].nunique() > 1
    # A panel of zeros tells nothing that a line of text does not.
    drawn = [name for name in metrics if runs[name].fillna(0.0).any()]
    means, spread = planner_tables(runs) or (None, None)
    return {
        "key": key,
        "name": trials[0].scenario_name,
        "ambiguous_seeds": ambiguous_seeds(runs),
        "same_seeds": list(
            dict.fromkeys(runs.loc[draws_nothing(runs), "contender"])
        ),
        "means": split_by_family(means) if means else [],
        "spread": spread,
        "pairs": paired_tables(runs, metrics),
        "bars": [
            _bars(runs, name, f"{key}-bars{i}")
            for i, name in enumerate(metrics)
            if several and name in drawn
        ],
        "not_drawn": [name for name in metrics if name not in drawn],
        "several": several,
        "examples": _over_time(trials, key),
    }


def _bars(runs: pd.DataFrame, name: str, key: str) -> ReportFigure:
    return make_figure(
        key,
        f"{name}: means and 95 % confidence intervals by planner.",
        (2.3, comparison_height(runs["contender"].nunique())),
        lambda ax: plot_comparison(runs, name, ax=ax),
    )


def _over_time(trials: list[TrialResult], key: str) -> list[ReportFigure]:
    """Returns plots of one run of each contender, if possible of one seed."""
    first = trials[0].provenance.get("seed")
    chosen: dict[Any, TrialResult] = {}
    for trial in sorted(
        trials, key=lambda trial: trial.provenance.get("seed") != first
    ):
        contender = (trial.provenance.get("planner"), trial.setting)
        chosen.setdefault(contender, trial)
    shown = list(chosen.values())
    # A single contender is shown by its first runs.
    shown = _distinct(shown if len(shown) > 1 else trials)[:_MOST_LINES]
    runs = dict(
        zip(run_names(shown), (t.recording for t in shown), strict=True)
    )
    which = ", ".join(
        dict.fromkeys(f"seed {t.provenance.get('seed', '?')}" for t in shown)
    )
    captions = (
        f"Trajectories of the robot and of the people ({which})."
        if len(runs) == 1
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
    return run_figures(runs, f"{key}-", captions, _SERIES)


def _distinct(trials: Sequence[TrialResult]) -> list[TrialResult]:
    """Returns trials without those whose robot moves as in one before.

    Their lines would hide each other.
    """
    first: dict[bytes, TrialResult] = {}
    for trial in trials:
        first.setdefault(trial.recording.robot.tobytes(), trial)
    return list(first.values())


def _runs(runs: pd.DataFrame, pages: Sequence[Mapping[str, str]]) -> Table:
    shown = headline_of(runs)
    texts = ["scenario", "planner", "seed"]
    if has_settings(runs):
        texts.insert(2, "setting")
    rows: list[list[Cell]] = [
        [
            *(str(row[key]) for key in texts),
            row["end_reason"],
            number(float(row["end_time"])),
            *(number(float(row[n]), unit_of(runs, n)) for n in shown),
        ]
        for _, row in runs.iterrows()
    ]
    head = [*texts, "outcome", "end time (s)"]
    head += [
        label_text(name.replace("_", " "), unit_of(runs, name))
        for name in shown
    ]
    if any(pages):
        # Here they are seen without scrolling.
        head.insert(2, "pages")
        for row, links in zip(rows, pages, strict=True):
            row.insert(2, links)
    return Table(head, {"": rows}, numbers=range(head.index("seed"), len(head)))


def _common_provenance(trials: Sequence[TrialResult]) -> dict[str, Any]:
    """Returns the different values of each entry of the trials' provenance."""
    result = {}
    for key in dict.fromkeys(
        key for trial in trials for key in trial.provenance
    ):
        told = (t.provenance[key] for t in trials if key in t.provenance)
        values = list(dict.fromkeys(map(str, told)))
        more = len(values) - _MOST_VALUES
        end = [f"and {more} more"] if more > 0 else []
        result[key] = ", ".join(values[:_MOST_VALUES] + end)
    return result
