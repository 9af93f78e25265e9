"""When people react to robots."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.scene.overlays.tags import calm_activities


def reactions(
    times: Array, status: NDArray[Any] | None, signals: Array | None
) -> Iterator[tuple[int, float, float]]:
    """Yields who reacts to a robot, by row, and from when to when, in seconds.

    What people do with places and each other, such as to sit, queue or talk, is
    no reaction, although it has a status, too.

    Args:
        times: Shape (N + 1,), in seconds.
        status: The status of behaviors, shape (N + 1, n), or None.
        signals: Shape (N + 1, n, 22), or None.
    """
    if status is None:
        return
    reacts = status != 0
    for k in np.flatnonzero(reacts.any(axis=1)).tolist():
        row = None if signals is None else signals[k]
        reacts[k] &= [not it for it in calm_activities(row, status.shape[1])]
    # (What people do is shown from the second sample on.)
    reacts[:1] = False
    for i in range(status.shape[1]):
        for begin, end in stretches(times, reacts[:, i]):
            yield i, begin, end


def stretches(times: Array, mask: Mask) -> Iterator[tuple[float, float]]:
    """Yields begin and end of the times at which a mask is true, in seconds.

    Args:
        times: Shape (N + 1,).
        mask: Shape (N + 1,).
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask, [0]])))
    for begin, end in edges.reshape(-1, 2).tolist():
        yield float(times[begin]), float(times[min(end, len(times) - 1)])
