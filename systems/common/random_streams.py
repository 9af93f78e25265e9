"""Random numbers that belong to a person and a purpose.

A draw is a function of its purpose, not of previous draws: adding or removing a
person does not change the draws of others.
"""

from collections.abc import Iterator, Sequence
from enum import IntEnum

import numpy as np

from hunav_drake.systems.common.arrays import Array

# A seed is kept as two numbers below this.
_HALF = 2**32


class Purpose(IntEnum):
    """The purpose of a draw; each has numbers of its own."""

    START_JITTER = 1
    WEIGHTS_NORMAL = 2
    WEIGHTS_UNIFORM = 3
    POPULATION_BODY = 4
    POPULATION_BEHAVIOR = 5
    POPULATION_GROUP = 6
    POPULATION_START = 7
    POPULATION_MEMBER = 8
    POPULATION_GOAL = 9
    POPULATION_ORDER = 10
    POPULATION_SINK = 11
    SOURCE_PLACE = 12
    ARRIVAL_TIME = 13
    ARRIVAL_PLACE = 14
    REACTION = 15
    LIDAR_NOISE = 20
    WORLD = 21
    LIDAR_DROPOUT = 22
    MISSED_DETECTION = 23
    DETECTION_NOISE = 24
    FALSE_DETECTION = 25
    LOCALIZATION = 26
    FALSE_VELOCITY = 27
    DECISION = 28
    SEARCH = 29
    POPULATION_FIGURE = 30
    POPULATION_NEEDS = 31


def check_seed(seed: int) -> int:
    """Returns a seed, checked to be a whole number in [0, 2^63).

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


def stream(seed: int, number: int, purpose: Purpose) -> np.random.Generator:
    """Returns the numbers of one purpose: those of a seed and a number."""
    return next(_streams(seed, [number], purpose))


def draw_uniform(
    seed: int,
    human_ids: Sequence[int],
    purpose: Purpose,
    size: int,
    *,
    step: int = 0,
) -> Array:
    """Returns numbers in [0, 1), of shape (n, size) for n people.

    A person's row follows from the seed, the person's id and the purpose alone.
    Repeated draws, as the noise of a sensor, have streams of their own for each
    step, a whole number from 0. Things other than people have numbers for ids,
    too.

    Raises:
        ValueError: If the seed is not a whole number in [0, 2^63).
    """
    streams = _streams(seed, human_ids, purpose, step)
    return np.array([stream.random(size) for stream in streams]).reshape(
        len(human_ids), size
    )


def draw_normal(
    seed: int,
    human_ids: Sequence[int],
    purpose: Purpose,
    size: int,
    *,
    step: int = 0,
    branch: int = 0,
) -> Array:
    """Returns normally distributed numbers of mean 0 and deviation 1.

    Other numbers follow for each branch, a whole number from 0. All else is as
    for `draw_uniform`.
    """
    streams = _streams(seed, human_ids, purpose, step, branch)
    return np.array(
        [stream.standard_normal(size) for stream in streams]
    ).reshape(len(human_ids), size)


def _streams(
    seed: int,
    human_ids: Sequence[int],
    purpose: Purpose,
    step: int = 0,
    branch: int = 0,
) -> Iterator[np.random.Generator]:
    """Yields, for each person, a generator at the start of their stream."""
    # One generator is moved from stream to stream: making one takes ten times
    # as long.
    bits = np.random.Philox(
        key=[check_seed(seed), 0], counter=[0, branch, int(purpose), step]
    )
    generator = np.random.Generator(bits)
    start = bits.state
    for human_id in human_ids:
        start["state"]["key"][1] = human_id
        bits.state = start
        yield generator


def seed_to_halves(seed: int) -> Array:
    """Returns a seed as two numbers, which doubles hold exactly."""
    return np.array(divmod(int(seed), _HALF), dtype=float)


def halves_to_seed(halves: Array) -> int:
    """Returns the seed that `seed_to_halves` was given."""
    high, low = halves
    return int(high) * _HALF + int(low)
