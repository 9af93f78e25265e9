"""Where a straight line meets the walls, compiled by numba."""

import math

from numba import float64

from hunav_drake.systems.common.kernels import MATRIX, REAL, jit_as


@jit_as(float64, REAL, REAL, REAL, REAL, MATRIX)
def wall_on_line(px, py, qx, qy, segments):
    """Returns how much of the line from p to q is before the first wall.

    A wall that only touches the line counts or not as if the line were moved
    by a hair, so that no line slips through the joint of two segments.

    Args:
        px: Where from, in meters.
        py: Likewise.
        qx: Where to, in meters.
        qy: Likewise.
        segments: Shape (s, 4): see `Obstacles`.

    Returns:
        The fraction of the line, in [0, 1]; infinity if no wall is on it.
    """
    best = math.inf
    dx = qx - px
    dy = qy - py
    for s in range(len(segments)):
        ax = segments[s, 0] - px
        ay = segments[s, 1] - py
        bx = segments[s, 2] - px
        by = segments[s, 3] - py
        # On which side of the line the ends of the segment are.
        a = dx * ay - dy * ax
        b = dx * by - dy * bx
        if (a >= 0) == (b >= 0):
            continue
        # Where the segment meets the line through p and q.
        part = a / (a - b)
        hx = ax + part * (bx - ax)
        hy = ay + part * (by - ay)
        along = (hx * dx + hy * dy) / (dx * dx + dy * dy)
        if 0 <= along <= 1 and along < best:
            best = along
    return best
