"""The starts of people."""

from collections.abc import Sequence

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import MOTION_SIZE, YAW, Y
from hunav_drake.systems.common.random_streams import (
    Purpose,
    check_seed,
    draw_uniform,
)
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.names import people_ids


def draw_starts(
    humans: Sequence[HumanConfig], seed: int, jitter: float
) -> Array:
    """Returns the states (n, 6) in which people start, at rest, in W.

    Offsets of x and y from those of the configurations are drawn by the seed,
    uniformly in [-jitter, jitter) meters, except for recorded people. People
    without a number have that of
    `people_ids`.

    Raises:
        ValueError: If the seed is not a whole number in [0, 2^63).
    """
    check_seed(seed)
    states = np.zeros((len(humans), MOTION_SIZE))
    for state, human in zip(states, humans, strict=True):
        state[: YAW + 1] = human.pose
    if jitter:
        draws = draw_uniform(seed, people_ids(humans), Purpose.START_JITTER, 2)
        drawn = [human.track is None for human in humans]
        states[drawn, : Y + 1] += jitter * (2 * draws[drawn] - 1)
    return states
