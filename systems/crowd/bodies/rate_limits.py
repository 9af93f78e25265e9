"""How fast people change velocity and heading, compiled by numba."""

import math

from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.layout import OMEGA, VX, VY, YAW, Command, X, Y
from hunav_drake.systems.crowd.social_force.compiled_forces import wrap

# Who is slower than this turns less fast in proportion, in m/s.
_TURNING_SPEED = 0.2


@jit
def limit_rates(before, after, command, acceleration, turn_rate, time_step):
    """Limits how a person's velocity and heading change; writes `after`.

    Args:
        before: Shape (6,): x, y, yaw, vx, vy, omega.
        after: Shape (6,): the state proposed; the place changes as the
            velocity does.
        command: Shape (COMMAND_SIZE,).
        acceleration: At most this, in m/s^2.
        turn_rate: At most this, in rad/s, unless the command turns the person.
        time_step: In seconds.
    """
    ax = after[VX] - before[VX]
    ay = after[VY] - before[VY]
    change = math.sqrt(ax * ax + ay * ay)
    most = acceleration * time_step
    if change > most:
        missing = 1 - most / change
        after[VX] -= missing * ax
        after[VY] -= missing * ay
        after[X] -= missing * ax * time_step
        after[Y] -= missing * ay * time_step
    turn = wrap(after[YAW] - before[YAW])
    if command[Command.TURN_RATE] == 0:
        speed = math.sqrt(after[VX] ** 2 + after[VY] ** 2)
        most = turn_rate * time_step * min(speed / _TURNING_SPEED, 1.0)
        if abs(turn) > most:
            turn = min(max(turn, -most), most)
            after[YAW] = wrap(before[YAW] + turn)
    after[OMEGA] = turn / time_step
