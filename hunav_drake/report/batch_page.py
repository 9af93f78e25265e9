"""What a report tells of many trials."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from hunav_drake.plots.approaches import NEAR
from hunav_drake.plots.comparison import comparison_height, plot_comparison
from hunav_drake.plots.runs import run_names
from hunav_drake.plots.series import plot_distance_to_people, plot_robot_speed
from hunav_drake.plots.style import COLUMN
from hunav_drake.plots.trajectories import (
    plot_trajectories,
    trajectories_height,
)
from hunav_drake.plots.zones import plot_zones, zones_height
from hunav_drake.report.batch_tables import (
    ambiguous_seeds,
    paired_tables,
    planner_tables,
)
from hunav_drake.report.html import escape, figure, number, table, wide
from hunav_drake.report.trial_page import LEGEND, Parts, provenance_table
from hunav_drake.results.metric_facts import is_built_in, unit_of
from hunav_drake.results.quantity_text import unit_text
from hunav_drake.results.run_table import tabulate_runs
from hunav_drake.results.settings import contenders, has_settings
from hunav_drake.results.trial_result import TrialResult

# What is compared in bars, and listed for each run, of many metrics; metrics
# of one's own are always.
_KEY_METRICS = (
    "time_to_reach_goal",
    "path_length",
    "min_dist_to_people",
    "avg_dist_to_closest_person",
    "intimate_space_intrusions",
    "personal_space_intrusions",
    "robot_on_person_collisions",
    "time_not_moving",
    "social_work",
)

# So many metrics are not too many to show all of them.
_FEW = 10

# With more runs than this in a plot over time, nobody can tell the lines.
_MOST_LINES = 6

# The size of a plot over time, in inches.
_SERIES = (COLUMN, 2.4)

# How many of the values that differ between runs are listed.
_MOST_VALUES = 4


def batch_parts(
    trials: Sequence[TrialResult], pages: Sequence[Mapping[str, str]]
) -> Parts:
    """Returns the parts of a report on several trials.

    Args:
        trials: The trials.
        pages: For each of them, the addresses of its own pages, by what they
            are.
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
            told.append(f"{key} {escape(runs[key].iloc[0])}")
    sections = ["<h2>How the runs ended</h2>", _outcomes(runs)]
    for i, scenario in enumerate(dict.fromkeys(runs["scenario"])):
        own = [t for t in trials if t.scenario_name == scenario]
        # Names are as short as they may be among all runs.
        table = runs[runs["scenario"] == scenario]
        sections += _scenario(scenario, own, table, f"s{i}")
    sections += [
        "<h2>Runs</h2>",
        wide(_runs(runs, pages)),
        "<h2>Provenance</h2>",
        provenance_table(_common_provenance(trials)),
    ]
    return Parts([f'<p class="about">{", ".join(told)}</p>'], sections)


def _tabulate(trials: Sequence[TrialResult]) -> pd.DataFrame:
    """Returns the table of runs, with who drives in the column `contender`."""
    runs = tabulate_runs(trials)
    return runs.assign(contender=contenders(runs))


def _key_metrics(runs: pd.DataFrame) -> list[str]:
    """Returns which metrics are shown at once."""
    recorded = list(runs.attrs["units"])
    if len(recorded) <= _FEW:
        return recorded
    key = [name for name in _KEY_METRICS if name in recorded]
    return key + [name for name in recorded if not is_built_in(name)]


def _outcomes(runs: pd.DataFrame) -> str:
    rows = []
    reasons = list(dict.fromkeys(["goal", *runs["end_reason"]]))
    for (scenario, contender), own in runs.groupby(
        ["scenario", "contender"], sort=False
    ):
        counts = Counter(own["end_reason"])
        rows.append(
            [
                escape(scenario),
                escape(contender),
                str(len(own)),
                *(str(counts[reason]) for reason in reasons),
            ]
        )
    head = ["scenario", "planner", "runs", *map(escape, reasons)]
    return table(head, rows, numbers=range(2, len(head)))


def _scenario(
    scenario: str, trials: list[TrialResult], runs: pd.DataFrame, key: str
) -> list[str]:
    """Returns what is told of the trials of one scenario."""
    metrics = _key_metrics(runs)
    sections = [
        f"<h2>{escape(scenario or 'Trials')}</h2>",
        LEGEND,
        "<p><small>Each value is the mean over the runs that have one, with"
        " its 95&nbsp;% interval in brackets; n tells of how many, if not of"
        " all.</small></p>",
        *ambiguous_seeds(runs),
        *planner_tables(runs),
        *paired_tables(runs, metrics),
    ]
    if runs["contender"].nunique() > 1:
        sections += [
            "<h3>Comparison</h3>",
            "<p><small>Bars are means with 95&nbsp;% intervals, dots are single"
            " runs.</small></p>",
            '<div class="bars">',
            *(
                _bars(runs, name, f"{key}-bars{i}")
                for i, name in enumerate(metrics)
                if runs[name].notna().any()
            ),
            "</div>",
        ]
    return [*sections, *_over_time(trials, key)]


def _bars(runs: pd.DataFrame, name: str, key: str) -> str:
    return figure(
        key,
        f"{name}: means and 95 % intervals by planner.",
        (2.3, comparison_height(runs["contender"].nunique())),
        lambda ax: plot_comparison(runs, name, ax=ax),
        captioned=False,
    )


def _over_time(trials: list[TrialResult], key: str) -> list[str]:
    """Returns plots of one run of each contender, of one seed if may be."""
    first = trials[0].provenance.get("seed")
    chosen: dict[Any, TrialResult] = {}
    for trial in [
        *(t for t in trials if t.provenance.get("seed") == first),
        *trials,
    ]:
        contender = (trial.provenance.get("planner"), trial.setting)
        chosen.setdefault(contender, trial)
    shown = list(chosen.values())
    if len(shown) == 1:
        # Of one contender, the first runs.
        shown = trials
    shown = shown[:_MOST_LINES]
    runs = dict(
        zip(run_names(shown), (t.recording for t in shown), strict=True)
    )
    which = ", ".join(
        dict.fromkeys(f"seed {t.provenance.get('seed', '?')}" for t in shown)
    )
    figures = [
        figure(
            f"{key}-trajectories",
            f"The ways of the robots, and dotted those of people ({which}).",
            (COLUMN, trajectories_height(runs)),
            lambda ax: plot_trajectories(runs, ax=ax),
            layout="compressed",
        ),
        figure(
            f"{key}-distance",
            f"The distance to the closest person, surface to surface ({which})."
            f" A triangle marks where an approach within {NEAR:g} m is"
            " closest.",
            _SERIES,
            lambda ax: plot_distance_to_people(runs, ax=ax),
        ),
        figure(
            f"{key}-speed",
            f"The forward speed of the robot ({which}). Strips: a person is"
            f" within {NEAR:g} m.",
            _SERIES,
            lambda ax: plot_robot_speed(runs, ax=ax),
        ),
        figure(
            f"{key}-zones",
            f"In which space of the closest person the robot was ({which}).",
            (COLUMN, zones_height(len(runs))),
            lambda ax: plot_zones(runs, ax=ax),
        ),
    ]
    return ["<h3>Examples</h3>", '<div class="figures">', *figures, "</div>"]


def _runs(runs: pd.DataFrame, pages: Sequence[Mapping[str, str]]) -> str:
    shown = _key_metrics(runs)
    texts = ["scenario", "planner", "seed"]
    if has_settings(runs):
        texts.insert(2, "setting")
    about = [*texts, "ended", "end_time"]
    rows = [
        [
            *(escape(row[key]) for key in texts),
            escape(row["end_reason"]),
            number(float(row["end_time"])),
            *(number(float(row[n]), unit_of(runs, n)) for n in shown),
        ]
        for _, row in runs.iterrows()
    ]
    links = [
        ", ".join(f'<a href="{to}">{kind}</a>' for kind, to in own.items())
        for own in pages
    ]
    units = {name: escape(unit_text(unit_of(runs, name))) for name in shown}
    units["end_time"] = "s"
    head = [
        _breakable(name) + (f" ({units[name]})" if units.get(name) else "")
        for name in about + shown
    ]
    first = texts.index("seed")
    if any(links):
        # Where they are seen without scrolling.
        head.insert(2, "pages")
        for row, link in zip(rows, links, strict=True):
            row.insert(2, link)
        first += 1
    return table(head, rows, numbers=range(first, len(head)))


def _breakable(name: str) -> str:
    return escape(name.replace("_", " "))


def _common_provenance(trials: Sequence[TrialResult]) -> dict[str, Any]:
    """Returns what is the same for all, and what there is of the rest."""
    found: dict[str, dict[str, None]] = {}
    for trial in trials:
        for key, value in trial.provenance.items():
            found.setdefault(key, {})[str(value)] = None
    result = {}
    for key, values in found.items():
        listed = list(values)
        text = ", ".join(listed[:_MOST_VALUES])
        more = len(listed) - _MOST_VALUES
        result[key] = text + (f", and {more} more" if more > 0 else "")
    return result
