"""People who stand, in the order of x: to find those near a place."""

from functools import cached_property
import math

import numba
from numba import float64
import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import MATRIX, REAL, VECTOR, jit_as
from hunav_drake.systems.common.layout import RADIUS, STATE_SIZE, VX, VY, X, Y
from hunav_drake.systems.common.sorting import stable_order

# People slower than this stand, in m/s.
_STANDING = 0.1

# The part of coordinates that rounding may change.
_ROUNDING = 1e-9


class Standing:
    """The people who stand in one snapshot, sorted when they are asked for."""

    def __init__(self, human_states: Array) -> None:
        """Takes `human_states`, of shape (7n,), which must not change."""
        self._human_states = human_states

    @cached_property
    def _rows(self) -> Array:
        rows: Array = _standing(self._human_states)
        return rows

    def bar_the_way(
        self,
        person: tuple[float, float, float],
        goal: tuple[float, float],
        distance: float,
        gap: float,
        least: float,
    ) -> bool:
        """Returns whether people who stand at a goal bar the way to it.

        Args:
            person: The x, y and radius of the one who walks to it, in meters.
            goal: The x and y of the goal, in meters.
            distance: That from the person to the goal, in meters. Only people
                nearer to the goal count.
            gap: Somebody ahead must be this near, body to body, in meters.
            least: The least number of people who must stand there.
        """
        return bool(
            _bar_the_way(self._rows, *person, *goal, distance, gap, least)
        )


@jit_as(float64[:, ::1], VECTOR)
def _standing(states):
    """Returns the x, y and radii of people who stand, shape (3, k), by x."""
    found = np.empty((3, len(states) // STATE_SIZE))
    count = 0
    for i in range(0, len(states), STATE_SIZE):
        if math.hypot(states[i + VX], states[i + VY]) < _STANDING:
            found[0, count] = states[i + X]
            found[1, count] = states[i + Y]
            found[2, count] = states[i + RADIUS]
            count += 1
    rows = np.empty((3, count))
    order = stable_order(found[0, :count])
    for k in range(count):
        for c in range(3):
            rows[c, k] = found[c, order[k]]
    return rows


@jit_as(numba.boolean, MATRIX, REAL, REAL, REAL, REAL, REAL, REAL, REAL, REAL)
def _bar_the_way(rows, x, y, radius, goal_x, goal_y, distance, gap, least):
    """Returns whether people bar a way: see `Standing`."""
    if least > rows.shape[1]:
        return False
    reach = gap + radius + np.max(rows[2]) if rows.shape[1] > 0 else 0.0
    reach += _ROUNDING * (reach + abs(x))
    is_barred = False
    for i in range(np.searchsorted(rows[0], x - reach), rows.shape[1]):
        dx = rows[0, i] - x
        dy = rows[1, i] - y
        if dx > reach or is_barred:
            break
        is_barred = (
            math.hypot(dx, dy) - (rows[2, i] + radius) <= gap
            and dx * (goal_x - x) + dy * (goal_y - y) > 0
            and math.hypot(rows[0, i] - goal_x, rows[1, i] - goal_y) < distance
        )
    if not is_barred:
        return False
    reach = distance + _ROUNDING * (distance + abs(goal_x))
    count = 0
    for i in range(np.searchsorted(rows[0], goal_x - reach), rows.shape[1]):
        dx = rows[0, i] - goal_x
        if dx > reach:
            break
        count += math.hypot(dx, rows[1, i] - goal_y) < distance
    return count >= least
