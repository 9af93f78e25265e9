"""How surprising the robot was to people who see it.

People see the robot within 60 degrees of their heading, unless a wall is
between. d is the distance of the centers, taken to be at least 0.05 m.
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

# How long it takes to recognize what comes into view, and to react to it, in
# seconds.
RECOGNITION_TIME, REACTION_TIME = 0.15, 0.6

_sum_and_rate = register_sum_and_rate(
    unit="-", family="surprise", source=SINGAMANENI
)


def _cost(recording: Recording, factor: Array) -> Array:
    """Returns the sum over who sees the robot of factor 0.45 m / d.

    NaN if the walls, which may hide it, are not known.
    """
    if not recording.walls_known:
        return np.full(len(recording), np.nan)
    pairs = recording.encounters
    distance = np.maximum(pairs.distance, LEAST_DISTANCE)
    return np.where(pairs.visible, factor * INTIMATE / distance, 0.0).sum(1)


@_sum_and_rate
def surprise_visibility_cost(recording: Recording) -> Array:
    """How far from where they look people see the robot.

    sum_{k,i} (0.45 m / d) (a / 60 deg) over who sees the robot, where d is
    the distance of the centers, taken to be at least 0.05 m, and a the angle
    between their heading and the direction to it. People see 60 degrees to
    either side, but not through walls. 0 without people; NaN if the walls are
    not known. Series: the sum over people.
    """
    angle = recording.encounters.angle_of_view
    return _cost(recording, angle / HALF_FIELD_OF_VIEW)


@_sum_and_rate
def surprise_shock_cost(recording: Recording) -> Array:
    """The shock at a robot before it is recognized.

    sum_{k,i} (0.45 m / d) max(0, 1 - t / 0.15 s) over who sees the robot,
    where d is the distance of the centers, taken to be at least 0.05 m, and t
    the time since it came into view, as in `surprise_visibility_cost`; nobody
    is surprised by what is in view from their first sample on. 0 without
    people; NaN if the walls are not known. Series: the sum over people.
    """
    seen = recording.encounters.seen_for
    return _cost(recording, np.maximum(1 - seen / RECOGNITION_TIME, 0.0))


@_sum_and_rate
def surprise_react_cost(recording: Recording) -> Array:
    """The surprise at a robot before there was time to react to it.

    sum_{k,i} (0.45 m / d) max(0, 1 - t / 0.6 s) over who sees the robot,
    where d is the distance of the centers, taken to be at least 0.05 m, and t
    the time since it came into view, as in `surprise_visibility_cost`; nobody
    is surprised by what is in view from their first sample on. 0 without
    people; NaN if the walls are not known. Series: the sum over people.
    """
    seen = recording.encounters.seen_for
    return _cost(recording, np.maximum(1 - seen / REACTION_TIME, 0.0))
