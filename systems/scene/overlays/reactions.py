"""When people react to robots."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import Activity, Signal
from hunav_drake.systems.scene.overlays.tags import WORDS

# What people do that has a status, and is no reaction to a robot.
_CALM = [*WORDS.keys() - {Activity.ACCOMPANY, Activity.WAIT}]


def reactions(
    times: Array, status: NDArray[Any] | None, signals: Array | None
) -> Iterator[tuple[int, float, float]]:
    """Yields who reacts to a robot, by row, and from when to when, in seconds.

    Args:
        times: Shape (N + 1,), in seconds.
        status: The status of behaviors, shape (N + 1, n), or None.
        signals: Shape (N + 1, n, 22), or None.
    """
    if status is None:
        return
    reacts = who_reacts(status, signals)
    for i in range(status.shape[1]):
        for begin, end in stretches(times, reacts[:, i]):
            yield i, begin, end


def is_calm(signals: Array) -> Mask:
    """Returns whether what people do is no reaction to a robot, by row.

    So it is with what they do with places and each other, such as to sit, queue
    or talk, although it has a status, too.

    Args:
        signals: Shape (..., 22), rows of `layout.Signal`.
    """
    calm: Mask = np.isin(signals[..., Signal.ACTIVITY], _CALM)
    return calm


def who_reacts(status: NDArray[Any], signals: Array | None) -> Mask:
    """Returns who reacts to a robot: shape (N + 1, n); see `is_calm`.

    Args:
        status: The status of behaviors, shape (N + 1, n).
        signals: Shape (N + 1, n, 22), or None.
    """
    reacts: Mask = status != 0
    if signals is not None:
        reacts &= ~is_calm(signals)
        # (What people do is shown from the second sample on.)
        reacts[:1] &= reacts[1:2] if len(reacts) > 1 else False
    return reacts


def stretches(times: Array, mask: Mask) -> Iterator[tuple[float, float]]:
    """Yields begin and end of the times at which a mask is true, in seconds.

    Args:
        times: Shape (N + 1,).
        mask: Shape (N + 1,).
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask, [0]])))
    for begin, end in edges.reshape(-1, 2).tolist():
        yield float(times[begin]), float(times[min(end, len(times) - 1)])
