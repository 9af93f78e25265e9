"""The nearest point of a wall, compiled by numba."""

import math

import numba
import numpy as np

from hunav_drake.systems.common.kernels import INDICES, MATRIX, jit, jit_as


@jit
def nearest_on_segments(x, y, segments, lo, hi):
    """Returns the nearest point (x, y) of some segments, and its distance^2.

    Args:
        x: Where from, in meters.
        y: Likewise.
        segments: Shape (s, 4): see `Obstacles`.
        lo: The first segment.
        hi: The one after the last; with none the distance is infinite.
    """
    best = math.inf
    best_x = 0.0
    best_y = 0.0
    for s in range(lo, hi):
        sx = segments[s, 0]
        sy = segments[s, 1]
        ax = segments[s, 2] - sx
        ay = segments[s, 3] - sy
        length2 = ax * ax + ay * ay
        t = 0.0
        if length2 > 0:
            t = ((x - sx) * ax + (y - sy) * ay) / length2
            t = min(max(t, 0.0), 1.0)
        px = sx + t * ax
        py = sy + t * ay
        d2 = (x - px) * (x - px) + (y - py) * (y - py)
        if d2 < best:
            best = d2
            best_x = px
            best_y = py
    return best_x, best_y, best


@jit_as(numba.float64[:, :, ::1], MATRIX, MATRIX, INDICES)
def nearest_on_shapes(points, segments, first):
    """Returns the nearest point of each shape to each point.

    Args:
        points: Shape (m, 2), in meters.
        segments: Shape (s, 4): see `Obstacles`.
        first: Shape (k + 1,): see `Obstacles`.

    Returns:
        Shape (m, k, 2), in meters.
    """
    shapes = len(first) - 1
    nearest = np.empty((len(points), shapes, 2))
    for i in range(len(points)):
        for k in range(shapes):
            x, y, _ = nearest_on_segments(
                points[i, 0], points[i, 1], segments, first[k], first[k + 1]
            )
            nearest[i, k, 0] = x
            nearest[i, k, 1] = y
    return nearest
