"""What a report tells of one trial."""

from dataclasses import dataclass
import math

import numpy as np
import pandas as pd

from hunav_drake.plots.activity import activity_height, plot_behavior_activity
from hunav_drake.plots.approaches import NEAR
from hunav_drake.plots.series import plot_distance_to_people, plot_robot_speed
from hunav_drake.plots.style import COLUMN
from hunav_drake.plots.trajectories import (
    plot_trajectories,
    trajectories_height,
)
from hunav_drake.plots.zones import plot_zones, zones_height
from hunav_drake.report.html import escape, figure, number, table, wide
from hunav_drake.results.metric_facts import (
    direction_of,
    family_of,
    is_built_in,
    unit_of,
)
from hunav_drake.results.provenance import Provenance
from hunav_drake.results.quantity_text import unit_text
from hunav_drake.results.trial_result import TrialResult
from hunav_drake.systems.evaluation.metrics import METRICS

# The height of plots over time, in inches.
_SERIES = 2.3

_ARROWS = {"lower": "↓", "higher": "↑"}

# What no person has a part in, so that it is the same for any behavior. Of
# metrics of one's own nobody knows.
_ROBOT_FAMILIES = ("path", "goal", "efficiency", "clearance")
_ROBOT_METRICS = (
    "time_not_moving",
    "avg_robot_linear_speed",
    "avg_robot_angular_speed",
    "avg_robot_acceleration",
    "avg_robot_jerk",
    "obstacle_force_on_robot",
    "obstacle_force_on_robot_rate",
    "avg_displacement_error",
    "final_displacement_error",
    "asymmetric_dtw",
)

LEGEND = (
    "<p><small>↓ less is better, ↑ more is better; &ndash; no value."
    " Distances are between surfaces.</small></p>"
)


@dataclass(frozen=True)
class Parts:
    """The parts of a report, as HTML.

    Attributes:
        about: What stands below the heading.
        sections: What follows.
    """

    about: list[str]
    sections: list[str]


def trial_parts(result: TrialResult) -> Parts:
    """Returns the parts of a report on one trial."""
    told = [
        f"{key} {escape(value)}"
        for key, value in (
            ("planner", result.provenance.get("planner", "")),
            ("setting", result.setting),
            ("seed", result.provenance.get("seed", "")),
        )
        if value != ""
    ]
    run = result.recording
    n = run.num_humans
    people = "1 person" if n == 1 else f"{n} people"
    told += [people, f"{number(result.end_time)} s"]
    reason = escape(result.end_reason)
    message = result.end_message or result.end_reason
    about = [
        f'<p class="about">{", ".join(told)}</p>',
        f'<p class="ended {reason}"><strong>Ended after'
        f" {number(result.end_time)} s: {reason}.</strong>"
        f" {escape(message[:1].upper() + message[1:])}.</p>",
    ]
    return Parts(
        about,
        [
            "<h2>What happened</h2>",
            *_figures(result),
            "<h2>Metrics</h2>",
            LEGEND,
            _metrics(result.metrics),
            *_people(result),
            *_by_behavior(result),
            "<h2>Provenance</h2>",
            provenance_table(result.provenance),
        ],
    )


def _figures(result: TrialResult) -> list[str]:
    run = result.recording
    figures = [
        figure(
            "trajectories",
            "The ways of robot and people. Discs are the places at the start,"
            " in true size; the star is the goal; dots and numbers tell the"
            " time in seconds.",
            (COLUMN, trajectories_height(run)),
            lambda ax: plot_trajectories(run, ax=ax),
            layout="compressed",
        ),
        figure(
            "distance",
            "The distance to the closest person, surface to surface. The bands"
            " are the spaces around a person; a triangle marks where an"
            f" approach within {NEAR:g} m is closest.",
            (COLUMN, _SERIES),
            lambda ax: plot_distance_to_people(run, ax=ax),
        ),
        figure(
            "speed",
            "The forward speed of the robot. Shaded: a person is within"
            f" {NEAR:g} m.",
            (COLUMN, _SERIES),
            lambda ax: plot_robot_speed(run, ax=ax),
        ),
    ]
    if run.num_humans:
        figures += [
            figure(
                "zones",
                "In which space of the closest person the robot was.",
                (COLUMN, zones_height(1)),
                lambda ax: plot_zones(run, ax=ax),
            ),
            figure(
                "activity",
                "When people react to the robot: one row per person, in the"
                " color of the behavior while it reacts.",
                (COLUMN, activity_height(run.num_humans)),
                lambda ax: plot_behavior_activity(run, ax=ax),
            ),
        ]
    return ['<div class="figures">', *figures, "</div>"]


def _metrics(metrics: pd.Series) -> str:
    families: dict[str, list[list[str]]] = {}
    for name in metrics.index:
        value = float(metrics[name])
        families.setdefault(family_of(metrics, name), []).append(
            [
                name_cell(metrics, name),
                number(value, unit_of(metrics, name)),
                escape(unit_text(unit_of(metrics, name))),
            ]
        )
    tables = [
        table([], rows, numbers=[1], caption=escape(family))
        for family, rows in families.items()
    ]
    return '<div class="columns">' + "\n".join(tables) + "</div>"


def name_cell(metrics: pd.Series | pd.DataFrame, name: str) -> str:
    """Returns the name of a metric with its direction; it explains itself."""
    arrow = _ARROWS.get(direction_of(metrics, name), "")
    text = escape(name)
    if name in METRICS:
        first = METRICS[name].definition.split("\n\n")[0]
        text = f'<span title="{escape(" ".join(first.split()))}">{text}</span>'
    return f"{text} {arrow}".rstrip()


def _people(result: TrialResult) -> list[str]:
    run = result.recording
    if not run.num_humans:
        return []
    gaps = run.features.gaps
    active = np.asarray(run.behavior_status) != 0
    # Each sample stands for the time until the next.
    intervals = np.append(run.features.intervals, 0.0)
    rows = []
    for i, name in enumerate(run.human_names):
        seen = np.isfinite(gaps[:, i]).any()
        k = int(np.nanargmin(gaps[:, i])) if seen else 0
        group = run.group_ids[i]
        rows.append(
            [
                escape(name),
                escape(run.behaviors[i]),
                str(group) if group >= 0 else "&ndash;",
                number(float(gaps[k, i]) if seen else math.nan),
                number(float(run.times[k]) if seen else math.nan),
                number(float(intervals[active[:, i]].sum())),
            ]
        )
    head = [
        "person",
        "behavior",
        "group",
        "closest (m)",
        "at (s)",
        "reacts for (s)",
    ]
    return [
        "<h2>People</h2>",
        wide(table(head, rows, numbers=[2, 3, 4, 5])),
    ]


def _by_behavior(result: TrialResult) -> list[str]:
    by_behavior = result.by_behavior
    if len(by_behavior) < 2:
        return []
    families: dict[str, list[list[str]]] = {}
    for name in by_behavior.columns:
        if is_about_robot_alone(name):
            continue
        values = by_behavior[name].to_numpy(dtype=float)
        everyone = float(result.metrics.get(name, math.nan))
        unit = unit_of(result.metrics, name)
        families.setdefault(family_of(result.metrics, name), []).append(
            [
                name_cell(result.metrics, name),
                number(everyone, unit),
                *(number(float(value), unit) for value in values),
                escape(unit_text(unit)),
            ]
        )
    rows = rows_by_family(families)
    if not rows:
        return []
    behaviors = [escape(behavior) for behavior in by_behavior.index]
    head = ["metric", "everyone", *behaviors, "unit"]
    text = table(head, rows, numbers=range(1, len(behaviors) + 2))
    return [
        "<h2>By behavior</h2>",
        "<p>The metrics as if only the people of one behavior were there. What"
        " is about the robot alone is left out.</p>",
        wide(text),
    ]


def is_about_robot_alone(name: str) -> bool:
    """Tells whether no person can make a difference to a metric."""
    return is_built_in(name) and (
        METRICS[name].family in _ROBOT_FAMILIES or name in _ROBOT_METRICS
    )


def rows_by_family(
    families: dict[str, list[list[str]]],
) -> list[list[str] | str]:
    """Returns rows of a table, with the name of the family above its own."""
    rows: list[list[str] | str] = []
    for family, own in families.items():
        rows += [escape(family), *own]
    return rows


def provenance_table(provenance: Provenance) -> str:
    """Returns the table of what must be equal for a trial to repeat."""
    rows = [
        [escape(str(key).replace("_", " ")), escape(value)]
        for key, value in provenance.items()
    ]
    return table([], rows, kind="provenance")
