"""The motion of people who are placed: who sit down, sit and stand up."""

import math

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    OMEGA,
    VX,
    VY,
    YAW,
    Command,
    Hold,
    X,
    Y,
)

_HOLD, _PLACED = int(Command.HOLD), float(Hold.PLACED)
_GOAL_X, _GOAL_Y = int(Command.GOAL_X), int(Command.GOAL_Y)
_SPEED, _TURN_RATE = int(Command.DESIRED_SPEED), int(Command.TURN_RATE)
_YAW_TARGET = int(Command.YAW_TARGET)

# The part of the way for which nobody waits, in meters.
_OUT = 0.35


@jit
def any_placed(command: Array) -> bool:
    """Returns whether anybody is placed, by the rows of commands (16n,)."""
    for i in range(_HOLD, command.size, COMMAND_SIZE):
        if command[i] == _PLACED:
            return True
    return False


@jit
def _is_barred(i: int, dx: float, dy: float, bodies: Array) -> bool:
    """Returns whether a step of a person leads into another body."""
    x, y, radius = bodies[i]
    for k in range(len(bodies)):
        if k == i:
            continue
        px, py = bodies[k, 0] - x, bodies[k, 1] - y
        away = math.hypot(px - dx, py - dy)
        if away < radius + bodies[k, 2] and away < math.hypot(px, py):
            return True
    return False


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
        step = part * dx, part * dy
        if left > _OUT and _is_barred(i, *step, bodies):
            part = 0.0
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
