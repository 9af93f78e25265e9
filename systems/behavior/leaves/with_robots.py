"""Walking beside a robot, and waiting for one that bars the way."""

import math
from typing import Literal

from hunav_drake.systems.behavior.leaves.others import distance_between
from hunav_drake.systems.behavior.leaves.pacing import (
    STANDING,
    PortDistance,
    PortSpeed,
    PositiveDistance,
    approach_speed,
    face,
    run_for,
    speed_of,
    stand,
    walk_to,
)
from hunav_drake.systems.behavior.leaves.reactions import TURN_RATE
from hunav_drake.systems.behavior.leaves.robot_conditions import course
from hunav_drake.systems.behavior.leaves.social_ports import Seconds
from hunav_drake.systems.behavior.leaves.spots import free_way
from hunav_drake.systems.behavior.leaves.walking import IGNORED, Role, act
from hunav_drake.systems.behavior.nodes.registry import register_action
from hunav_drake.systems.behavior.nodes.social import look_at, show_activity
from hunav_drake.systems.behavior.nodes.status import (
    FAILURE,
    RUNNING,
    SUCCESS,
    NodeStatus,
)
from hunav_drake.systems.behavior.nodes.tick import (
    Tick,
    cast_ray,
    goal_of,
    has_goal,
    kept_robot,
    robot_at,
)
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit, jit_part
from hunav_drake.systems.common.layout import Activity

_ACCOMPANY, _WAIT = float(Activity.ACCOMPANY), float(Activity.WAIT)

# A robot is expected where it is after the first time; a gap to the spot beside
# it is to be closed in the second one. In seconds.
_AHEAD, _CLOSING = 0.1, 1.0

# Beside a robot slower than this, in m/s, a person stands who is this near to
# the spot, and goes on standing up to the second distance, in meters.
_SLOW, _THERE, _OFF = 0.1, 0.2, 0.35

# A robot that passes bodies at least this far off leaves the way free; a person
# who waits stands until it is this much farther away. In meters.
_GAP, _FARTHER = 0.1, 0.3


@register_action(
    "AccompanyRobot",
    memory={"ticks": 0.0, "robot": 0.0, "side": 0.0},
    ignored=IGNORED,
    social=True,
)
@jit
def accompany_robot(
    tick: Tick,
    own: Array,
    side: Literal["auto", "left", "right"] = "auto",
    spacing: PositiveDistance = 1.0,
    ahead: PortDistance = 0.0,
    max_vel: PortSpeed = 1.6,
    duration: Seconds = 0.0,
    robot: Role = "pedestrian",
) -> NodeStatus:
    """Walks beside the robot, at a `spacing` from center to center.

    The side "auto" is the one with more room at the start, or else the nearer
    one. The action ends after `duration`; it fails if there is no robot.
    """
    index = kept_robot(tick, own, 1)
    if index < 0:
        own[0] = 0.0
        own[2] = 0.0
        return FAILURE
    it = robot_at(tick, index)
    act(tick, robot)
    show_activity(tick, _ACCOMPANY, -1, -1)
    hx, hy = course(it)
    if own[2] == 0:
        own[2] = _side(tick, it, int(side), spacing)
    lx, ly = _left(it)
    nx, ny = own[2] * lx, own[2] * ly
    reach = free_way(tick, it.x, it.y, nx, ny, spacing, 0.0)
    fast = speed_of(it)
    before = ahead + _AHEAD * fast
    x = it.x + reach * nx + before * hx
    y = it.y + reach * ny + before * hy
    gap = math.hypot(x - tick.x, y - tick.y)
    is_still = speed_of(tick) < STANDING
    if fast < _SLOW and gap < (_OFF if is_still else _THERE):
        stand(tick)
        face(tick, it.x, it.y, TURN_RATE)
    else:
        speed = min(max_vel, tick.max_speed, fast + gap / _CLOSING)
        walk_to(tick, x, y, speed)
    status: NodeStatus = run_for(tick, own, duration)
    if status == SUCCESS:
        own[1] = 0.0
        own[2] = 0.0
    return status


@jit_part
def _left(it):
    """Returns the left of a robot's course, or of its reverse when it backs."""
    hx, hy = course(it)
    backs = hx * math.cos(it.yaw) + hy * math.sin(it.yaw) < 0
    return (hy, -hx) if backs else (-hy, hx)


@jit_part
def _side(tick, it, side, spacing):
    """Returns the side of a robot to walk on: 1 is the left, -1 the right."""
    if side > 0:
        return 1.0 if side == 1 else -1.0
    lx, ly = _left(it)
    reach = spacing + tick.radius
    left = free_way(tick, it.x, it.y, lx, ly, reach, 0.0)
    right = free_way(tick, it.x, it.y, -lx, -ly, reach, 0.0)
    if left != right:
        return 1.0 if left > right else -1.0
    return 1.0 if lx * (tick.x - it.x) + ly * (tick.y - it.y) >= 0 else -1.0


@jit_part
def _bars_the_way(tick, it, distance):
    """Returns whether a robot bars the straight way to the goal."""
    x, y = goal_of(tick)
    dx, dy = x - tick.x, y - tick.y
    length = math.hypot(dx, dy)
    rx, ry = it.x - tick.x, it.y - tick.y
    ahead = rx * dx + ry * dy
    if ahead <= 0 or math.hypot(rx, ry) > distance:
        return False
    part = min(ahead / length**2, 1.0)
    near = math.hypot(rx - part * dx, ry - part * dy)
    if near >= tick.radius + it.radius + _GAP:
        return False
    # (A robot behind a wall is not on the way.)
    if cast_ray(tick, tick, it.x, it.y) <= 1:
        return False
    reach = (it.radius + 2 * tick.radius + _GAP) / length
    for side in (reach, -reach):
        if cast_ray(tick, it, it.x - side * dy, it.y + side * dx) > 1:
            return False
    return True


@register_action(
    "WaitForFreeWay", memory={"stands": 0.0}, ignored=IGNORED, social=True
)
@jit
def wait_for_free_way(
    tick: Tick,
    own: Array,
    distance: PortDistance = 5.0,
    stop: PortDistance = 1.5,
    robot: Role = "pedestrian",
) -> NodeStatus:
    """Waits before a robot that bars the straight way to the goal.

    That is one on the way with no room to pass it on either side. The person
    goes up to `stop` of it, stands and faces it. The action succeeds once the
    way is free.
    """
    nearest, found = math.inf, -1
    if has_goal(tick):
        for i in range(tick.num_robots):
            away = distance_between(tick, robot_at(tick, i))
            if away < nearest and _bars_the_way(
                tick, robot_at(tick, i), distance
            ):
                nearest, found = away, i
    if found < 0:
        own[0] = 0.0
        return SUCCESS
    it = robot_at(tick, found)
    act(tick, robot)
    show_activity(tick, _WAIT, -1, -1)
    look_at(tick, tick.num_humans + found, it.x, it.y)
    left = nearest - stop
    if left <= (_FARTHER if own[0] != 0 else 0.0):
        own[0] = 1.0
        stand(tick)
        face(tick, it.x, it.y, TURN_RATE)
    else:
        own[0] = 0.0
        walk_to(tick, it.x, it.y, approach_speed(tick, left))
    return RUNNING
