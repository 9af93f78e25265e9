"""How people come to rest and stand, compiled by numba."""

import math

from hunav_drake.systems.common.kernels import jit
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

# The columns of a stance: where somebody stands, and whether.
ANCHOR_X, ANCHOR_Y, STANDS = range(3)
STANCE_SIZE = 3

# Forces below this move nobody who stands, in m/s^2; of a greater one the rest
# gives this velocity per m/s^2, up to _BACK_SPEED.
_HELD = 3.0
_YIELD = 0.25

# Who is slower than this at the goal stands, in m/s.
_AT_REST = 0.1

# How fast who stopped at a goal slows down, in m/s^2.
_BRAKING = 3.0

# Who is pushed away comes back if it is farther than this and not farther
# than that, in meters, in this time, in seconds, and at most at this speed.
_NEAR, _FAR = 0.05, 2.0
_BACK, _BACK_SPEED = 1.0, 0.5


@jit
def wants_to_stand(x, y, command):
    """Tells whether a person at (x, y) has nowhere to go."""
    if command[Command.ROBOT_REPULSION] > 0:
        return False
    gx = command[Command.GOAL_X] - x
    gy = command[Command.GOAL_Y] - y
    radius = command[Command.GOAL_RADIUS]
    return (
        command[Command.HAS_GOAL] == 0
        or command[Command.HOLD] != 0
        or command[Command.DESIRED_SPEED] == 0
        or gx * gx + gy * gy <= radius * radius
    )


@jit
def _move(before, after, vx, vy, time_step):
    """Lets a person go at a velocity."""
    after[X] = before[X] + vx * time_step
    after[Y] = before[Y] + vy * time_step
    after[VX] = vx
    after[VY] = vy


@jit
def stand(before, after, forces, command, stance, time_step):
    """Lets a person stand, or come to rest; writes `after` and `stance`.

    Whoever has nowhere to go brakes, and then stands: walls do not matter
    any more, and others only if they push hard (unless the command is to hold
    still) or touch; who is pushed away comes back.

    Args:
        before: Shape (6,): x, y, yaw, vx, vy, omega.
        after: Shape (6,): the state proposed.
        forces: Shape (FORCES_SIZE,).
        command: Shape (COMMAND_SIZE,).
        stance: Shape (3,): see the columns above.
        time_step: In seconds.
    """
    if not wants_to_stand(before[X], before[Y], command):
        stance[:] = 0.0
        return
    speed = math.sqrt(before[VX] ** 2 + before[VY] ** 2)
    fx = forces[TOTAL_FORCE] - forces[OBSTACLE_FORCE] - forces[GOAL_FORCE]
    fy = forces[TOTAL_FORCE + 1] - (
        forces[OBSTACLE_FORCE + 1] + forces[GOAL_FORCE + 1]
    )
    if stance[STANDS] == 0:
        if speed > _AT_REST:
            slower = max(speed - _BRAKING * time_step, 0.0) / speed
            _move(
                before,
                after,
                before[VX] * slower,
                before[VY] * slower,
                time_step,
            )
            if command[Command.TURN_RATE] == 0:
                after[YAW] = before[YAW]
            return
        stance[ANCHOR_X] = before[X]
        stance[ANCHOR_Y] = before[Y]
        stance[STANDS] = 1.0
    dx = stance[ANCHOR_X] - before[X]
    dy = stance[ANCHOR_Y] - before[Y]
    away = math.sqrt(dx * dx + dy * dy)
    vx = 0.0
    vy = 0.0
    if away > _FAR:
        stance[ANCHOR_X] = before[X]
        stance[ANCHOR_Y] = before[Y]
    elif away > _NEAR:
        back = min((away - _NEAR) / _BACK, _BACK_SPEED) / away
        vx = back * dx
        vy = back * dy
    force = math.sqrt(fx * fx + fy * fy)
    if force > _HELD and command[Command.HOLD] == 0:
        aside = min(_YIELD * (force - _HELD), _BACK_SPEED) / force
        vx += aside * fx
        vy += aside * fy
    _move(before, after, vx, vy, time_step)
    if command[Command.TURN_RATE] == 0:
        after[YAW] = before[YAW]
