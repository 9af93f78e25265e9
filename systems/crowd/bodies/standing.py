"""Lets people come to rest and stand, compiled by numba."""

import math

import numba

from hunav_drake.systems.common.kernels import CHANGED, MATRIX, REAL, jit
from hunav_drake.systems.common.late import late_as
from hunav_drake.systems.common.layout import (
    GOAL_FORCE,
    OBSTACLE_FORCE,
    TOTAL_FORCE,
    VX,
    VY,
    YAW,
    Command,
    X,
    Y,
)

# The columns of a stance: the position where a person stands, and 1 if so.
ANCHOR_X, ANCHOR_Y, STANDS = range(3)
STANCE_SIZE = 3

# Forces below this do not move people who stand, in m/s^2; the excess of a
# larger one gives this velocity per m/s^2, up to _BACK_SPEED.
_HELD = 3.0
_YIELD = 0.25

# A person slower than this at the goal stands, in m/s.
_AT_REST = 0.1

# The deceleration of people who stop at a goal, in m/s^2.
_BRAKING = 3.0

# People who are pushed away come back if they are farther than the first and
# not farther than the second distance, in meters, with this time constant, in
# seconds, and at most at this speed, in m/s.
_NEAR, _FAR = 0.05, 2.0
_BACK, _BACK_SPEED = 1.0, 0.5


@jit
def _move(i, before, after, vx, vy, time_step):
    """Moves a person at a velocity."""
    after[i, X] = before[i, X] + vx * time_step
    after[i, Y] = before[i, Y] + vy * time_step
    after[i, VX] = vx
    after[i, VY] = vy


@jit
def _stand(i, before, after, forces, command, stances, time_step):
    """Lets person `i`, who has nowhere to go, stand or come to rest.

    The arguments are those of `stand`.
    """
    speed = math.sqrt(before[i, VX] ** 2 + before[i, VY] ** 2)
    fx = (
        forces[i, TOTAL_FORCE]
        - forces[i, OBSTACLE_FORCE]
        - forces[i, GOAL_FORCE]
    )
    fy = forces[i, TOTAL_FORCE + 1] - (
        forces[i, OBSTACLE_FORCE + 1] + forces[i, GOAL_FORCE + 1]
    )
    if stances[i, STANDS] == 0:
        if speed > _AT_REST:
            slower = max(speed - _BRAKING * time_step, 0.0) / speed
            _move(
                i,
                before,
                after,
                before[i, VX] * slower,
                before[i, VY] * slower,
                time_step,
            )
            if command[i, Command.TURN_RATE] == 0:
                after[i, YAW] = before[i, YAW]
            return
        stances[i, ANCHOR_X] = before[i, X]
        stances[i, ANCHOR_Y] = before[i, Y]
        stances[i, STANDS] = 1.0
    dx = stances[i, ANCHOR_X] - before[i, X]
    dy = stances[i, ANCHOR_Y] - before[i, Y]
    away = math.sqrt(dx * dx + dy * dy)
    vx = 0.0
    vy = 0.0
    if away > _FAR:
        stances[i, ANCHOR_X] = before[i, X]
        stances[i, ANCHOR_Y] = before[i, Y]
    elif away > _NEAR:
        back = min((away - _NEAR) / _BACK, _BACK_SPEED) / away
        vx = back * dx
        vy = back * dy
    force = math.sqrt(fx * fx + fy * fy)
    if force > _HELD and command[i, Command.HOLD] == 0:
        aside = min(_YIELD * (force - _HELD), _BACK_SPEED) / force
        vx += aside * fx
        vy += aside * fy
    _move(i, before, after, vx, vy, time_step)
    if command[i, Command.TURN_RATE] == 0:
        after[i, YAW] = before[i, YAW]


@late_as(numba.void, MATRIX, CHANGED, MATRIX, MATRIX, CHANGED, REAL)
def stand(before, after, forces, command, stances, time_step):
    """Lets people stand, or come to rest; writes `after` and `stances`.

    People who have nowhere to go brake, and then stand: walls have no effect
    any more, and others only if they push hard (unless the command is to hold
    still) or touch. People who are pushed away come back.
    """
    # (Most people walk. A call for each of them, with all these arrays, would
    # take longer than the test.)
    for i in range(len(before)):
        gx = command[i, Command.GOAL_X] - before[i, X]
        gy = command[i, Command.GOAL_Y] - before[i, Y]
        radius = command[i, Command.GOAL_RADIUS]
        if command[i, Command.ROBOT_REPULSION] <= 0 and (
            command[i, Command.HAS_GOAL] == 0
            or command[i, Command.HOLD] != 0
            or command[i, Command.DESIRED_SPEED] == 0
            or gx * gx + gy * gy <= radius * radius
        ):
            _stand(i, before, after, forces, command, stances, time_step)
        else:
            stances[i, ANCHOR_X] = 0.0
            stances[i, ANCHOR_Y] = 0.0
            stances[i, STANDS] = 0.0
