"""Whether, when, and how closely the robot reached its goal."""

from functools import partial

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.evaluation.metric import register_metric
from hunav_drake.systems.evaluation.metrics import reduce
from hunav_drake.systems.evaluation.metrics.path import PEREZ_2018
from hunav_drake.systems.evaluation.recording import Recording

_metric = partial(register_metric, family="goal")

SEAN = "SEAN 2.0, Tsoi et al. 2022"


@_metric(unit="s", direction="lower", source=PEREZ_2018)
def time_to_reach_goal(recording: Recording) -> float:
    """The time from the start to the first sample at the goal.

    At the goal means closer than the goal tolerance, with a heading error of at
    most the yaw tolerance. NaN if the robot never is, or has no goal.
    """
    at_goal = recording.features.at_goal
    if not at_goal.any():
        return np.nan
    return float(recording.times[at_goal.argmax()] - recording.times[0])


@_metric(unit="-", direction="higher", source=SEAN)
def completed(recording: Recording) -> float:
    """1 if the robot is at the goal in the last sample, else 0.

    At the goal means closer than the goal tolerance, |p_N - g| < r_g, with a
    heading error of at most the yaw tolerance. NaN without a goal.
    """
    if recording.goal is None:
        return np.nan
    return float(recording.features.at_goal[-1])


@_metric(
    unit="m",
    direction="lower",
    source=SEAN,
    aliases=["minimum_distance_to_target"],
)
def min_dist_to_target(recording: Recording) -> float:
    """The minimum distance from the goal, min_k |p_k - g|.

    NaN without a goal.
    """
    return float(recording.features.goal_distance.min())


@_metric(
    unit="m",
    direction="lower",
    source=SEAN,
    aliases=["final_distance_to_target"],
    reduce=reduce.last,
)
def final_dist_to_target(recording: Recording) -> Array:
    """The final distance from the goal, |p_N - g|.

    NaN without a goal. Series: the distance from the goal.
    """
    return recording.features.goal_distance
