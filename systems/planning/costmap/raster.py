"""Walls and people as cells of a grid, compiled by numba.

`costs` are those of a `Costmap`, written in place. (ox, oy) is its origin and
`resolution` the side length of a cell, in meters.
"""

import math

import numba
import numpy as np

from hunav_drake.systems.common.kernels import (
    MATRIX,
    REAL,
    VECTOR,
    WALLS,
    jit,
    jit_as,
)
from hunav_drake.systems.common.layout import X, Y
from hunav_drake.systems.world.walls import opened

CELLS = numba.types.Array(numba.uint8, 2, "C")
READ_CELLS = numba.types.Array(numba.uint8, 2, "C", readonly=True)
_LETHAL = 254


@jit
def _mark(costs, row, column):
    if 0 <= row < costs.shape[0] and 0 <= column < costs.shape[1]:
        costs[row, column] = _LETHAL


@jit
def _mark_segment(costs, ax, ay, bx, by):
    """Marks all cells that a segment crosses; its ends are in cells."""
    rows, columns = costs.shape
    dx = bx - ax
    dy = by - ay
    # Only the part on the grid (Liang and Barsky 1984).
    start = 0.0
    end = 1.0
    for p, q in ((-dx, ax), (dx, columns - ax), (-dy, ay), (dy, rows - ay)):
        if p == 0.0:
            if q < 0.0:
                return
        elif p < 0.0:
            start = max(start, q / p)
        else:
            end = min(end, q / p)
    if start > end:
        return
    # From cell to cell (Amanatides and Woo 1987).
    x = ax + start * dx
    y = ay + start * dy
    column = math.floor(x)
    row = math.floor(y)
    step_x = 1 if dx > 0 else -1
    step_y = 1 if dy > 0 else -1
    next_x = math.inf
    next_y = math.inf
    if dx != 0.0:
        next_x = (column + (dx > 0) - ax) / dx
    if dy != 0.0:
        next_y = (row + (dy > 0) - ay) / dy
    _mark(costs, row, column)
    while min(next_x, next_y) <= end:
        if next_x < next_y:
            column += step_x
            next_x += abs(1.0 / dx)
        else:
            row += step_y
            next_y += abs(1.0 / dy)
        _mark(costs, row, column)


@jit
def _fill_solid(costs, ox, oy, resolution, segments, first, last):
    """Marks the cells with their center inside an outline, even-odd."""
    rows, columns = costs.shape
    crossings = np.empty(last - first)
    for row in range(rows):
        y = oy + (row + 0.5) * resolution
        count = 0
        for s in range(first, last):
            y0 = segments[s, 1]
            y1 = segments[s, 3]
            if (y0 > y) != (y1 > y):
                part = (y - y0) / (y1 - y0)
                x0 = segments[s, 0]
                x = x0 + part * (segments[s, 2] - x0)
                # They are few, and stay in order.
                k = count
                while k > 0 and crossings[k - 1] > x:
                    crossings[k] = crossings[k - 1]
                    k -= 1
                crossings[k] = x
                count += 1
        for k in range(0, count - 1, 2):
            left = math.ceil((crossings[k] - ox) / resolution - 0.5)
            right = math.floor((crossings[k + 1] - ox) / resolution - 0.5)
            for column in range(max(left, 0), min(right + 1, columns)):
                costs[row, column] = _LETHAL


@jit_as(numba.void, CELLS, REAL, REAL, REAL, WALLS)
def mark_walls(costs, ox, oy, resolution, table):
    """Marks walls as lethal: the cells on outlines and those inside solids.

    `table` is `Obstacles.table`.
    """
    walls = opened(table)
    scale = 1.0 / resolution
    for s in range(len(walls.segments)):
        _mark_segment(
            costs,
            (walls.segments[s, 0] - ox) * scale,
            (walls.segments[s, 1] - oy) * scale,
            (walls.segments[s, 2] - ox) * scale,
            (walls.segments[s, 3] - oy) * scale,
        )
    for shape in range(len(walls.solid)):
        if walls.solid[shape]:
            _fill_solid(
                costs,
                *(ox, oy, resolution, walls.segments),
                *(walls.first[shape], walls.first[shape + 1]),
            )


@jit_as(numba.float64[:, ::1], MATRIX, REAL, REAL, REAL, REAL)
def discs_near(humans, x, y, reach, radius):
    """Returns discs (x, y, radius) of the people nearer to (x, y) than reach.

    `humans` are rows of `human_states`.
    """
    discs = np.empty((len(humans), 3))
    count = 0
    for i in range(len(humans)):
        dx = humans[i, X] - x
        dy = humans[i, Y] - y
        if dx * dx + dy * dy < reach * reach:
            discs[count, 0] = humans[i, X]
            discs[count, 1] = humans[i, Y]
            discs[count, 2] = radius
            count += 1
    return discs[:count].copy()


@jit
def _disc_runs(costs, disc, robot, ox, oy, resolution):
    """Returns runs (row, first column, last column) of the cells of a disc.

    `disc` is (x, y, radius). The cells are those with their center in the disc,
    and the one that contains its center, without those with their center in the
    robot's disc.
    """
    x, y, radius = disc[0], disc[1], disc[2]
    low = math.floor((y - radius - oy) / resolution)
    high = math.floor((y + radius - oy) / resolution)
    left = math.floor((x - radius - ox) / resolution)
    right = math.floor((x + radius - ox) / resolution)
    own_row = math.floor((y - oy) / resolution)
    own_column = math.floor((x - ox) / resolution)
    runs = np.empty((2 * (high - low + 1), 3), dtype=np.int64)
    count = 0
    for row in range(low, high + 1):
        inside = False
        for column in range(left, right + 1):
            cx = ox + (column + 0.5) * resolution
            cy = oy + (row + 0.5) * resolution
            covered = (cx - x) ** 2 + (cy - y) ** 2 <= radius * radius
            covered |= row == own_row and column == own_column
            if (cx - robot[0]) ** 2 + (cy - robot[1]) ** 2 <= robot[2] ** 2:
                covered = False
            if covered and not inside:
                runs[count, 0] = row
                runs[count, 1] = column
                count += 1
            if covered:
                runs[count - 1, 2] = column
            inside = covered
    return runs[:count]


@jit_as(numba.void, CELLS, REAL, REAL, REAL, MATRIX, VECTOR, VECTOR)
def stamp_discs(costs, ox, oy, resolution, discs, robot, graded):
    """Writes discs and their inflation where they cost more than the map.

    The discs are rows (x, y, radius); cells in the disc `robot` stay free (a
    negative radius for none). `graded` are `inflation_costs`.
    """
    rows, columns = costs.shape
    reach = int(math.sqrt(len(graded) - 1 + 0.5))
    for d in range(len(discs)):
        x, y, radius = discs[d, 0], discs[d, 1], discs[d, 2]
        far = radius + (reach + 1) * resolution
        if not (
            -far < x - ox < columns * resolution + far
            and -far < y - oy < rows * resolution + far
        ):
            continue
        runs = _disc_runs(costs, discs[d], robot, ox, oy, resolution)
        if len(runs) == 0:
            continue
        left, right = runs[0, 1], runs[0, 2]
        for r in range(1, len(runs)):
            left, right = min(left, runs[r, 1]), max(right, runs[r, 2])
        left = max(left - reach, 0)
        right = min(right + reach + 1, columns)
        if left >= right:
            continue
        # The squared distances along rows of columns from runs, in cells.
        aside = np.empty((len(runs), right - left), dtype=np.int32)
        for r in range(len(runs)):
            first = np.int32(runs[r, 1] - left)
            last = np.int32(runs[r, 2] - left)
            for k in range(aside.shape[1]):
                at = np.int32(k)
                dx = max(first - at, at - last, np.int32(0))
                aside[r, k] = dx * dx
        squares = np.empty(right - left, dtype=np.int32)
        for row in range(
            max(runs[0, 0] - reach, 0), min(runs[-1, 0] + reach + 1, rows)
        ):
            # Those of a row of cells from the disc.
            squares[:] = len(graded)
            for r in range(len(runs)):
                dy2 = np.int32((row - runs[r, 0]) ** 2)
                if dy2 >= len(graded):
                    continue
                for k in range(len(squares)):
                    squares[k] = min(squares[k], np.int32(aside[r, k] + dy2))
            for k in range(len(squares)):
                if squares[k] >= len(graded):
                    continue
                cost = graded[squares[k]]
                old = costs[row, left + k]
                if cost > old or (old == 255 and cost >= 253):
                    costs[row, left + k] = np.uint8(cost)
