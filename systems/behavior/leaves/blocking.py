"""The action of blocking the way of a robot: BlockRobot."""

import math
from typing import Annotated, NamedTuple

from hunav_drake.systems.behavior.leaves.pacing import (
    PortDistance,
    PortSpeed,
    TurnRate,
    come_to_rest,
    face,
    walk_with,
    wrapped,
)
from hunav_drake.systems.behavior.leaves.reactions import TURN_RATE
from hunav_drake.systems.behavior.leaves.walking import IGNORED, UNSEEN
from hunav_drake.systems.behavior.nodes.registry import register_action
from hunav_drake.systems.behavior.nodes.status import (
    FAILURE,
    SUCCESS,
    NodeStatus,
)
from hunav_drake.systems.behavior.nodes.tick import (
    Tick,
    cast_ray,
    robot_at,
    robot_of,
)
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit, jit_part
from hunav_drake.systems.common.schema import within

# The least distance by which the place is farther from the robot than the way
# around it, in meters.
_LEEWAY = 0.05

# The largest ratio of speed to remaining distance, in 1/s, which ends the
# approach without a jerk.
_CLOSING = 2.0

# A person within the first distance of the place holds the ground, in meters.
# Over the second distance beyond, or by which the gap is too small, the person
# takes up the velocity of the robot.
_THERE = 0.2
_BLEND = 0.15

# A person within this angle of the robot's axis, behind it, keeps to the
# chosen side, in radians.
_BEHIND = math.pi / 4


class _Leg(NamedTuple):
    """A direction to walk in, (x, y), and the distance left, in meters.

    It is infinite while the way leads around the robot.
    """

    x: float
    y: float
    left: float


@register_action("BlockRobot", memory={"side": 0.0}, ignored=IGNORED)
@jit
def block_robot(
    tick: Tick,
    own: Array,
    distance: PortDistance = 1.1,
    gap: PortDistance = 0.3,
    speed: PortSpeed = 2.0,
    acceleration: Annotated[
        float, within(0, 100, "m/s^2", low_open=True)
    ] = 2.5,
    face_distance: PortDistance = 0.5,
    turn_rate: TurnRate = TURN_RATE,
) -> NodeStatus:
    """Walks in front of the robot, around it, and stays there.

    The place is `distance` ahead of the robot's center: farther for a wide
    robot, nearer before a wall; without room there, the person stands. The
    bodies keep `gap` apart on the way. The person passes the robot on the side
    where it is, from right behind on the left or on the side without a wall,
    and keeps to that side. Between two walls it stays behind the robot. It
    walks at `speed` at most, which may be above its own maximum, and at the
    place it gives way only as far as `gap` demands. Within `face_distance` of
    the place it looks at the robot. The action fails if there is no robot.
    """
    index = robot_of(tick)
    if index < 0:
        return FAILURE
    it = robot_at(tick, index)
    tick.behavior_status = 1
    # (The way leads clear of it.)
    tick.robot_role = UNSEEN
    keep = it.radius + tick.radius + gap
    distance = max(distance, keep + _LEEWAY)
    distance = min(distance, _room_ahead(tick, it, distance))
    if distance < keep:
        come_to_rest(tick, acceleration)
        face(tick, it.x, it.y, turn_rate)
        return SUCCESS
    leg = _leg(tick, it, own, keep, distance)
    own_speed = min(
        speed, math.sqrt(2 * acceleration * leg.left), _CLOSING * leg.left
    )
    # The place moves with the robot, and turns with it. A person there holds
    # the ground, until the bodies come too near.
    away = math.hypot(it.x - tick.x, it.y - tick.y)
    part = max((leg.left - _THERE) / _BLEND, (keep - away) / _BLEND)
    part = min(max(part, 0.0), 1.0)
    turn = it.omega * distance if leg.left < distance else 0.0
    vx = part * it.vx - turn * math.sin(it.yaw)
    vy = part * it.vy + turn * math.cos(it.yaw)
    own_speed = min(own_speed, _reserve(leg, vx, vy, speed))
    vx, vy = vx + own_speed * leg.x, vy + own_speed * leg.y
    fast = math.hypot(vx, vy)
    if fast > speed:
        vx, vy = vx / fast * speed, vy / fast * speed
    walk_with(tick, vx, vy, acceleration)
    if leg.left <= face_distance:
        face(tick, it.x, it.y, turn_rate)
    return SUCCESS


@jit_part
def _room_ahead(tick, robot, distance):
    """Returns the distance ahead of a robot with room for the person, in m."""
    reach = distance + tick.radius
    x = robot.x + reach * math.cos(robot.yaw)
    y = robot.y + reach * math.sin(robot.yaw)
    return reach * cast_ray(tick, robot, x, y) - tick.radius


@jit_part
def _reserve(leg, vx, vy, speed):
    """Returns the speed limit along a leg on top of a velocity, in m/s."""
    along = leg.x * vx + leg.y * vy
    root = along * along + speed * speed - vx * vx - vy * vy
    return max(math.sqrt(max(root, 0.0)) - along, 0.0)


@jit_part
def _leg(tick, robot, own, keep, distance):
    """Returns the way to the place ahead of a robot, or around the robot.

    The place is at `distance` from the robot's center, which is kept at least
    at `keep`, in meters; `own` is the side to keep to: 1 left, -1 right of the
    robot, 0 neither.
    """
    px, py = tick.x - robot.x, tick.y - robot.y
    qx = distance * math.cos(robot.yaw) - px
    qy = distance * math.sin(robot.yaw) - py
    left = math.hypot(qx, qy)
    away = math.hypot(px, py)
    angle = wrapped(math.atan2(py, px) - robot.yaw)
    # The point on the straight way that is nearest to the robot.
    part = min(max(-(px * qx + py * qy) / max(left, 1e-9) ** 2, 0.0), 1.0)
    near = math.hypot(px + part * qx, py + part * qy)
    if left == 0 or near >= min(keep, away) - 1e-9:
        own[0] = 0.0
        return _Leg(qx / max(left, 1e-9), qy / max(left, 1e-9), left)
    if own[0] == 0 or abs(angle) < math.pi - _BEHIND:
        own[0] = _side(tick, robot, keep, angle)
    side = own[0]
    if side == 0:
        # No way around it: behind it, as near as allowed.
        away = max(away, 1e-9)
        sign = 1.0 if away < keep else -1.0
        return _Leg(sign * px / away, sign * py / away, abs(away - keep))
    if away <= keep:
        # Along the circle, and out of it.
        out = min((keep - away) / 0.2, 1.0)
        bearing = robot.yaw + angle - side * (1 - out) * math.pi / 2
    else:
        # To where a straight way touches it.
        bearing = robot.yaw + angle + math.pi
        bearing += side * math.asin(keep / away)
    return _Leg(math.cos(bearing), math.sin(bearing), math.inf)


@jit_part
def _side(tick, robot, keep, angle):
    """Returns the side to pass a robot on: 1 left, -1 right of it, 0 none."""
    side = 1.0 if angle >= 0 else -1.0
    reach = keep + tick.radius
    for each in (side, -side):
        x = robot.x - each * reach * math.sin(robot.yaw)
        y = robot.y + each * reach * math.cos(robot.yaw)
        if cast_ray(tick, robot, x, y) > 1:
            return each
    return 0.0
