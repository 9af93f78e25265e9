"""Limits the rates of velocities and headings, compiled by numba."""

import math

import numba

from hunav_drake.systems.common.kernels import CHANGED, MATRIX, REAL
from hunav_drake.systems.common.late import late_as
from hunav_drake.systems.common.layout import OMEGA, VX, VY, YAW, Command, X, Y
from hunav_drake.systems.crowd.social_force.compiled_forces import wrap

# Below this speed the limit of the turn rate falls in proportion, in m/s.
_TURNING_SPEED = 0.2


@late_as(numba.void, MATRIX, CHANGED, MATRIX, REAL, REAL, REAL)
def limit_rates(before, after, command, acceleration, turn_rate, time_step):
    """Limits the changes of velocities and headings; writes `after`.

    Positions change with the velocities. The limits are `acceleration`, in
    m/s^2, and `turn_rate`, in rad/s, unless the command turns the person.
    """
    for i in range(len(before)):
        ax = after[i, VX] - before[i, VX]
        ay = after[i, VY] - before[i, VY]
        change = math.sqrt(ax * ax + ay * ay)
        most = acceleration * time_step
        if change > most:
            missing = 1 - most / change
            after[i, VX] -= missing * ax
            after[i, VY] -= missing * ay
            after[i, X] -= missing * ax * time_step
            after[i, Y] -= missing * ay * time_step
        turn = wrap(after[i, YAW] - before[i, YAW])
        if command[i, Command.TURN_RATE] == 0:
            speed = math.sqrt(after[i, VX] ** 2 + after[i, VY] ** 2)
            most = turn_rate * time_step * min(speed / _TURNING_SPEED, 1.0)
            if abs(turn) > most:
                turn = min(max(turn, -most), most)
                after[i, YAW] = wrap(before[i, YAW] + turn)
        after[i, OMEGA] = turn / time_step
