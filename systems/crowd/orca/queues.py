"""The right of way of people who go to the same place, compiled by numba.

It is that of Curtis, Zafar, Gutub & Manocha 2013, "Right of way: asymmetric
agent interactions in crowds": the person who has it leaves the avoiding to the
other one. Here it belongs to the person nearer to their common place.
"""

import math

from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.layout import Command, X, Y

# If one of two people in a queue is nearer to their place by this, in meters,
# it goes first, and leaves all avoiding to the other one.
_PRIORITY = 0.5

# The cosine of the angle up to which two ways are side by side.
_SAME_WAY = 0.8


@jit
def is_walking(state, command):
    """Returns whether a person is on the way to a goal."""
    gx = command[Command.GOAL_X] - state[X]
    gy = command[Command.GOAL_Y] - state[Y]
    return (
        command[Command.HAS_GOAL] != 0
        and command[Command.DESIRED_SPEED] > 0
        and math.hypot(gx, gy) > command[Command.GOAL_RADIUS]
    )


@jit
def go_side_by_side(state, command, other, others):
    """Returns whether the ways of two people differ by less than 37 degrees."""
    ax = command[Command.GOAL_X] - state[X]
    ay = command[Command.GOAL_Y] - state[Y]
    bx = others[Command.GOAL_X] - other[X]
    by = others[Command.GOAL_Y] - other[Y]
    lengths = math.hypot(ax, ay) * math.hypot(bx, by)
    return ax * bx + ay * by > _SAME_WAY * lengths


@jit
def _is_on_way(x, y, state, command, near):
    """Returns whether a place is near the way of a person to the goal."""
    gx = command[Command.GOAL_X] - state[X]
    gy = command[Command.GOAL_Y] - state[Y]
    dx = x - state[X]
    dy = y - state[Y]
    part = (dx * gx + dy * gy) / (gx * gx + gy * gy)
    if part <= 0:
        return False
    part = min(part, 1.0)
    return math.hypot(dx - part * gx, dy - part * gy) < near


@jit
def share_in_queue(state, command, other, others, near):
    """Returns a person's share of the avoiding in a queue; -1 without one.

    Two people who walk are in a queue if they go to the same place, or if one
    goes to a place on the way of the other, and not in the opposite direction.
    The shares of both add up to one: that of the person nearer to the two
    places is smaller. Places are the same, or on a way, within `near` meters.
    (state, command) are those of the person, with the next waypoint for a goal,
    (other, others) those of the other one.
    """
    ax = command[Command.GOAL_X]
    ay = command[Command.GOAL_Y]
    bx = others[Command.GOAL_X]
    by = others[Command.GOAL_Y]
    if math.hypot(ax - bx, ay - by) >= near:
        along = (ax - state[X]) * (bx - other[X])
        along += (ay - state[Y]) * (by - other[Y])
        if along <= 0 or not (
            _is_on_way(ax, ay, other, others, near)
            or _is_on_way(bx, by, state, command, near)
        ):
            return -1.0
    own_way = math.hypot(ax - state[X], ay - state[Y])
    own_way += math.hypot(bx - state[X], by - state[Y])
    other_way = math.hypot(ax - other[X], ay - other[Y])
    other_way += math.hypot(bx - other[X], by - other[Y])
    later = (own_way - other_way) / (4 * _PRIORITY)
    return min(max(0.5 + later, 0.0), 1.0)
