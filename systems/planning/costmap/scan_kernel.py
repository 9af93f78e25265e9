"""Clearing and marking of cells by a lidar scan, compiled by numba."""

import math

import numba

from hunav_drake.systems.common.kernels import MATRIX, REAL, jit, jit_as
from hunav_drake.systems.planning.costmap.raster import CELLS


@jit
def _clear_line(costs, row, column, to_row, to_column, most):
    """Frees at most `most` cells from one to another (Bresenham)."""
    rows, columns = costs.shape
    d_row = abs(to_row - row)
    d_column = abs(to_column - column)
    step_row = 1 if to_row >= row else -1
    step_column = 1 if to_column >= column else -1
    error = d_column - d_row
    for _ in range(most):
        if not (0 <= row < rows and 0 <= column < columns):
            return
        # The end itself is what the ray has hit.
        if row == to_row and column == to_column:
            return
        costs[row, column] = 0
        twice = 2 * error
        if twice > -d_row:
            error -= d_row
            column += step_column
        if twice < d_column:
            error += d_column
            row += step_row


@jit_as(numba.void, CELLS, REAL, REAL, REAL, REAL, REAL, MATRIX, REAL, REAL)
def clear_and_mark(costs, ox, oy, resolution, x, y, ends, clearing, marking):
    """Writes one scan: free along its rays, lethal at their ends.

    `costs` are those of a `Costmap` with its origin at (ox, oy). The rays run
    from (x, y) to `ends`, rows (x, y, range), and clear up to the range
    `clearing`; their ends within the range `marking` are marked. All rays clear
    before the first end is marked, as in costmap_2d. In W, in meters.
    """
    rows, columns = costs.shape
    row = math.floor((y - oy) / resolution)
    column = math.floor((x - ox) / resolution)
    for i in range(len(ends)):
        reach = ends[i, 2]
        part = 1.0
        if reach > clearing:
            part = clearing / reach
        to_row = math.floor((y + part * (ends[i, 1] - y) - oy) / resolution)
        to_column = math.floor((x + part * (ends[i, 0] - x) - ox) / resolution)
        _clear_line(costs, row, column, to_row, to_column, rows + columns)
    for i in range(len(ends)):
        if ends[i, 2] >= marking:
            continue
        to_row = math.floor((ends[i, 1] - oy) / resolution)
        to_column = math.floor((ends[i, 0] - ox) / resolution)
        if 0 <= to_row < rows and 0 <= to_column < columns:
            costs[to_row, to_column] = 254
