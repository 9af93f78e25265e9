"""The surprise of people who see the robot.

People see the robot within 60 degrees of their heading, unless a wall occludes
it. d is the distance of the centers, at least 0.05 m.
"""

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.evaluation.encounter_features import HALF_FIELD_OF_VIEW
from hunav_drake.systems.evaluation.metrics.danger import (
    LEAST_DISTANCE,
    SINGAMANENI,
)
from hunav_drake.systems.evaluation.metrics.proxemics import INTIMATE
from hunav_drake.systems.evaluation.metrics.rates import register_sum_and_rate
from hunav_drake.systems.evaluation.recording import Recording

# The time to recognize an object that comes into view, and the time to react to
# it, in seconds.
RECOGNITION_TIME, REACTION_TIME = 0.15, 0.6

_sum_and_rate = register_sum_and_rate(
    unit="-", family="surprise", source=SINGAMANENI
)


def _cost(recording: Recording, factor: Array) -> Array:
    """Returns the sum of factor 0.45 m / d over the people who see the robot.

    NaN if the walls, which may occlude it, are not known.
    """
    if not recording.walls_known:
        return np.full(len(recording), np.nan)
    pairs = recording.encounters
    distance = np.maximum(pairs.distance, LEAST_DISTANCE)
    return np.where(pairs.visible, factor * INTIMATE / distance, 0.0).sum(1)


@_sum_and_rate
def surprise_visibility_cost(recording: Recording) -> Array:
    """The angle of the robot in the view of people.

    sum_{k,i} (0.45 m / d) (a / 60 deg) over the people who see the robot, where
    d is the distance of the centers, at least 0.05 m, and a the angle between
    their heading and the direction to it. People see 60 degrees to either side,
    but not through walls. 0 without people; NaN if the walls are not known.
    Series: the sum over people.
    """
    angle = recording.encounters.angle_of_view
    return _cost(recording, angle / HALF_FIELD_OF_VIEW)


@_sum_and_rate
def surprise_shock_cost(recording: Recording) -> Array:
    """The shock caused by a robot before it is recognized.

    sum_{k,i} (0.45 m / d) max(0, 1 - t / 0.15 s) over the people who see the
    robot, where d is the distance of the centers, at least 0.05 m, and t the
    time since it came into view, as in `surprise_visibility_cost`. A robot in
    view from a person's first sample on does not count. 0 without people; NaN
    if the walls are not known. Series: the sum over people.
    """
    seen = recording.encounters.seen_for
    return _cost(recording, np.maximum(1 - seen / RECOGNITION_TIME, 0.0))


@_sum_and_rate
def surprise_react_cost(recording: Recording) -> Array:
    """The surprise caused by a robot before people can react to it.

    sum_{k,i} (0.45 m / d) max(0, 1 - t / 0.6 s) over the people who see the
    robot, where d is the distance of the centers, at least 0.05 m, and t the
    time since it came into view, as in `surprise_visibility_cost`. A robot in
    view from a person's first sample on does not count. 0 without people; NaN
    if the walls are not known. Series: the sum over people.
    """
    seen = recording.encounters.seen_for
    return _cost(recording, np.maximum(1 - seen / REACTION_TIME, 0.0))
