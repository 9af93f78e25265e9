"""Random numbers that belong to a person and a purpose.

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


def check_seed(seed: int) -> int:
    """Returns a seed, which is a whole number in [0, 2^63).

    Raises:
        ValueError: If it is not.
    """
    if (
        isinstance(seed, int | np.integer)
        and not isinstance(seed, bool)
        and 0 <= seed < 2**63
    ):
        return int(seed)
    raise ValueError(f"seed must be a whole number in [0, 2^63), got {seed!r}")


def draw_uniform(
    seed: int, human_id: int, purpose: Purpose, size: int
) -> NDArray[np.float64]:
    """Returns numbers in [0, 1), the same for the same arguments.

    Args:
        seed: The seed of the trial, in [0, 2^63).
        human_id: The id of the person, >= 0.
        purpose: What the numbers are for.
        size: How many.

    Raises:
        ValueError: If the seed is not such a number.
    """
    return _generator(seed, human_id, purpose).random(size)


def draw_normal(
    seed: int, human_id: int, purpose: Purpose, size: int
) -> NDArray[np.float64]:
    """Returns normally distributed numbers of mean 0 and deviation 1.

    The arguments are those of `draw_uniform`, and the numbers are the same for
    the same arguments.
    """
    return _generator(seed, human_id, purpose).standard_normal(size)


def _generator(
    seed: int, human_id: int, purpose: Purpose
) -> np.random.Generator:
    return np.random.Generator(
        np.random.Philox(
            key=[check_seed(seed), human_id], counter=[0, 0, int(purpose), 0]
        )
    )
