"""People who stand, in the order of x: to find those near a place."""

import math

from numba import boolean, int64

from hunav_drake.systems.common.kernels import (
    CHANGED_VECTOR,
    MATRIX,
    REAL,
    VECTOR,
    jit_as,
    rows_of,
)
from hunav_drake.systems.common.layout import RADIUS, STATE_SIZE, VX, VY, X, Y
from hunav_drake.systems.common.sorting import stable_order

# People slower than this stand, in m/s.
_STANDING = 0.1

# The part of coordinates that rounding may change.
_ROUNDING = 1e-9


@jit_as(int64, VECTOR, CHANGED_VECTOR)
def find_standing(states, found):
    """Finds the people who stand.

    Args:
        states: Shape (7n,), see `layout`.
        found: Shape (3n,) or more: it gets rows (x, y, radius) of the people
            who stand, in the order of x.

    Returns:
        The number of these people.
    """
    count = 0
    for i in range(0, len(states), STATE_SIZE):
        if math.hypot(states[i + VX], states[i + VY]) < _STANDING:
            found[3 * count] = states[i + X]
            found[3 * count + 1] = states[i + Y]
            found[3 * count + 2] = states[i + RADIUS]
            count += 1
    if count > 1:
        rows = rows_of(found, 3)[:count].copy()
        order = stable_order(rows[:, 0].copy())
        for k in range(count):
            for c in range(3):
                found[3 * k + c] = rows[order[k], c]
    return count


@jit_as(boolean, MATRIX, REAL, REAL, REAL, REAL, REAL, REAL, REAL, REAL)
def bar_the_way(rows, x, y, radius, goal_x, goal_y, distance, gap, least):
    """Returns whether people who stand at a goal bar the way to it.

    Args:
        rows: Shape (k, 3), those of `find_standing`.
        x: Of the one who walks to the goal, in W, in meters.
        y: The same.
        radius: That of the body, in meters.
        goal_x: Of the goal, in W, in meters.
        goal_y: The same.
        distance: That to the goal, in meters. Only people nearer to the goal
            count.
        gap: Somebody ahead must be this near, body to body, in meters.
        least: The least number of people who must stand there.
    """
    count = len(rows)
    if least > count:
        return False
    widest = 0.0
    for i in range(count):
        widest = max(widest, rows[i, 2])
    reach = gap + radius + widest
    reach += _ROUNDING * (reach + abs(x))
    is_barred = False
    for i in range(_first(rows, x - reach), count):
        dx = rows[i, 0] - x
        dy = rows[i, 1] - y
        if dx > reach or is_barred:
            break
        is_barred = (
            math.hypot(dx, dy) - (rows[i, 2] + radius) <= gap
            and dx * (goal_x - x) + dy * (goal_y - y) > 0
            and math.hypot(rows[i, 0] - goal_x, rows[i, 1] - goal_y) < distance
        )
    if not is_barred:
        return False
    reach = distance + _ROUNDING * (distance + abs(goal_x))
    near = 0
    for i in range(_first(rows, goal_x - reach), count):
        dx = rows[i, 0] - goal_x
        if dx > reach:
            break
        near += math.hypot(dx, rows[i, 1] - goal_y) < distance
    return near >= least


@jit_as(int64, MATRIX, REAL)
def _first(rows, x):
    """Returns the index of the first row whose x is not less."""
    low, high = 0, len(rows)
    while low < high:
        middle = (low + high) // 2
        if rows[middle, 0] < x:
            low = middle + 1
        else:
            high = middle
    return low
