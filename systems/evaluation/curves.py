"""Lines of sight, winding numbers and time warping, compiled by numba."""

import math

from numba import boolean
import numpy as np

from hunav_drake.systems.common.kernels import MATRIX, REAL, WALLS, jit, jit_as
from hunav_drake.systems.world.nearest import nearest_on_segments
from hunav_drake.systems.world.ray_cast import first_hit
from hunav_drake.systems.world.walls import opened


@jit_as(boolean[::1], MATRIX, WALLS)
def lines_blocked(lines, table):
    """Returns which lines (m, 4), rows (x0, y0, x1, y1), meet a wall."""
    walls = opened(table)
    blocked = np.empty(len(lines), dtype=np.bool_)
    for i in range(len(lines)):
        part = first_hit(
            lines[i, 0], lines[i, 1], lines[i, 2], lines[i, 3], walls
        )
        blocked[i] = part < math.inf
    return blocked


@jit
def _turns(ax, ay, bx, by):
    """Returns the crossing of the negative x axis by a step from a to b.

    1 for counterclockwise, -1 for clockwise, or 0. Points on the axis count as
    above it.
    """
    if (ay >= 0) == (by >= 0):
        return 0
    # The x of the crossing, times a positive number for a downward step.
    x = ax * by - ay * bx
    if ay >= 0:
        return 1 if x > 0 else 0
    return -1 if x < 0 else 0


@jit_as(REAL, MATRIX, MATRIX)
def total_winding(x, y):
    """Returns the sum of the winding numbers of all pairs.

    A winding number is |change of bearing| / (2 pi). The bearing between two of
    m bodies at x, y, shape (N + 1, m), is followed in straight steps from
    sample to sample while both are present (not NaN). After an absence it
    continues from the new bearing.
    """
    total = 0.0
    for i in range(x.shape[1]):
        for j in range(i):
            angle = 0.0
            turns = 0
            there = False
            dx = dy = 0.0
            for k in range(len(x)):
                # Adding 0 makes -0 positive; atan2 distinguishes the two.
                ex = x[k, j] - x[k, i] + 0.0
                ey = y[k, j] - y[k, i] + 0.0
                present = not math.isnan(ex)
                if there and present:
                    turns += _turns(dx, dy, ex, ey)
                elif present:
                    angle -= math.atan2(ey, ex)
                elif there:
                    angle += math.atan2(dy, dx)
                there, dx, dy = present, ex, ey
            if there:
                angle += math.atan2(dy, dx)
            total += abs(angle / (2 * math.pi) + turns)
    return total


@jit_as(REAL, MATRIX, MATRIX)
def warped_distance(a, b):
    """Returns the asymmetric dynamic time warping distance of two curves.

    Each point of b is matched to a segment of a, in the order of both, so that
    the sum of distances is minimal; the result is its mean per point. C(i, j) =
    min(C(i - 1, j), C(i, j - 1) + distance(segment i, point j)).
    """
    count = max(len(a) - 1, 1)
    segments = np.empty((count, 4))
    for i in range(count):
        after = min(i + 1, len(a) - 1)
        segments[i] = (a[i, 0], a[i, 1], a[after, 0], a[after, 1])
    cost = np.full(len(b), np.inf)
    for i in range(count):
        before = 0.0
        for j in range(len(b)):
            _, _, d2 = nearest_on_segments(b[j, 0], b[j, 1], segments, i, i + 1)
            before = min(cost[j], before + math.sqrt(d2))
            cost[j] = before
    return cost[-1] / len(b)
