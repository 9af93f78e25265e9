"""Grid distances from a plan for the critics, compiled by numba.

They are Manhattan distances, in cells: DWB's grid expands along rows and
columns, and through obstacles (dwb_critics, `MapGridCritic`).
"""

import math

import numba
import numpy as np

from hunav_drake.systems.common.kernels import (
    INTEGER,
    MATRIX,
    REAL,
    jit,
    jit_as,
)
from hunav_drake.systems.planning.costmap.raster import READ_CELLS

_FAR = 1 << 62


@jit_as(numba.int64[:, ::1], READ_CELLS, REAL, REAL, REAL, MATRIX, REAL, REAL)
def path_cells(costs, ox, oy, resolution, plan, end_x, end_y):
    """Returns the cells of a plan: shape (2, k), columns (row, column).

    They range from the first known cell on the map to where the plan leaves the
    map; there may be none. The last pose of the plan is moved to (end_x,
    end_y).
    """
    rows, columns = costs.shape
    cells = np.empty((2, 64), dtype=np.int64)
    size = 0
    x0 = 0.0
    y0 = 0.0
    for k in range(len(plan)):
        x1 = plan[k, 0]
        y1 = plan[k, 1]
        if k == len(plan) - 1:
            x1 = end_x
            y1 = end_y
        steps = 1
        if k > 0:
            length = math.hypot(x1 - x0, y1 - y0)
            if length > 2 * resolution:
                steps = math.ceil(length / resolution)
        else:
            x0 = x1
            y0 = y1
        for step in range(1, steps + 1):
            x = x0 + (x1 - x0) * (step / steps)
            y = y0 + (y1 - y0) * (step / steps)
            row = math.floor((y - oy) / resolution)
            column = math.floor((x - ox) / resolution)
            known = 0 <= row < rows and 0 <= column < columns
            if known:
                known = costs[row, column] != 255
            if known:
                if size == cells.shape[1]:
                    cells = np.concatenate((cells, cells), axis=1)
                cells[0, size] = row
                cells[1, size] = column
                size += 1
            elif size > 0:
                return cells[:, :size].copy()
        x0 = x1
        y0 = y1
    return cells[:, :size].copy()


@jit
def distance_from(cells, row, column):
    """Returns the distance of a cell from the nearest of `path_cells`.

    It is the Manhattan distance, in cells.
    """
    nearest = _FAR
    for k in range(cells.shape[1]):
        away = abs(cells[0, k] - row) + abs(cells[1, k] - column)
        nearest = min(nearest, away)
    return nearest


@jit_as(
    numba.types.UniTuple(numba.int64, 2),
    *(MATRIX, INTEGER, REAL, REAL, REAL, REAL, REAL),
)
def plan_span(poses, first, x, y, near, far, search):
    """Returns the local poses of a plan: the first index and the end index.

    The first one is nearer to (x, y) than `near`, searched from `first` on over
    a path length of `search`. The poses end before the next one farther than
    `far`. (-1, -1) if there are none.
    """
    begin = -1
    length = 0.0
    for k in range(first, len(poses)):
        if k > first:
            length += math.hypot(
                poses[k, 0] - poses[k - 1, 0], poses[k, 1] - poses[k - 1, 1]
            )
            if length > search:
                break
        if math.hypot(poses[k, 0] - x, poses[k, 1] - y) < near:
            begin = k
            break
    if begin < 0:
        return -1, -1
    end = begin
    while end < len(poses) and (
        math.hypot(poses[end, 0] - x, poses[end, 1] - y) <= far
    ):
        end += 1
    if end == begin:
        return -1, -1
    return begin, end
