"""Finds people's nearest neighbors, compiled by numba.

People are sorted into square cells of about two people each; around each
person, rings of cells are searched until no farther one can matter.
"""

import math

import numpy as np

from hunav_drake.systems.common.kernels import jit

# Neighbors whose squared distances differ relatively by less are equally far.
_TIE = 1e-9

# The least width of a cell, in meters.
_LEAST_WIDTH = 0.5


@jit
def cell_index(offset, width, count):
    """Returns the cell, of `count` ones, of an offset: at least the nearest."""
    return min(max(int(offset / width), 0), count - 1)


@jit
def make_cells(x, y):
    """Sorts people at x, y, of shape (n,) with n > 0, in meters, into cells.

    Returns the people's numbers, cell by cell, and their x and y in this order;
    the begin of each cell in it, row by row (the last one ends there); the
    lower left corner and the width of the cells; and the number of columns and
    rows.
    """
    n = len(x)
    left = x.min()
    bottom = y.min()
    across = x.max() - left
    up = y.max() - bottom
    width = max(math.sqrt(2 * across * up / n), max(across, up) * 2 / n)
    width = max(width, _LEAST_WIDTH)
    columns = cell_index(across, width, n) + 1
    rows = cell_index(up, width, n) + 1
    cells = np.empty(n, np.int64)
    begin = np.zeros(columns * rows + 1, np.int64)
    for i in range(n):
        column = cell_index(x[i] - left, width, columns)
        row = cell_index(y[i] - bottom, width, rows)
        cells[i] = row * columns + column
        begin[cells[i] + 1] += 1
    for i in range(1, len(begin)):
        begin[i] += begin[i - 1]
    order = np.empty(n, np.int64)
    end = begin[:-1].copy()
    for i in range(n):
        order[end[cells[i]]] = i
        end[cells[i]] += 1
    return order, x[order], y[order], begin, left, bottom, width, columns, rows


@jit
def find_neighbors(i, px, py, cells, reach, most, nearest, found):
    """Finds the nearest people, not farther than `reach`, to i at (px, py).

    All people who are as far as the last of `most`, to rounding, count, so that
    the result does not depend on the order of people. Their numbers are written
    to `found`, which has room for all; `nearest` is room for `most` numbers,
    and `cells` is from `make_cells`. Returns the number of people found.
    """
    order, x, y, begin, left, bottom, width, columns, rows = cells
    column = cell_index(px - left, width, columns)
    row = cell_index(py - bottom, width, rows)
    inset_x = px - left - column * width
    inset_y = py - bottom - row * width
    inset = min(min(inset_x, width - inset_x), min(inset_y, width - inset_y))

    nearest[:] = math.inf
    limit = reach * reach
    for ring in range(max(columns, rows)):
        gap = (ring - 1) * width + inset
        if ring > 0 and gap > 0 and gap * gap > limit:
            break
        for b in range(max(row - ring, 0), min(row + ring, rows - 1) + 1):
            # The first and the last row whole, of the others only the ends.
            whole = b == row - ring or b == row + ring
            step = 1 if whole else 2 * ring
            for a in range(column - ring, column + ring + 1, step):
                if a < 0 or a >= columns:
                    continue
                cell = b * columns + a
                for s in range(begin[cell], begin[cell + 1]):
                    dx = x[s] - px
                    dy = y[s] - py
                    d2 = dx * dx + dy * dy
                    if d2 < nearest[most - 1] and order[s] != i:
                        at = most - 1
                        while at > 0 and nearest[at - 1] > d2:
                            nearest[at] = nearest[at - 1]
                            at -= 1
                        nearest[at] = d2
        limit = min(limit, nearest[most - 1])

    limit = min(reach * reach, nearest[most - 1] * (1 + _TIE))
    # A little more, for people on the edge of a cell.
    radius = math.sqrt(limit) * (1 + _TIE) + _TIE
    count = 0
    first = cell_index(px - radius - left, width, columns)
    last = cell_index(px + radius - left, width, columns)
    lowest = cell_index(py - radius - bottom, width, rows)
    highest = cell_index(py + radius - bottom, width, rows)
    for b in range(lowest, highest + 1):
        cell = b * columns
        for s in range(begin[cell + first], begin[cell + last + 1]):
            dx = x[s] - px
            dy = y[s] - py
            if dx * dx + dy * dy <= limit and order[s] != i:
                found[count] = order[s]
                count += 1
    return count
