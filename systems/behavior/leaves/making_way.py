"""How people who stand in a robot's way let it pass: IsRobotWaiting, MakeWay.

Both are about the way ahead of the robot: along its heading, while it stands.
"""

import math
from typing import Annotated

from hunav_drake.systems.behavior.leaves.pacing import (
    STANDING,
    Deceleration,
    PortDistance,
    PortSpeed,
    TurnRate,
    come_to_rest,
    face,
    head_for,
    slow_down_before,
    speed_of,
    walk_at,
)
from hunav_drake.systems.behavior.leaves.reactions import TURN_RATE
from hunav_drake.systems.behavior.leaves.robot_conditions import (
    Distance,
    course,
)
from hunav_drake.systems.behavior.leaves.walking import (
    IGNORED,
    ROLES,
    BehaviorStatus,
)
from hunav_drake.systems.behavior.nodes.decorators import steps_reach
from hunav_drake.systems.behavior.nodes.node import NodeStatus
from hunav_drake.systems.behavior.nodes.registry import (
    register_action,
    register_condition,
)
from hunav_drake.systems.behavior.nodes.tick_context import Row, TickContext
from hunav_drake.systems.common.layout import RADIUS, Command, X, Y
from hunav_drake.systems.common.schema import within

# Whoever moves less than this in the time of waiting stands, in meters:
# people who would like to walk on do not stand quite still.
_STILL = 0.3

# How far back along the robot's way people look for room, and in what steps,
# in meters.
_BACK = 6.0
_STEP = 0.25

# What is left free between the body and a wall, in meters.
_WALL_GAP = 0.15

# So little less than the whole way aside is enough, in meters.
_ENOUGH = 0.02

# The room that is worth going for, in meters more than where one is.
_WORTH = 0.2

# Where the person counts as there, in meters; and where someone does who
# comes no nearer, having had time to start, in seconds.
_ARRIVED = 0.1
_NEAR = 0.3
_START = 1.0

_WAITING = {
    "ticks": 0.0,
    "x": math.inf,
    "y": math.inf,
    "robot x": math.inf,
    "robot y": math.inf,
}


@register_condition("IsRobotWaiting", memory=_WAITING, ignored=IGNORED)
def is_robot_waiting(
    context: TickContext,
    own: list[float],
    *,
    distance: Distance = 1.0,
    margin: Distance = 0.2,
    seconds: Annotated[float, within(0, 1e9, "s")] = 5.0,
    occlusion: bool = True,
    with_goal: bool = False,
) -> bool:
    """Holds once a robot and the person have stood in each other's way.

    The person is ahead of the robot, less than `margin` beside the way of its
    body, their bodies are at most `distance` apart, and neither has moved more
    than 0.3 m for `seconds`. With `with_goal`, only those count who have a
    goal to walk to. It holds for one tick; then the time begins anew.
    """
    index = _nearest_ahead(context, distance, margin)
    if index < 0 or (with_goal and context.goal is None):
        if own[1] != math.inf:
            own[:] = _WAITING.values()
        return False
    state = context.state
    robot = context.robots[index]
    moved = math.hypot(state[X] - own[1], state[Y] - own[2])
    driven = math.hypot(robot[X] - own[3], robot[Y] - own[4])
    if not (moved <= _STILL and driven <= _STILL):
        own[:] = [0.0, state[X], state[Y], robot[X], robot[Y]]
        return False
    own[0] += 1
    if not steps_reach(own[0], context.person.time_step, seconds):
        return False
    if occlusion and not context.sees(robot[X], robot[Y]):
        return False
    own[:] = _WAITING.values()
    context.notice(index)
    return True


def _nearest_ahead(context: TickContext, distance: float, margin: float) -> int:
    """Returns the row of the nearest robot that has the person ahead, or -1."""
    state = context.state
    x, y, radius = state[X], state[Y], state[RADIUS]
    nearest, found = math.inf, -1
    for i, robot in enumerate(context.robots):
        rx, ry = x - robot[X], y - robot[Y]
        body = robot[RADIUS] + radius
        # (Most robots are far away, most of the time.)
        reach = body + distance
        if rx > reach or ry > reach or -rx > reach or -ry > reach:
            continue
        gap = math.hypot(rx, ry) - body
        if gap > distance or gap >= nearest:
            continue
        hx, hy = course(robot)
        if rx * hx + ry * hy > 0 and abs(hx * ry - hy * rx) <= body + margin:
            nearest, found = gap, i
    return found


@register_action(
    "MakeWay",
    memory={
        "stage": 0.0,
        "back x": 0.0,
        "back y": 0.0,
        "spot x": 0.0,
        "spot y": 0.0,
        "ticks": 0.0,
        "robot": 0.0,
    },
    ignored=IGNORED,
)
def make_way(
    context: TickContext,
    own: list[float],
    *,
    clearance: PortDistance = 0.3,
    speed: PortSpeed = 0.6,
    seconds: Annotated[float, within(0, 1e9, "s")] = 10.0,
    deceleration: Deceleration = 2.5,
    turn_rate: TurnRate = TURN_RATE,
    status: BehaviorStatus = 2,
) -> NodeStatus:
    """Steps aside, or back and aside, and waits while the robot passes.

    The spot is beside the robot's way, with `clearance` between the bodies
    when it passes, and as far back along it as walls demand, as in a door; it
    is chosen once. The person walks at `speed` at most, waits there until the
    robot has passed, in all for `seconds` at most, and has the behavior status
    `status` meanwhile. The action fails if there is no robot, or no such spot
    to be reached.
    """
    row = context.robot
    if row is None:
        return NodeStatus.FAILURE
    if not own[0]:
        spot = _find_spot(context, row, clearance)
        if spot is None:
            return NodeStatus.FAILURE
        own[:] = [1.0, *spot, 0.0, float(context.robots.index(row))]
    elif own[6] < len(context.robots):
        # (Another one may be nearer now.)
        context.notice(int(own[6]))
        row = context.robots[int(own[6])]
    own[5] += 1
    if steps_reach(own[5], context.person.time_step, seconds):
        own[0] = 0.0
        return NodeStatus.SUCCESS
    if _has_passed(context, row):
        own[0] = 0.0
        return NodeStatus.SUCCESS
    state, command = context.state, context.command
    context.behavior_status = status
    # (The way leads clear of it.)
    command[Command.ROBOT_ROLE] = ROLES["unseen"]
    # (Others or walls may keep the person off the spot.)
    can_go = (
        own[5] * context.person.time_step < _START
        or speed_of(context) > STANDING
    )
    for stage in range(int(own[0]), 3):
        x, y = own[2 * stage - 1], own[2 * stage]
        left = math.hypot(x - state[X], y - state[Y])
        if left > _ARRIVED and (can_go or left > _NEAR):
            own[0] = float(stage)
            head_for(context, x, y, _ARRIVED / 2)
            speed = min(speed, command[Command.MAX_SPEED])
            walk_at(context, speed, deceleration)
            if stage == 2 and deceleration:
                slow_down_before(context, left, deceleration)
            return NodeStatus.RUNNING
    own[0] = 3.0
    come_to_rest(context, deceleration)
    face(context, row[X], row[Y], turn_rate)
    return NodeStatus.RUNNING


def _has_passed(context: TickContext, robot: Row) -> bool:
    """Returns whether a robot is past the person, or away."""
    state = context.state
    rx, ry = state[X] - robot[X], state[Y] - robot[Y]
    hx, hy = course(robot)
    body = state[RADIUS] + robot[RADIUS]
    return rx * hx + ry * hy < -body or math.hypot(rx, ry) > 3 * body + 1.0


def _find_spot(
    context: TickContext, robot: Row, clearance: float
) -> tuple[float, float, float, float] | None:
    """Returns where to go back to, and from there aside; None if nowhere."""
    state = context.state
    x, y, radius = state[X], state[Y], state[RADIUS]
    hx, hy = course(robot)
    # From the robot's way to the person, to the left.
    beside = hx * (y - robot[Y]) - hy * (x - robot[X])
    clear = robot[RADIUS] + radius + clearance
    sides = (1.0, -1.0) if beside >= 0 else (-1.0, 1.0)
    best, spot = -math.inf, None
    back = 0.0
    while back <= _BACK and best < -_ENOUGH:
        ahead = back + radius
        if back and context.cast_ray(x + ahead * hx, y + ahead * hy) <= 1:
            break
        place = (x + back * hx, y + back * hy)
        for side in sides:
            way = max(clear - side * beside, 0.0)
            left = (-side * hy, side * hx)
            free = _free_way(context, place, left, way)
            # (Nearer is better, where there is hardly more room.)
            if free - way > best + _WORTH or best < -_ENOUGH <= free - way:
                best = free - way
                aside = (place[0] + free * left[0], place[1] + free * left[1])
                spot = (*place, *aside)
        back += _STEP
    if spot is None or math.hypot(spot[2] - x, spot[3] - y) < _WORTH:
        return None
    return spot


def _free_way(
    context: TickContext,
    place: tuple[float, float],
    direction: tuple[float, float],
    way: float,
) -> float:
    """Returns how much of a straight way the body has room on, in meters."""
    radius = context.state[RADIUS]
    dx, dy = direction
    reach = way + radius + _WALL_GAP
    free = way
    # Along the middle of the body, and along its sides.
    for shift in (0.0, radius, -radius):
        start = (place[0] - shift * dy, place[1] + shift * dx)
        end = (start[0] + reach * dx, start[1] + reach * dy)
        part = context.cast_ray(*end, start)
        free = min(free, reach * part - radius - _WALL_GAP)
    return max(free, 0.0)
