"""Starting, slowing down and stopping of people, as bodies can; compiled."""

import math
from typing import Annotated

import numpy as np

from hunav_drake.systems.behavior.nodes.control_flow import steps_reach
from hunav_drake.systems.behavior.nodes.status import RUNNING, SUCCESS
from hunav_drake.systems.common.kernels import jit_part
from hunav_drake.systems.common.layout import Hold
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

# A person walks to a point until this near, in meters.
_REACH = 0.05

# A person settles on a point within the first distance, and stays there up to
# the second; it walks there at least with the speed, and as fast as it would
# be there in the time. In meters, m/s and seconds.
SETTLED, _OFF, _SLOWLY, _SOON = 0.1, 0.2, 0.2, 0.5

# A person who settles presses on from this near, in meters.
_PRESSES = 0.8

_STAND = float(Hold.STAND)


@jit_part
def speed_of(body):
    """Returns the speed of a body, in m/s."""
    return math.hypot(body.vx, body.vy)


@jit_part
def wrapped(angle):
    """Returns `math.remainder(angle, 2 * math.pi)`, to the last bit."""
    turn = 2 * math.pi
    rest = np.fmod(abs(angle), turn)
    beyond = turn - rest
    if rest > beyond:
        rest = -beyond
    elif rest == beyond:
        rest -= 2 * np.fmod(0.5 * (abs(angle) - rest), turn)
    return math.copysign(1.0, angle) * rest


@jit_part
def face(tick, x, y, turn_rate):
    """Turns the person towards a point, at `turn_rate` at most.

    A person who stands on the point keeps the heading.
    """
    dx, dy = x - tick.x, y - tick.y
    tick.turn_rate = turn_rate
    tick.yaw_target = math.atan2(dy, dx) if dx != 0 or dy != 0 else tick.yaw


@jit_part
def head_for(tick, x, y, goal_radius):
    """Walks to a point instead of to the current goal."""
    tick.goal_x = x
    tick.goal_y = y
    tick.goal_radius = goal_radius
    tick.has_goal = 1.0


@jit_part
def walk_at(tick, speed, deceleration):
    """Walks at a speed, slowing down to it by `deceleration` at most."""
    tick.desired_speed = speed
    if deceleration != 0:
        least = speed_of(tick) - deceleration * tick.time_step
        speed = max(speed, least)
    tick.max_speed = speed


@jit_part
def slow_down_before(tick, left, deceleration):
    """Limits the speed so that `deceleration` stops the person in `left` m."""
    # (Half of it leaves room for the forces. The desired speed stays, so that
    # the forces of a wall nearby do not hold the person back.)
    least = speed_of(tick) - deceleration * tick.time_step
    speed = max(math.sqrt(deceleration * left), least)
    tick.max_speed = min(speed, tick.max_speed)


@jit_part
def come_to_rest(tick, deceleration):
    """Stands still, or slows down to do so, by `deceleration` at most."""
    left = speed_of(tick) - deceleration * tick.time_step
    if deceleration == 0 or left <= 0:
        tick.hold = 1.0
        return
    # (A goal that is not reached before the person stands.)
    head_for(tick, tick.x + tick.vx, tick.y + tick.vy, 0.0)
    walk_at(tick, left, 0.0)


@jit_part
def walk_with(tick, vx, vy, acceleration):
    """Walks with a velocity in W, which changes by `acceleration` at most."""
    dx, dy = vx - tick.vx, vy - tick.vy
    change = math.hypot(dx, dy)
    part = 0.0
    if change != 0:
        part = min(acceleration * RESPONSE_TIME / change, 1.0)
    vx, vy = tick.vx + part * dx, tick.vy + part * dy
    speed = math.hypot(vx, vy)
    if speed < STANDING and speed_of(tick) < STANDING:
        tick.hold = 1.0
        return
    tick.desired_speed = speed
    tick.max_speed = max(speed, speed_of(tick))
    # A point half a meter ahead, which the next tick puts farther on.
    ahead = 0.5 / max(speed, STANDING)
    head_for(tick, tick.x + ahead * vx, tick.y + ahead * vy, 0.0)


@jit_part
def walk_to(tick, x, y, speed):
    """Walks to a point at a speed."""
    head_for(tick, x, y, _REACH)
    tick.desired_speed = speed
    tick.max_speed = speed


@jit_part
def run_for(tick, own, duration):
    """Returns the status of an action that lasts `duration`, or for ever.

    The first of its own numbers counts the ticks.
    """
    own[0] += 1
    if duration > 0 and steps_reach(own[0], tick.time_step, duration):
        own[0] = 0.0
        return SUCCESS
    return RUNNING


@jit_part
def stand(tick):
    """Stands still."""
    tick.hold = _STAND


@jit_part
def approach_speed(tick, left):
    """Returns the speed for a way of which some meters are left."""
    return min(tick.max_speed, max(_SLOWLY, left / _SOON))


@jit_part
def settle(tick, x, y, off=_OFF):
    """Walks to a point and stays there; returns whether the person is there.

    Whoever stands goes on standing up to the distance `off`.
    """
    left = math.hypot(x - tick.x, y - tick.y)
    is_still = speed_of(tick) < STANDING
    if left <= SETTLED or (is_still and left <= off):
        stand(tick)
        return True
    walk_to(tick, x, y, approach_speed(tick, left))
    if left < _PRESSES and speed_of(tick) < _SLOWLY / 2:
        # (Walls near the point hold nobody back.)
        tick.desired_speed = PRESSING
    return False
