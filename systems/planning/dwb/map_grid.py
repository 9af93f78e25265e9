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

_FAR = 1 << 20


@jit
def mark_plan(costs, ox, oy, resolution, plan, end_x, end_y, distances):
    """Marks the cells of a plan with 0 and returns the last one.

    They range from the first known cell on the map to where the plan leaves the
    map; (-1, -1) if there is none. The last pose of the plan is moved to
    (end_x, end_y). `distances` of shape (0, 0) is not written.
    """
    rows, columns = costs.shape
    marks = distances.size > 0
    last_row = -1
    last_column = -1
    count = len(plan)
    x0 = 0.0
    y0 = 0.0
    for k in range(count):
        x1 = plan[k, 0]
        y1 = plan[k, 1]
        if k == count - 1:
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
                if marks:
                    distances[row, column] = 0
                last_row = row
                last_column = column
            elif last_row >= 0:
                return last_row, last_column
        x0 = x1
        y0 = y1
    return last_row, last_column


@jit_as(
    numba.types.Tuple(
        (numba.int32[:, ::1], numba.types.UniTuple(numba.int64, 2))
    ),
    *(READ_CELLS, REAL, REAL, REAL, MATRIX),
)
def path_distances(costs, ox, oy, resolution, plan):
    """Returns the distances of cells from a plan, and its last cell.

    The distances are Manhattan distances to the nearest cell of the plan, rows
    (x, y, yaw), in cells, shape (rows, columns). The last cell is (row,
    column), or (-1, -1) if no part of the plan is on the map.
    """
    rows, columns = costs.shape
    result = np.full((rows, columns), _FAR, dtype=np.int32)
    last = mark_plan(
        *(costs, ox, oy, resolution, plan), *(plan[-1, 0], plan[-1, 1], result)
    )
    # First along the rows of the plan, then along all columns.
    for i in range(rows):
        near = np.int32(_FAR)
        for j in range(columns):
            near = min(near + 1, result[i, j])
            result[i, j] = near
        if near >= _FAR:
            result[i, :] = _FAR
            continue
        for j in range(columns - 1, -1, -1):
            near = min(near + 1, result[i, j])
            result[i, j] = near
    for i in range(1, rows):
        for j in range(columns):
            result[i, j] = min(result[i, j], result[i - 1, j] + 1)
    for i in range(rows - 2, -1, -1):
        for j in range(columns):
            result[i, j] = min(result[i, j], result[i + 1, j] + 1)
    return result, last


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
