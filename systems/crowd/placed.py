"""The motion of people who are placed: who sit down, sit and stand up."""

import numpy as np

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


@jit
def any_placed(command: Array) -> bool:
    """Returns whether anybody is placed, by the rows of commands (16n,)."""
    for i in range(_HOLD, command.size, COMMAND_SIZE):
        if command[i] == _PLACED:
            return True
    return False


def place(states: Array, command: Array, time_step: float) -> Array:
    """Returns the next states (n, 6) of people who are placed.

    Args:
        states: Shape (n, 6), rows (x, y, yaw, vx, vy, omega) in W, in SI units.
        command: Shape (n, 16), rows of `layout.Command`.
        time_step: In seconds.
    """
    after = states.copy()
    way = command[:, [Command.GOAL_X, Command.GOAL_Y]] - states[:, [X, Y]]
    left = np.hypot(*way.T)
    reach = command[:, Command.DESIRED_SPEED] * time_step
    part = np.minimum(reach / np.maximum(left, 1e-12), 1.0)
    after[:, [X, Y]] += part[:, None] * way
    after[:, [VX, VY]] = part[:, None] * way / time_step
    turn = command[:, Command.YAW_TARGET] - states[:, YAW]
    turn = (turn + np.pi) % (2 * np.pi) - np.pi
    most = command[:, Command.TURN_RATE] * time_step
    turn = np.clip(turn, -most, most)
    after[:, YAW] += turn
    after[:, OMEGA] = turn / time_step
    return after
