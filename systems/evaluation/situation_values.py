"""Metrics on the samples of each social situation."""

from collections.abc import Callable
from functools import partial

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.evaluation.compute import Evaluation
from hunav_drake.systems.evaluation.metric import METRICS, SITUATIONS_FAMILY
from hunav_drake.systems.evaluation.metrics import reduce
from hunav_drake.systems.evaluation.metrics.collisions import charged
from hunav_drake.systems.evaluation.metrics.contacts import largest_forces
from hunav_drake.systems.evaluation.metrics.replay import (
    reacting,
    replay_errors,
)
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.situation_labels import LABELS
from hunav_drake.systems.evaluation.situations import FindSituations

_ToNumbers = Callable[[Recording], Array]
_ToValue = Callable[[Array], float]

# What is told of a label itself: its name, and its column in `shares`.
_OF_LABELS = {
    "time_share": ("share", "-"),
    "primary_share": ("primary", "-"),
    "episodes": ("episodes", "-"),
    "episode_time": ("episode_time", "s"),
}

# Metrics without a series, by what they are the least of.
_LEAST = {
    "min_dist_to_people": "closest_gap",
    "min_dist_to_target": "goal_distance",
}

# The values on some samples of series that are no sums or means as they stand.
_REDUCED: dict[str, _ToValue] = {
    "min_time_to_collision": np.fmin.reduce,
    "space_compliance": lambda series: 100 * reduce.mean(series),
}


def _contacts(recording: Recording, *, to_robot: bool) -> Array:
    """Returns how many contacts begin at each sample: see `charged`."""
    return charged(recording, to_robot=to_robot).sum(axis=1, dtype=float)


# Metrics of which the series does not tell enough: what they are made of, shape
# (samples,) or (samples, people), and how.
_MADE_OF: dict[str, tuple[_ToNumbers, _ToValue]] = {
    "max_contact_force": (largest_forces, np.fmax.reduce),
    "replay_ade": (partial(replay_errors, at_phase=False), reduce.mean),
    "replay_ade_at_phase": (partial(replay_errors, at_phase=True), reduce.mean),
    "reactive_share": (reacting, reduce.mean),
    "robot_on_person_collisions": (
        partial(_contacts, to_robot=True),
        reduce.total,
    ),
    "person_on_robot_collisions": (
        partial(_contacts, to_robot=False),
        reduce.total,
    ),
}

# Their series grow by what happens, or are 1 while it lasts.
_COUNTED = (
    *("static_obstacle_collisions", "contacts_with_walls"),
    *("contacts_by_robot", "contacts_by_person", "contact_impulse"),
    *("hand_overs",),
)


def situation_values(
    recording: Recording, found: Evaluation
) -> dict[str, tuple[float, dict[str, str]]]:
    """Returns metrics on the samples of each label that ever holds, and shares.

    `path_length[passing]` is the sum of the series of `path_length` over the
    samples of the label "passing": what the value of the metric is made of,
    from these samples alone. Only metrics with a series have one, and the
    smallest distances; of users' metrics, those with `reduce`. There are also
    `time_share[passing]`, `primary_share[passing]`, `episodes[passing]` and
    `episode_time[passing]`: see `Situations.shares`. With several robots, their
    names and a dot come first.

    Args:
        recording: The recording.
        found: Its metrics, from `evaluate`.

    Returns:
        By name, the value, and its "units", "families" and "directions".
    """
    values = {}
    for robot in recording.robots:
        prefix = f"{robot.robot_name}." if recording.others else ""
        situations = FindSituations(recording, robot=robot.robot_name)
        series = _series(situations.recording, found, prefix)
        for label in LABELS:
            for name, (column, unit) in _OF_LABELS.items():
                value = float(getattr(situations.by_label[label], column))
                key = f"{prefix}{name}[{label}]"
                values[key] = value, _facts(unit, "none")
            mask = situations.flags[label]
            for name, (numbers, reduced) in (
                series.items() if mask.any() else ()
            ):
                metric = METRICS[name]
                facts = _facts(metric.unit, metric.direction)
                value = float(reduced(numbers[mask]))
                values[f"{prefix}{name}[{label}]"] = value, facts
    return values


def _facts(unit: str, direction: str) -> dict[str, str]:
    return {
        "units": unit,
        "families": SITUATIONS_FAMILY,
        "directions": direction,
    }


def _series(
    recording: Recording, found: Evaluation, prefix: str
) -> dict[str, tuple[Array, _ToValue]]:
    """Returns the series of metrics, and how values follow from them."""
    result: dict[str, tuple[Array, _ToValue]] = {}
    for key in found.values:
        name = key.removeprefix(prefix) if key.startswith(prefix) else ""
        if name in _LEAST:
            series = getattr(recording.features, _LEAST[name])
            result[name] = series, np.fmin.reduce
        elif name in _MADE_OF:
            numbers, how = _MADE_OF[name]
            result[name] = numbers(recording), how
        elif key in found.series and name in METRICS:
            series = found.series[key][: len(recording)]
            if name in _COUNTED:
                grown = np.maximum(np.diff(series, prepend=0.0), 0.0)
                result[name] = grown, reduce.total
            elif reduced := METRICS[name].reduce or _REDUCED.get(name):
                result[name] = series, reduced
    return result
