"""The content of a report on one trial."""

from collections.abc import Iterable, Mapping
import math
from typing import Any

import numpy as np

from hunav_drake.report.figures import ReportFigure, make_figure, run_figures
from hunav_drake.report.plots.activity import (
    activity_height,
    plot_behavior_activity,
)
from hunav_drake.report.plots.approaches import NEAR
from hunav_drake.report.plots.situations import (
    plot_situations,
    situations_height,
)
from hunav_drake.report.plots.style import COLUMN
from hunav_drake.report.tables import (
    Cell,
    MetricRows,
    Table,
    number,
    provenance_table,
    split_by_family,
)
from hunav_drake.report.trial_summary import trial_summary
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.suggest import counted
from hunav_drake.systems.evaluation.encounters import (
    Encounters,
    find_encounters,
)
from hunav_drake.systems.evaluation.metric import (
    FLEET_FAMILY,
    LEAST_GAP,
    base_name,
)
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.situations import FindSituations
from hunav_drake.systems.scene.overlays.reactions import who_reacts
from hunav_drake.trial.metric_facts import headline_of, is_built_in, unit_of
from hunav_drake.trial.result import TrialResult, run_facts

# The height of plots over time, in inches.
_SERIES = 2.3

# The zones of encounters that are shown.
_ZONES = ("contact", "intimate", "personal")

# Metrics that do not depend on people, so they are equal for all behaviors.
# For metrics of users, this is unknown.
_ROBOT_FAMILIES = (
    *("path", "goal", "efficiency", "smoothness", "clearance"),
    FLEET_FAMILY,
)
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


def trial_content(result: TrialResult) -> dict[str, Any]:
    """Returns the variables of the template `trial.html`."""
    n = result.recording.num_humans
    time = number(result.end_time)
    people, by_behavior = _people(result), _by_behavior(result)
    run = result.recording
    found = {
        it.robot_name: find_encounters(run, robot=it.robot_name)
        for it in (run.robots if people else ())
    }
    situations = _situations(run) if people else None
    encounters = _encounters(run, found) if people else None
    message = result.end_message or result.end_reason
    return {
        "about": [
            *run_facts(result),
            counted(n, "person", "people"),
            f"{time} s",
        ],
        "summary": trial_summary(result, found),
        "ending": {
            "reason": result.end_reason,
            "time": time,
            # (It may begin with the name of a robot.)
            "message": message
            if result.robot_ends
            else message[:1].upper() + message[1:],
        },
        "headline": _headline(result),
        "contents": [
            {"id": key, "title": title, "parts": []}
            for key, title, shown in (
                ("headline", "Headline", True),
                ("plots", "Plots", True),
                ("metrics", "Metrics", True),
                ("situations", "Situations", situations),
                ("encounters", "Encounters", encounters),
                ("people", "People", people),
                ("by-behavior", "Metrics by behavior", by_behavior),
                ("provenance", "Provenance", True),
            )
            if shown
        ],
        "figures": _figures(result),
        "metrics": _metrics(result),
        "situations": situations,
        "encounters": encounters,
        "period": run.period,
        "people": people,
        "by_behavior": split_by_family(by_behavior) if by_behavior else [],
        "provenance": provenance_table(result.provenance),
    }


def _figures(result: TrialResult) -> list[ReportFigure]:
    run = result.recording
    trajectories = (
        "Trajectories of the robots and the people. Discs show the start"
        " positions in true size, stars are the goals, and dots and numbers"
        " mark the time in seconds."
        if run.others
        else "Trajectories of the robot and the people. Discs show the start"
        " positions in true size, the star is the goal (if there is one), and"
        " dots and numbers mark the time in seconds."
    )
    captions = [
        trajectories,
        "Distance to the closest person, from surface to surface. The bands"
        " are the proxemic zones around a person; a triangle marks the closest"
        f" point of each approach within {NEAR:g} m.",
        f"Forward speed of the robots. Strips mark when a person is within"
        f" {NEAR:g} m."
        if run.others
        else f"Forward speed of the robot. Shaded: a person is within {NEAR:g}"
        " m.",
    ]
    if not run.num_humans:
        return run_figures(run, "", captions, _SERIES)
    captions.append(
        f"Share of time that {'each' if run.others else 'the'} robot spent in"
        " each proxemic zone of the closest person."
    )
    activity = make_figure(
        "activity",
        f"Timeline of people's reactions to the robot{'s' * bool(run.others)}."
        " Each row is a person,"
        " colored by behavior while the person reacts.",
        (COLUMN, activity_height(run.num_humans)),
        lambda ax: plot_behavior_activity(run, ax=ax),
    )
    situations = make_figure(
        "situations",
        "Timeline of the social situations of"
        f" {'each' if run.others else 'the'} robot: at each time, the first of"
        " those that hold. The legend has their shares of the time.",
        (COLUMN, situations_height(len(run.robots))),
        lambda ax: plot_situations(run, ax=ax),
    )
    return [*run_figures(run, "", captions, _SERIES), situations, activity]


def _headline(result: TrialResult) -> Table:
    """Returns the table of headline metrics."""
    rows = MetricRows(result.tables, by_family=False)
    return _values(result, headline_of(result.tables), rows)


def _metrics(result: TrialResult) -> list[Table]:
    """Returns a table for each family of metrics."""
    rows = MetricRows(result.tables)
    return split_by_family(_values(result, result.tables.values, rows))


def _values(
    result: TrialResult, names: Iterable[str], rows: MetricRows
) -> Table:
    """Returns a row for each metric; several robots have a column each."""
    metrics, robots = result.tables.values, []
    if result.recording.others:
        robots = [it.robot_name for it in result.recording.robots]
        names = dict.fromkeys(map(base_name, names))
    for name in names:
        columns = [*(f"{robot}.{name}" for robot in robots), name]
        # (A user may have dropped it from the table.)
        if not (known := [it for it in columns if it in metrics]):
            continue
        first = known[0]
        unit = unit_of(result.tables, first)
        cells: list[Cell] = [
            number(metrics[it], unit) if it in metrics else "" for it in columns
        ]
        rows.add(first, cells, unit, name)
    head = ["metric", *robots, "all robots", "unit"] if robots else []
    return Table(head, rows.groups, numbers=range(1, len(robots) + 2))


def _people(result: TrialResult) -> Table | None:
    run = result.recording
    if not run.num_humans:
        return None
    gaps = _gaps(run)
    active = who_reacts(np.asarray(run.behavior_status), run.social_signals)
    # Each sample covers the time until the next one.
    intervals = np.append(run.features.intervals, 0.0)
    rows = []
    for i, name in enumerate(run.human_names):
        seen = np.isfinite(gaps[:, i]).any()
        k = int(np.nanargmin(gaps[:, i])) if seen else 0
        group = run.group_ids[i]
        rows.append(
            [
                name,
                run.behaviors[i],
                str(group) if group >= 0 else number(math.nan),
                number(float(gaps[k, i]) if seen else math.nan),
                number(float(run.times[k]) if seen else math.nan),
                number(float(intervals[active[:, i]].sum())),
            ]
        )
    head = [
        "person",
        "behavior",
        "group",
        "minimum distance (m)",
        "at time (s)",
        "time reacting (s)",
    ]
    return Table(head, {"": rows}, numbers=[2, 3, 4, 5])


def _situations(run: Recording) -> Table:
    """Returns the labels that hold at some time, by robot."""
    groups = {}
    for it in run.robots:
        found = FindSituations(run, robot=it.robot_name).by_label
        groups[it.robot_name if run.others else ""] = [
            [
                label,
                number(100 * row.share, "%"),
                number(100 * row.primary, "%"),
                number(row.episodes, "-"),
                number(row.episode_time, "s"),
            ]
            for label, row in found.items()
            if row.share > 0
        ]
    head = [
        "situation",
        "share of time (%)",
        "as the first that holds (%)",
        "episodes",
        "time in episodes (s)",
    ]
    return Table(head, groups, numbers=range(1, len(head)))


def _encounters(run: Recording, encounters: Mapping[str, Encounters]) -> Table:
    """Returns how near each person came to each robot, and how long."""
    units = {
        LEAST_GAP: "m",
        "min_gap_time": "s",
        **{f"time_in_{zone}": "s" for zone in _ZONES},
        **{f"entries_{zone}": "-" for zone in _ZONES},
        "crossings_in_front": "-",
    }
    groups = {}
    for robot, found in encounters.items():
        columns = {it: found.by_person[it].tolist() for it in units}
        groups[robot if run.others else ""] = [
            [
                person,
                *(number(columns[it][i], unit) for it, unit in units.items()),
            ]
            for i, person in enumerate(run.human_names)
        ]
    head = [
        "person",
        "least gap (m)",
        "at time (s)",
        *(f"in {zone} zone (s)" for zone in _ZONES),
        *(f"entries, {zone}" for zone in _ZONES),
        "crossed in front",
    ]
    return Table(head, groups, numbers=range(1, len(head)))


def _gaps(run: Recording) -> Array:
    """Returns the gap of each person to the closest robot before its end."""
    rows: Array = np.full((len(run), run.num_humans), np.nan)
    for it in run.robots:
        part = it.until_end().features.gaps
        rows[: len(part)] = np.fmin(rows[: len(part)], part)
    return rows


def _by_behavior(result: TrialResult) -> Table | None:
    by_behavior = result.tables.values_by_behavior
    if len(by_behavior) < 2:
        return None
    rows, everyone = MetricRows(result.tables), result.tables.values
    for name in next(iter(by_behavior.values())):
        if is_about_robot_alone(name):
            continue
        unit = unit_of(result.tables, name)
        values = [everyone.get(name, math.nan)]
        values += [it[name] for it in by_behavior.values()]
        cells: list[Cell] = [number(value, unit) for value in values]
        rows.add(name, cells, unit)
    if not rows.groups:
        return None
    head = ["metric", "all people", *by_behavior, "unit"]
    return Table(head, rows.groups, numbers=range(1, len(head) - 1))


def is_about_robot_alone(name: str) -> bool:
    """Returns whether a metric does not depend on any person."""
    name = base_name(name)
    return is_built_in(name) and (
        METRICS[name].family in _ROBOT_FAMILIES or name in _ROBOT_METRICS
    )
