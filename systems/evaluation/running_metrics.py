"""The fast metrics that an Evaluator outputs during a trial."""

from enum import IntEnum
import math

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.layout import X, Y
from hunav_drake.systems.evaluation.samples import Sample


@explain
class RunningMetric(IntEnum):
    """Elements of the output port `metrics` of an Evaluator."""

    DURATION = 0
    """The time between the first sample and the last, in seconds."""

    PATH_LENGTH = 1
    """The length of the robot's path through the samples, in meters."""

    CLOSEST_GAP = 2
    """The gap to the closest person at the last sample, in meters."""

    MIN_GAP = 3
    """The smallest gap to anyone until now, in meters."""

    GOAL_DISTANCE = 4
    """The distance to the goal at the last sample, in meters."""

    COLLISIONS = 5
    """The number of contacts with people so far."""


def running_values(
    last: Sample, goal: tuple[float, float, float] | None
) -> Array:
    """Returns the values up to a sample, in the order of `RunningMetric`."""
    running = last.running
    values: Array = np.zeros(len(RunningMetric))
    if last.count:
        values[RunningMetric.DURATION] = last.time - last.first_time
    values[RunningMetric.PATH_LENGTH] = running.path_length
    values[RunningMetric.CLOSEST_GAP] = running.closest_gap
    values[RunningMetric.MIN_GAP] = running.min_gap
    values[RunningMetric.GOAL_DISTANCE] = np.nan
    values[RunningMetric.COLLISIONS] = running.collisions
    if goal is not None and last.count:
        values[RunningMetric.GOAL_DISTANCE] = math.hypot(
            last.robot[X] - goal[0], last.robot[Y] - goal[1]
        )
    return values
