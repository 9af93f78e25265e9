"""The potential of NavFn and the descent in it, compiled by numba.

Cells are numbered ``row * columns + column``; an unknown potential is infinite.
"""

import math

import numba
import numpy as np

from hunav_drake.systems.common.kernels import INTEGER, jit, jit_as
from hunav_drake.systems.planning.costmap.raster import READ_CELLS

_NEUTRAL = 50.0
_FACTOR = 0.8
_HIGHEST = 253.0
# How far the wave continues beyond the goal, for the slopes around it.
_BEYOND = 4 * _HIGHEST
# The coefficients of the approximation, a polynomial in the difference of two
# neighbors.
_LEAST = np.float32(0.7040)
_LINEAR = np.float32(0.5307)
_SQUARE = np.float32(-0.2301)
_UNSET = np.float32(math.inf)
# Cells with higher potentials are put in the next list.
_FIRST_THRESHOLD = 254.0
_THRESHOLD_STEP = 100.0
# The step of the descent, in cells.
_STEP = 0.5

POTENTIALS = numba.types.Array(numba.float32, 2, "C", readonly=True)


@jit
def cell_weight(cost, allow_unknown):
    """Returns the cost of crossing a cell; infinite if it is impassable."""
    if cost < 253:
        return min(_HIGHEST, math.floor(_NEUTRAL + _FACTOR * cost))
    if cost == 255 and allow_unknown:
        return _HIGHEST
    return math.inf


@jit
def _value(potential, cell, columns, weight):
    """Returns the potential of a cell from its neighbors."""
    one = np.uintp(1)
    a = min(potential[cell - columns], potential[cell + columns])
    b = min(potential[cell - one], potential[cell + one])
    low = min(a, b)
    apart = abs(a - b)
    if not apart < weight:
        return low + weight
    q = apart / weight
    return low + weight * ((_SQUARE * q + _LINEAR) * q + _LEAST)


@jit
def _listed(lists, end, cell, skips, potential, value):
    """Lists a cell of a higher potential at `end`; returns the new end.

    (Without a branch, which a processor would often guess wrongly.)
    """
    takes = np.uint8(not skips[cell]) & np.uint8(potential[cell] > value)
    skips[cell] |= takes
    lists[end] = cell
    return end + np.uintp(takes)


@jit
def _bordered(costs):
    """Returns the costs as a flat array, with a blocked border."""
    flat = np.full(costs.shape, 254, dtype=np.uint8)
    for row in range(1, costs.shape[0] - 1):
        for column in range(1, costs.shape[1] - 1):
            flat[row, column] = costs[row, column]
    return flat.reshape(costs.size)


@jit
def _weights(allow_unknown):
    """Returns the crossing costs by the cost of a cell."""
    weights = np.empty(256, dtype=np.float32)
    for cost in range(256):
        weights[cost] = cell_weight(cost, allow_unknown)
    return weights


@jit_as(
    numba.float32[:, ::1],
    *(READ_CELLS, INTEGER, INTEGER, INTEGER, INTEGER, numba.boolean),
)
def navfn_potential(costs, row, column, goal_row, goal_column, allow_unknown):
    """Returns the path costs from a cell to all others: shape (rows, columns).

    The wave ends soon after it reaches the goal cell. Cells that it has not
    reached and impassable cells are infinite. The border of the map is
    impassable, the first cell is not.

    The update of a cell is NavFn's approximation of the wave equation. Cells
    are updated in lists by potential, and again whenever a neighbor's potential
    decreases. (The order changes the result by less than 0.5 % of one cell,
    because the approximation's polynomial exceeds 1 just before its end.)
    """
    rows, columns = costs.shape
    count = rows * columns
    cells = _bordered(costs)
    weights = _weights(allow_unknown)
    potential = np.full(count, _UNSET)
    start = row * columns + column
    goal = goal_row * columns + goal_column
    potential[start] = 0.0
    # Cells that are not listed: impassable ones, and those that are by now.
    skips = (weights == math.inf).astype(np.uint8)[cells]
    # Each cell is in at most one of three lists, so none is longer than all
    # cells. (Numba does not look for negative indices if they are unsigned.)
    lists = np.empty(3 * count, dtype=np.uint32)
    now, following, later = np.uintp(0), np.uintp(count), np.uintp(2 * count)
    now_end = now
    later_end = later
    one, width = np.uintp(1), np.uintp(columns)
    if 0 < row < rows - 1 and 0 < column < columns - 1:
        for step in (-1, 1, -columns, columns):
            if weights[cells[start + step]] < math.inf:
                lists[now_end] = start + step
                now_end += one
    threshold = _FIRST_THRESHOLD
    last = math.inf
    while True:
        for k in range(now, now_end):
            skips[np.uintp(lists[k])] = 0
        following_end = following
        for k in range(now, now_end):
            cell = np.uintp(lists[k])
            value = _value(potential, cell, width, weights[cells[cell]])
            if not value < potential[cell]:
                continue
            potential[cell] = value
            # A potential is never below the one that it follows from.
            is_near = value < threshold
            end = following_end if is_near else later_end
            end = _listed(lists, end, cell - one, skips, potential, value)
            end = _listed(lists, end, cell + one, skips, potential, value)
            end = _listed(lists, end, cell - width, skips, potential, value)
            end = _listed(lists, end, cell + width, skips, potential, value)
            if is_near:
                following_end = end
            else:
                later_end = end
        now, following = following, now
        now_end = following_end
        if now_end == now:
            if later_end == later or threshold > last:
                break
            now, later = later, now
            now_end, later_end = later_end, later
            threshold += _THRESHOLD_STEP
            last = potential[goal] + _BEYOND
    return potential.reshape((rows, columns))


@jit
def _downhill(potential, i, j):
    """Returns the direction (x, y) in which the potential falls at a cell.

    It has length 1, or 0 where the potential is unknown.
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
        # Out of a blocked cell, towards its known side.
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
        # (Both differences are positive downhill to the right.)
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


@jit_as(numba.float64[:, ::1], POTENTIALS, INTEGER, INTEGER, INTEGER, INTEGER)
def navfn_descent(potential, goal_row, goal_column, row, column):
    """Returns the descent from a goal cell, shape (k, 2), in cells (x, y).

    It moves in steps of half a cell along the interpolated slope, or from cell
    to cell next to unknown ones, until it is less than one free cell from the
    start of the wave (row, column). Empty (k = 0) if it does not arrive within
    4 max(rows, columns) steps.
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
        near_i = min(max(i + math.floor(y + 0.5), 0), rows - 1)
        near_j = min(max(j + math.floor(x + 0.5), 0), columns - 1)
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
            # On a ridge: leave it to one side.
            i, j = _lowest_neighbor(potential, i, j)
            x = 0.0
            y = 0.0
            continue
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
