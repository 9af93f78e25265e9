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
    generator = np.random.Philox(
        key=[seed, human_id], counter=[0, tick, int(purpose), 0]
    )
    return np.random.Generator(generator).random(size)
