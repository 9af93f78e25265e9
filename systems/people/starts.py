"""Where people start."""

from collections.abc import Sequence

import numpy as np

from hunav_drake.systems.common.arrays import Array
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
    """Returns the poses (n, 3) at which people start: x, y, yaw in W.

    Offsets of x and y from those of the configurations are drawn by the seed,
    evenly from [-jitter, jitter) meters. Those without a number have the one
    that `people_ids` gives.

    Raises:
        ValueError: If the seed is not a whole number in [0, 2^63).
    """
    check_seed(seed)
    poses = np.array([human.pose for human in humans]).reshape(len(humans), 3)
    if jitter:
        draws = draw_uniform(seed, people_ids(humans), Purpose.START_JITTER, 2)
        poses[:, :2] += jitter * (2 * draws - 1)
    return poses
