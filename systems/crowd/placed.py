"""The motion of people who are placed: who sit down, sit and stand up."""

import math

from numba import boolean, float64, void
from numba.types import NamedUniTuple, Tuple
import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import (
    CHANGED,
    CHANGED_VECTOR,
    INTEGER,
    MATRIX,
    REAL,
    VECTOR,
    WALLS,
    jit,
    jit_as,
)
from hunav_drake.systems.common.late import late_as
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    OMEGA,
    RADIUS,
    STATE_SIZE,
    TOUCH_SIZE,
    VX,
    VY,
    YAW,
    Command,
    Hold,
    X,
    Y,
)
from hunav_drake.systems.crowd.bodies.contacts import robot_touches
from hunav_drake.systems.crowd.bodies.finish import (
    Options,
    finish,
    for_each_robot,
)

_HOLD, _PLACED = int(Command.HOLD), float(Hold.PLACED)
_GOAL_X, _GOAL_Y = int(Command.GOAL_X), int(Command.GOAL_Y)
_SPEED, _TURN_RATE = int(Command.DESIRED_SPEED), int(Command.TURN_RATE)
_YAW_TARGET = int(Command.YAW_TARGET)

# The part of the way for which nobody waits, in meters.
_OUT = 0.35

# People stand below this speed, in m/s; and the part of a step that people
# take against those who stand in the way.
_STANDING, _PRESSING = 0.05, 0.1


@jit_as(boolean, VECTOR)
def any_placed(command: Array) -> bool:
    """Returns whether anybody is placed, by the rows of commands (16n,)."""
    for i in range(_HOLD, command.size, COMMAND_SIZE):
        if command[i] == _PLACED:
            return True
    return False


@jit_as(void, CHANGED_VECTOR, VECTOR)
def keep_placed(adapted: Array, command: Array) -> None:
    """Gives people who are placed their commands back; `adapted` changes.

    (They plan no way.) Both are rows of commands (16n,).
    """
    for start in range(0, command.size, COMMAND_SIZE):
        if command[start + _HOLD] == _PLACED:
            for c in range(start, start + COMMAND_SIZE):
                adapted[c] = command[c]


@jit
def _free_part(
    i: int, dx: float, dy: float, bodies: Array, states: Array, command: Array
) -> float:
    """Returns which part of a step does not lead into another body.

    It is a small one into people who stand: they make way for who presses.
    """
    x, y, radius = bodies[i]
    part = 1.0
    for k in range(len(bodies)):
        if k == i:
            continue
        px, py = bodies[k, 0] - x, bodies[k, 1] - y
        away = math.hypot(px - dx, py - dy)
        if away < radius + bodies[k, 2] and away < math.hypot(px, py):
            stands = (
                k < len(states)
                and command[k, _HOLD] != _PLACED
                and math.hypot(states[k, VX], states[k, VY]) < _STANDING
            )
            if not stands:
                return 0.0
            part = _PRESSING
    return part


@jit
def place(
    states: Array, command: Array, bodies: Array, time_step: float
) -> Array:
    """Returns the next states (n, 6) of people, of whom some are placed.

    They wait while somebody is in the way, but not for the last part of it, so
    that nobody waits for ever for one who waits. The others are as before.

    Args:
        states: Shape (n, 6), rows (x, y, yaw, vx, vy, omega) in W, in SI units.
        command: Shape (n, 16), rows of `layout.Command`.
        bodies: Shape (n + m, 3), rows (x, y, radius) of people and robots.
        time_step: In seconds.
    """
    after = states.copy()
    for i in range(len(states)):
        if command[i, _HOLD] != _PLACED:
            continue
        dx = command[i, _GOAL_X] - states[i, X]
        dy = command[i, _GOAL_Y] - states[i, Y]
        left = math.hypot(dx, dy)
        reach = command[i, _SPEED] * time_step
        part = min(reach / max(left, 1e-12), 1.0)
        if left > _OUT:
            step = part * dx, part * dy
            part *= _free_part(i, *step, bodies, states, command)
        after[i, X] += part * dx
        after[i, Y] += part * dy
        after[i, VX] = part * dx / time_step
        after[i, VY] = part * dy / time_step
        turn = command[i, _YAW_TARGET] - states[i, YAW]
        turn -= 2 * math.pi * round(turn / (2 * math.pi))
        most = command[i, _TURN_RATE] * time_step
        turn = min(max(turn, -most), most)
        after[i, YAW] += turn
        after[i, OMEGA] = turn / time_step
    return after


@late_as(
    Tuple((float64[:, ::1], float64[:, ::1])),
    *(MATRIX, MATRIX, MATRIX, MATRIX, CHANGED, MATRIX, MATRIX, WALLS),
    NamedUniTuple(float64, len(Options._fields), Options),
    *(REAL, INTEGER),
)
def finish_others(
    before,
    after,
    forces,
    command,
    stances,
    robots,
    sizes,
    table,
    options,
    time_step,
    iterations,
):
    """Returns the end of a step in which some people are placed.

    The arguments and results are those of `finish`. Nothing acts on people who
    are placed; the others make way for them as for robots.
    """
    n, m = len(before), len(robots)
    bodies = np.empty((n + m, 3))
    free = np.empty(n, np.int64)
    placed = np.empty(n, np.int64)
    num_free = 0
    for i in range(n):
        bodies[i, X] = before[i, X]
        bodies[i, Y] = before[i, Y]
        bodies[i, 2] = sizes[i, 0]
        if command[i, _HOLD] == _PLACED:
            placed[i - num_free] = i
            for c in range(stances.shape[1]):
                stances[i, c] = 0.0
        else:
            free[num_free] = i
            num_free += 1
    for j in range(m):
        bodies[n + j, X] = robots[j, X]
        bodies[n + j, Y] = robots[j, Y]
        bodies[n + j, 2] = robots[j, RADIUS]
    free, placed = free[:num_free], placed[: n - num_free]
    result = place(before, command, bodies, time_step)
    touches = np.zeros((m * n, TOUCH_SIZE))
    places = for_each_robot(result[placed], m)
    radii = sizes[placed][:, 0].copy()
    touched = robot_touches(before[placed], places, radii, robots, time_step)
    for row in range(len(touched)):
        j, k = divmod(row, len(placed))
        touches[j * n + placed[k]] = touched[row]
    if num_free == 0:
        return result, touches
    moving = np.empty((m + len(placed), STATE_SIZE))
    moving[:m] = robots
    for k in range(len(placed)):
        i = placed[k]
        for c in range(result.shape[1]):
            moving[m + k, c] = result[i, c]
        moving[m + k, X] -= time_step * result[i, VX]
        moving[m + k, Y] -= time_step * result[i, VY]
        moving[m + k, RADIUS] = sizes[i, 0]
    held = stances[free]
    moved, touched = finish(
        *(before[free], after[free], forces[free], command[free], held),
        *(moving, sizes[free], table, options, time_step, iterations),
        *(np.empty((0, 2), np.int64), -1.0),
    )
    for k in range(num_free):
        i = free[k]
        result[i] = moved[k]
        stances[i] = held[k]
        for j in range(m):
            touches[j * n + i] = touched[j * num_free + k]
    return result, touches
