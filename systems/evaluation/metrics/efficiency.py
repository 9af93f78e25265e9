"""The directness of the robot's path and the steadiness of its motion."""

from functools import partial

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import YAW
from hunav_drake.systems.common.poses import wrap_angle
from hunav_drake.systems.evaluation.metric import register_metric
from hunav_drake.systems.evaluation.metrics import reduce
from hunav_drake.systems.evaluation.metrics.goal import time_to_reach_goal
from hunav_drake.systems.evaluation.metrics.path import since_previous
from hunav_drake.systems.evaluation.metrics.speeds import STILL_SPEED
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.way import Way

_metric = partial(register_metric, family="efficiency")

GAO_HUANG = "Gao & Huang 2022"
FRANCIS = "Francis et al. 2025"

# A shorter path needs no turn, in meters.
_SHORT = 0.01

# A shorter path is rounding, in meters.
_STILL = 1e-9


@_metric(
    unit="rad/m",
    direction="lower",
    source=f"SEAN 2.0, Tsoi et al. 2022; {GAO_HUANG}",
)
def path_irregularity(recording: Recording) -> float:
    """The robot's unnecessary rotation per length of its path.

    max(0, sum |wrap(yaw_{k+1} - yaw_k)| - A) / L, where L is the length of the
    path and A the minimum rotation of a robot that drives forward: from the
    first heading to the shortest path to the last position (of length L* in
    `path_efficiency`), along it, and from there to the last heading. A path of
    less than 1 cm needs none. NaN if the robot never moved (1e-9 m), and where
    there is no L*.
    """
    path = recording.path_features
    if path.length < _STILL or not path.shortest_to_end:
        return np.nan
    first, last = recording.robot[[0, -1], YAW].tolist()
    least = min(_rotation(first, way, last) for way in path.shortest_to_end)
    turned = recording.features.heading_changes.sum()
    return float(max(turned - least, 0.0) / path.length)


def _rotation(first: float, way: Way, last: float) -> float:
    """Returns the rotation from heading to heading along a path."""
    if way.length < _SHORT:
        return abs(wrap_angle(last - first))
    into = abs(wrap_angle(way.first_heading - first))
    out = abs(wrap_angle(last - way.last_heading))
    return into + way.turning + out


@_metric(unit="-", direction="higher", source=GAO_HUANG)
def path_efficiency(recording: Recording) -> float:
    """The directness of the robot's path, L* / max(L, L*), in [0, 1].

    L is the length of the path, and L* that of the shortest path from its first
    to its last position: a taut string around the walls inflated by the robot's
    radius (0.05 m at least), of straight legs and arcs of that radius around
    corners. Where the robot overlaps a wall at the start, the path leaves it on
    a straight leg; likewise at the end. NaN if the robot never moved, if walls
    leave no path, as where its center is inside a solid at the start or the
    end, or if they are not known.
    """
    path = recording.path_features
    if not path.length or not path.shortest_to_end:
        return np.nan
    shortest = path.shortest_to_end[0].length
    return float(shortest / max(path.length, shortest))


@_metric(
    unit="-",
    direction="higher",
    source=f"Anderson et al. 2018; {FRANCIS}",
    aliases=["spl"],
)
def success_weighted_path_length(recording: Recording) -> float:
    """SPL: success weighted by path length, S L* / max(L, L*), in [0, 1].

    S is `completed`, L the length of the path, and L* that of the shortest path
    from the first position to the goal, as in `path_efficiency`. 1 for a robot
    that starts and stays at the goal; NaN without a goal, and where there is no
    L*.
    """
    path = recording.path_features
    if not path.shortest_to_goal:
        return np.nan
    if not recording.features.at_goal[-1]:
        return 0.0
    shortest = path.shortest_to_goal[0].length
    longest = max(path.length, shortest)
    return float(shortest / longest) if longest else 1.0


@_metric(
    unit="-",
    direction="higher",
    source=f"iGibson Challenge 2021; {FRANCIS}",
    aliases=["stl"],
)
def success_weighted_time_length(recording: Recording) -> float:
    """STL: success weighted by time, S T* / max(T, T*), in [0, 1].

    S is `completed`, T is `time_to_reach_goal`, and T* = L* / v the time for
    the shortest path of `success_weighted_path_length` at the robot's maximum
    speed v; in the challenge, T* is the time of an oracle. 1 for a robot that
    starts and stays at the goal; NaN without a goal, where there is no L*, and
    if v is not known.
    """
    path = recording.path_features
    speed = recording.robot_max_speed
    if not path.shortest_to_goal or speed is None:
        return np.nan
    if not recording.features.at_goal[-1]:
        return 0.0
    least = path.shortest_to_goal[0].length / speed
    longest = max(time_to_reach_goal(recording), least)
    return float(least / longest) if longest else 1.0


@_metric(unit="s", direction="lower", source=FRANCIS, reduce=reduce.total)
def stalled_time(recording: Recording) -> Array:
    """The total time without progress away from the goal.

    It sums the intervals with |p_{k+1} - p_k| / dt < 0.01 m/s that do not begin
    at the goal; turning in place counts as stalled. Series: the time stalled
    since the previous sample.
    """
    features = recording.features
    stalled = features.step_lengths < STILL_SPEED * features.intervals
    stalled &= ~features.at_goal[:-1]
    return since_previous(np.where(stalled, features.intervals, 0.0))
