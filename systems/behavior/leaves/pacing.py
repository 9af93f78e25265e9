"""Starting, slowing down and stopping of people, as bodies can."""

import math
from typing import Annotated

from hunav_drake.systems.behavior.nodes.tick_context import TickContext
from hunav_drake.systems.common.layout import VX, VY, YAW, Command, X, Y
from hunav_drake.systems.common.schema import within

TurnRate = Annotated[float, within(0, 100, "rad/s", low_open=True)]
PortSpeed = Annotated[float, within(0, 10, "m/s")]
PortDistance = Annotated[float, within(0, 1e5, "m")]
PositiveDistance = Annotated[float, within(0, 1e5, "m", low_open=True)]

# The largest deceleration of a person, in m/s^2; 0 stops at once, as in
# HuNavSim.
Deceleration = Annotated[float, within(0, 100, "m/s^2")]

# The time in which people take up their desired velocity, in seconds:
# relaxation_time / goal_factor of SocialForceParameters.
RESPONSE_TIME = 0.25

# The desired speed of a person who presses into a place at a wall, in m/s,
# which balances the forces of walls; and the distance of the point ahead that
# a person walks to along a wall, in meters, so short that these forces do not
# drive the person off.
PRESSING = 6.0
AIM = 0.06

# A person slower than this stands, in m/s.
STANDING = 0.05


def speed_of(context: TickContext) -> float:
    """Returns the speed of the person, in m/s."""
    return math.hypot(context.state[VX], context.state[VY])


def face(context: TickContext, x: float, y: float, turn_rate: float) -> None:
    """Turns the person towards a point, at `turn_rate` at most.

    A person who stands on the point keeps the heading.
    """
    state, command = context.state, context.command
    dx, dy = x - state[X], y - state[Y]
    command[Command.TURN_RATE] = turn_rate
    command[Command.YAW_TARGET] = math.atan2(dy, dx) if dx or dy else state[YAW]


def head_for(
    context: TickContext, x: float, y: float, goal_radius: float
) -> None:
    """Walks to a point instead of to the current goal."""
    command = context.command
    command[Command.GOAL_X] = x
    command[Command.GOAL_Y] = y
    command[Command.GOAL_RADIUS] = goal_radius
    command[Command.HAS_GOAL] = 1.0


def walk_at(
    context: TickContext, speed: float, deceleration: float = 0.0
) -> None:
    """Walks at a speed, slowing down to it by `deceleration` at most."""
    command = context.command
    command[Command.DESIRED_SPEED] = speed
    if deceleration:
        least = speed_of(context) - deceleration * context.person.time_step
        speed = max(speed, least)
    command[Command.MAX_SPEED] = speed


def slow_down_before(
    context: TickContext, left: float, deceleration: float
) -> None:
    """Limits the speed so that `deceleration` stops the person in `left` m."""
    # (Half of it leaves room for the forces. The desired speed stays, so that
    # the forces of a wall nearby do not hold the person back.)
    most = context.command[Command.MAX_SPEED]
    least = speed_of(context) - deceleration * context.person.time_step
    speed = max(math.sqrt(deceleration * left), least)
    context.command[Command.MAX_SPEED] = min(speed, most)


def come_to_rest(context: TickContext, deceleration: float = 0.0) -> None:
    """Stands still, or slows down to do so, by `deceleration` at most."""
    left = speed_of(context) - deceleration * context.person.time_step
    if not deceleration or left <= 0:
        context.command[Command.HOLD] = 1.0
        return
    state = context.state
    # (A goal that is not reached before the person stands.)
    head_for(context, state[X] + state[VX], state[Y] + state[VY], 0.0)
    walk_at(context, left)


def walk_with(
    context: TickContext, vx: float, vy: float, acceleration: float
) -> None:
    """Walks with a velocity in W, which changes by `acceleration` at most."""
    state, command = context.state, context.command
    dx, dy = vx - state[VX], vy - state[VY]
    change = math.hypot(dx, dy)
    part = min(acceleration * RESPONSE_TIME / change, 1.0) if change else 0.0
    vx, vy = state[VX] + part * dx, state[VY] + part * dy
    speed = math.hypot(vx, vy)
    if speed < STANDING and speed_of(context) < STANDING:
        command[Command.HOLD] = 1.0
        return
    command[Command.DESIRED_SPEED] = speed
    command[Command.MAX_SPEED] = max(speed, speed_of(context))
    # A point half a meter ahead, which the next tick puts farther on.
    ahead = 0.5 / max(speed, STANDING)
    head_for(context, state[X] + ahead * vx, state[Y] + ahead * vy, 0.0)
