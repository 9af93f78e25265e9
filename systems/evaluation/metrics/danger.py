"""The danger of the robot's motion to people.

P is the vector from the robot's center to a person's, V = v_r - v_i the
velocity of the robot relative to the person, R the sum of their radii.
"""

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.evaluation.metric import register_metric
from hunav_drake.systems.evaluation.metrics.rates import register_sum_and_rate
from hunav_drake.systems.evaluation.recording import Recording

SINGAMANENI = "Singamaneni, Favier & Alami 2023"

# The minimum distance of centers in costs, in meters, which would otherwise be
# unbounded.
LEAST_DISTANCE = 0.05

# The same for the sine of an angle.
LEAST_SINE = 1e-9

_sum_and_rate = register_sum_and_rate(
    unit="1/s", family="danger", source=SINGAMANENI
)


@register_metric(
    unit="s",
    family="danger",
    direction="higher",
    source="SocNavBench, Biswas et al. 2022; Francis et al. 2025",
)
def min_time_to_collision(recording: Recording) -> tuple[float, Array]:
    """The shortest time to a collision at constant velocities.

    min_{k,i} of the first t >= 0 with |P - V t| = R; 0 where they overlap. NaN
    if nobody was ever on a collision course. Series: the minimum over people,
    NaN where there is none.
    """
    times = recording.encounters.time_to_collision
    finite = np.where(np.isinf(times), np.nan, times)
    series: Array = np.fmin.reduce(finite, axis=1, initial=np.nan)
    return float(np.fmin.reduce(series)), series


@_sum_and_rate
def danger_fear_cost(recording: Recording) -> Array:
    """The fear of an approaching robot: sum_{k,i} |V| / |P|.

    Only where P . V > 0. It is the inverse of a simple time to collision; |P|
    is at least 0.05 m. 0 without people. Series: the sum over people.
    """
    pairs = recording.encounters
    distance = np.maximum(pairs.distance, LEAST_DISTANCE)
    cost = np.where(pairs.closing > 0, pairs.relative_speed / distance, 0.0)
    return cost.sum(axis=1)


@_sum_and_rate
def danger_panic_cost(recording: Recording) -> Array:
    """The panic at a robot that passes closely.

    sum_{k,i} |V| / ((d - R) |sin a|), where a is the angle between P and V and
    d = |P| |sin a| the distance at which the centers pass. Only where P . V >
    0, because receding people have been passed, and d > R, because the fear
    cost counts collision courses. d - R is at least 0.05 m, and |sin a| at
    least 1e-9. 0 without people. Series: the sum over people.
    """
    pairs = recording.encounters
    passing = pairs.passing_distance
    passes = (passing > pairs.reach) & (pairs.closing > 0)
    miss = np.maximum(passing - pairs.reach, LEAST_DISTANCE)
    sine = np.where(passes, passing / np.where(passes, pairs.distance, 1), 1)
    sine = np.maximum(sine, LEAST_SINE)
    cost = np.where(passes, pairs.relative_speed / (miss * sine), 0.0)
    return cost.sum(axis=1)
