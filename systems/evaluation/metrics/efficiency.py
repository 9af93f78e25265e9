"""How direct the robot's path was, and how steadily it moved."""

from functools import partial

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import YAW
from hunav_drake.systems.common.poses import wrap_angles
from hunav_drake.systems.evaluation.metric import register_metric
from hunav_drake.systems.evaluation.metrics import reduce
from hunav_drake.systems.evaluation.metrics.path import since_previous
from hunav_drake.systems.evaluation.metrics.speeds import STILL_SPEED
from hunav_drake.systems.evaluation.path_features import polyline_length
from hunav_drake.systems.evaluation.recording import Recording

_metric = partial(register_metric, family="efficiency")

GAO_HUANG = "Gao & Huang 2022"
FRANCIS = "Francis et al. 2025"

# For shorter legs of a way nobody has to turn, in meters.
_LEG = 0.01

# A path that is shorter is rounding, in meters.
_STILL = 1e-9


@_metric(
    unit="rad/m",
    direction="lower",
    source=f"SEAN 2.0, Tsoi et al. 2022; {GAO_HUANG}",
)
def path_irregularity(recording: Recording) -> float:
    """How much more than needed the robot turned, for its path's length.

    max(0, sum |wrap(yaw_{k+1} - yaw_k)| - A) / L, where L is the length of
    the path and A the least rotation of a robot that drives forward: from the
    first heading into the shortest way around the walls to the last position,
    along it, and from there to the last heading. Legs of less than 1 cm need
    no rotation. NaN if the robot never moved (1e-9 m), if walls leave no way,
    or if they are not known.
    """
    way = recording.path_features
    if way.length < _STILL or way.shortest_to_end is None:
        return np.nan
    legs = np.diff(way.shortest_to_end, axis=0)
    legs = legs[np.hypot(legs[:, 0], legs[:, 1]) >= _LEG]
    yaw = recording.robot[:, YAW]
    headings = [yaw[:1], np.arctan2(legs[:, 1], legs[:, 0]), yaw[-1:]]
    least = np.abs(wrap_angles(np.diff(np.concatenate(headings)))).sum()
    turned = recording.features.heading_changes.sum()
    return float(max(turned - least, 0.0) / way.length)


@_metric(unit="-", direction="higher", source=GAO_HUANG)
def path_efficiency(recording: Recording) -> float:
    """How direct the robot's path was, L* / max(L, L*), in [0, 1].

    L is the length of the path, and L* that of the shortest way from its
    first to its last position: straight, or around the walls at the distance
    of the robot's radius. NaN if the robot never moved, if walls leave no
    way, or if they are not known.
    """
    way = recording.path_features
    if not way.length or way.shortest_to_end is None:
        return np.nan
    shortest = polyline_length(way.shortest_to_end)
    return float(shortest / max(way.length, shortest))


@_metric(
    unit="-",
    direction="higher",
    source=f"Anderson et al. 2018; {FRANCIS}",
    aliases=["spl"],
)
def success_weighted_path_length(recording: Recording) -> float:
    """SPL: how direct a way to the goal was, S L* / max(L, L*), in [0, 1].

    S is `completed`, L the length of the path, and L* that of the shortest
    way from the first position to the goal: straight, or around the walls at
    the distance of the robot's radius. 1 for a robot that starts and stays at
    the goal; NaN without a goal, if walls leave no way to it, or if they are
    not known.
    """
    way = recording.path_features
    if recording.goal is None or way.shortest_to_goal is None:
        return np.nan
    if not recording.features.at_goal[-1]:
        return 0.0
    shortest = polyline_length(way.shortest_to_goal)
    longest = max(way.length, shortest)
    return float(shortest / longest) if longest else 1.0


@_metric(unit="s", direction="lower", source=FRANCIS, reduce=reduce.total)
def stalled_time(recording: Recording) -> Array:
    """The total time in which the robot got nowhere, short of the goal.

    That is of the intervals with |p_{k+1} - p_k| / dt < 0.01 m/s that do not
    begin at the goal; turning on the spot is getting nowhere. Series: the
    time stalled since the sample before.
    """
    features = recording.features
    stalled = features.step_lengths < STILL_SPEED * features.intervals
    stalled &= ~features.at_goal[:-1]
    return since_previous(np.where(stalled, features.intervals, 0.0))
