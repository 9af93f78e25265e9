"""The potential of NavFn and the way down it, compiled by numba.

Cells are numbered ``row * columns + column``; a potential is infinite where
it is not known.
"""

import math

import numba
import numpy as np

from hunav_drake.systems.common.kernels import INTEGER, jit, jit_as
from hunav_drake.systems.planning.costmap.raster import READ_CELLS

_NEUTRAL = 50.0
_FACTOR = 0.8
_HIGHEST = 253.0
# How far beyond the goal the wave goes on, for the slopes about it.
_BEYOND = 4 * _HIGHEST
# The length of a step of the way, in cells.
_STEP = 0.5

POTENTIALS = numba.types.Array(numba.float64, 2, "C", readonly=True)


@jit
def cell_weight(cost, allow_unknown):
    """Returns what it costs to cross a cell; infinite if nothing may."""
    if cost < 253:
        return min(_HIGHEST, math.floor(_NEUTRAL + _FACTOR * cost))
    if cost == 255 and allow_unknown:
        return _HIGHEST
    return math.inf


@jit
def _push(keys, cells, size, key, cell):
    """Adds to a heap of pairs, and returns its new size."""
    i = size
    while i > 0:
        parent = (i - 1) >> 1
        if keys[parent] <= key:
            break
        keys[i] = keys[parent]
        cells[i] = cells[parent]
        i = parent
    keys[i] = key
    cells[i] = cell
    return size + 1


@jit
def _pop(keys, cells, size):
    """Takes the first off a heap, which stays at [size - 1]."""
    first_key = keys[0]
    first_cell = cells[0]
    size -= 1
    key = keys[size]
    cell = cells[size]
    i = 0
    while True:
        child = 2 * i + 1
        if child >= size:
            break
        if child + 1 < size and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        keys[i] = keys[child]
        cells[i] = cells[child]
        i = child
    keys[i] = key
    cells[i] = cell
    return first_key, first_cell, size


@jit
def _value(potential, n, columns, weight):
    """Returns the potential that the neighbors of a cell give it."""
    a = min(potential[n - columns], potential[n + columns])
    b = min(potential[n - 1], potential[n + 1])
    low = min(a, b)
    apart = abs(a - b)
    if not apart < weight:
        return low + weight
    q = apart / weight
    return low + weight * (-0.2301 * q * q + 0.5307 * q + 0.7040)


@jit_as(
    numba.float64[:, ::1], READ_CELLS, INTEGER, INTEGER, INTEGER, INTEGER,
    numba.boolean,
)
def navfn_potential(
    costs, row, column, goal_row, goal_column, allow_unknown
):
    """Returns the cost of the way from a cell to each: shape (rows, columns).

    The wave ends soon after it has come to the goal cell; cells that it has
    not come to, and cells that may not be crossed, are infinite. The border of
    the map may not be crossed, the first cell may.

    The update of a cell is NavFn's approximation of the wave's equation, and
    cells are taken in the order of their potential.
    """
    rows, columns = costs.shape
    count = rows * columns
    weights = np.full(count, math.inf)
    for i in range(1, rows - 1):
        for j in range(1, columns - 1):
            weights[i * columns + j] = cell_weight(costs[i, j], allow_unknown)
    potential = np.full(count, math.inf)
    done = np.zeros(count, dtype=numba.boolean)
    start = row * columns + column
    goal = goal_row * columns + goal_column
    potential[start] = 0.0
    room = 4096
    keys = np.empty(room)
    cells = np.empty(room, dtype=np.int64)
    size = _push(keys, cells, 0, 0.0, start)
    end = math.inf
    while size > 0:
        key, cell, size = _pop(keys, cells, size)
        if done[cell]:
            continue
        if key > end:
            break
        done[cell] = True
        if cell == goal:
            end = key + _BEYOND
        i = cell // columns
        j = cell - i * columns
        for k in range(4):
            if k == 0:
                other = cell - 1
                if j == 0:
                    continue
            elif k == 1:
                other = cell + 1
                if j == columns - 1:
                    continue
            elif k == 2:
                other = cell - columns
                if i == 0:
                    continue
            else:
                other = cell + columns
                if i == rows - 1:
                    continue
            # (The border is blocked, so all others have four neighbors.)
            if done[other] or weights[other] == math.inf:
                continue
            value = _value(potential, other, columns, weights[other])
            if value < potential[other]:
                potential[other] = value
                if size + 1 >= room:
                    room *= 2
                    more = np.empty(room)
                    more[:size] = keys[:size]
                    keys = more
                    others = np.empty(room, dtype=np.int64)
                    others[:size] = cells[:size]
                    cells = others
                size = _push(keys, cells, size, value, other)
    return potential.reshape((rows, columns))


@jit
def _downhill(potential, i, j):
    """Returns the direction (x, y) in which a potential falls at a cell.

    It has length 1, or 0 where nothing is known.
    """
    rows, columns = potential.shape
    if i < 1 or j < 1 or i > rows - 2 or j > columns - 2:
        return 0.0, 0.0
    here = potential[i, j]
    left = potential[i, j - 1]
    right = potential[i, j + 1]
    below = potential[i - 1, j]
    above = potential[i + 1, j]
    dx = 0.0
    dy = 0.0
    if here == math.inf:
        # Out of what is blocked, away from its other side.
        if left < math.inf:
            dx = -253.0
        elif right < math.inf:
            dx = 253.0
        if below < math.inf:
            dy = -253.0
        elif above < math.inf:
            dy = 253.0
    else:
        if left < math.inf:
            dx += left - here
        if right < math.inf:
            dx += here - right
        if below < math.inf:
            dy += below - here
        if above < math.inf:
            dy += here - above
        # (Both differences point downhill to the right.)
    length = math.hypot(dx, dy)
    if length > 0:
        return dx / length, dy / length
    return 0.0, 0.0


@jit
def _lowest_neighbor(potential, i, j):
    best = potential[i, j]
    bi = i
    bj = j
    for di in range(-1, 2):
        for dj in range(-1, 2):
            if potential[i + di, j + dj] < best:
                best = potential[i + di, j + dj]
                bi = i + di
                bj = j + dj
    return bi, bj


@jit_as(
    numba.float64[:, ::1], POTENTIALS, INTEGER, INTEGER, INTEGER, INTEGER
)
def navfn_descent(potential, goal_row, goal_column, row, column):
    """Returns the way down from a goal cell, shape (k, 2), in cells (x, y).

    It goes by steps of half a cell along the interpolated slope, and next to
    cells without potential from cell to cell, until it is less than one free
    cell away from where the wave began, (row, column). None (k = 0) if it
    does not get there in 4 max(rows, columns) steps.
    """
    rows, columns = potential.shape
    most = 4 * max(rows, columns)
    path = np.empty((most + 1, 2))
    i = goal_row
    j = goal_column
    x = 0.0
    y = 0.0
    count = 0
    for _ in range(most):
        near_i = min(max(i + int(math.floor(y + 0.5)), 0), rows - 1)
        near_j = min(max(j + int(math.floor(x + 0.5)), 0), columns - 1)
        if potential[near_i, near_j] < _NEUTRAL:
            path[count, 0] = column
            path[count, 1] = row
            return path[: count + 1]
        if i < 1 or j < 1 or i > rows - 2 or j > columns - 2:
            break
        path[count, 0] = j + x
        path[count, 1] = i + y
        count += 1
        stuck = count > 2 and (
            path[count - 1, 0] == path[count - 3, 0]
            and path[count - 1, 1] == path[count - 3, 1]
        )
        unknown = stuck
        for di in range(-1, 2):
            for dj in range(-1, 2):
                if potential[i + di, j + dj] == math.inf:
                    unknown = True
        if unknown:
            i, j = _lowest_neighbor(potential, i, j)
            x = 0.0
            y = 0.0
            continue
        ax, ay = _downhill(potential, i, j)
        bx, by = _downhill(potential, i, j + 1)
        cx, cy = _downhill(potential, i + 1, j)
        dx, dy = _downhill(potential, i + 1, j + 1)
        gx = (1 - y) * ((1 - x) * ax + x * bx) + y * ((1 - x) * cx + x * dx)
        gy = (1 - y) * ((1 - x) * ay + x * by) + y * ((1 - x) * cy + x * dy)
        length = math.hypot(gx, gy)
        if length == 0.0:
            break
        x += _STEP * gx / length
        y += _STEP * gy / length
        if x > 1:
            j += 1
            x -= 1
        if x < 0:
            j -= 1
            x += 1
        if y > 1:
            i += 1
            y -= 1
        if y < 0:
            i -= 1
            y += 1
    return path[:0]
