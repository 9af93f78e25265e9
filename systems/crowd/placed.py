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


@jit
def any_placed(command: Array) -> bool:
    """Returns whether anybody is placed, by the rows of commands (16n,)."""
    for i in range(_HOLD, command.size, COMMAND_SIZE):
        if command[i] == _PLACED:
            return True
    return False


@jit
def place(states: Array, command: Array, time_step: float) -> Array:
    """Returns the next states (n, 6) of people who are placed.

    Args:
        states: Shape (n, 6), rows (x, y, yaw, vx, vy, omega) in W, in SI units.
        command: Shape (n, 16), rows of `layout.Command`.
        time_step: In seconds.
    """
    after = states.copy()
    for i in range(len(states)):
        dx = command[i, _GOAL_X] - states[i, X]
        dy = command[i, _GOAL_Y] - states[i, Y]
        left = math.hypot(dx, dy)
        reach = command[i, _SPEED] * time_step
        part = min(reach / max(left, 1e-12), 1.0)
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
