"""Random numbers that belong to a person and a moment.

A draw is a function of what it is for, not of what was drawn before: nobody
else's draws change when a person is added or removed.
"""

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray


class Purpose(IntEnum):
    """What a draw is for; each has numbers of its own."""

    START_JITTER = 1
    WEIGHTS_NORMAL = 2
    WEIGHTS_UNIFORM = 3


def draw_uniform(
    seed: int, human_id: int, purpose: Purpose, size: int, *, tick: int = 0
) -> NDArray[np.float64]:
    """Returns numbers in [0, 1), the same for the same arguments.

    Args:
        seed: The seed of the trial, >= 0.
        human_id: The id of the person, >= 0.
        purpose: What the numbers are for.
        size: How many.
        tick: The step of the trial that they are drawn in.
    """
    return _generator(seed, human_id, purpose, tick).random(size)


def draw_normal(
    seed: int, human_id: int, purpose: Purpose, size: int, *, tick: int = 0
) -> NDArray[np.float64]:
    """Returns normally distributed numbers of mean 0 and deviation 1.

    The arguments are those of `draw_uniform`, and the numbers are the same for
    the same arguments.
    """
    return _generator(seed, human_id, purpose, tick).standard_normal(size)


def _generator(
    seed: int, human_id: int, purpose: Purpose, tick: int
) -> np.random.Generator:
    return np.random.Generator(
        np.random.Philox(
            key=[seed, human_id], counter=[0, tick, int(purpose), 0]
        )
    )
