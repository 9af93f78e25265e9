"""Actions of people who meet a robot: StandStill, PassBy, KeepOff."""

import itertools
import math
from typing import Annotated

from hunav_drake.systems.behavior.leaves.pacing import (
    AIM,
    PRESSING,
    Deceleration,
    PortDistance,
    TurnRate,
    come_to_rest,
    face,
    head_for,
    walk_at,
)
from hunav_drake.systems.behavior.leaves.reactions import TURN_RATE
from hunav_drake.systems.behavior.leaves.robot_conditions import (
    SLOW,
    Distance,
    OnWay,
    before_goal,
    between,
    way,
)
from hunav_drake.systems.behavior.leaves.spots import SQUEEZE, WALL_GAP
from hunav_drake.systems.behavior.leaves.walking import (
    GOAL_MARGIN,
    IGNORED,
    ROLES,
    BehaviorStatus,
    Role,
)
from hunav_drake.systems.behavior.nodes.control_flow import steps_reach
from hunav_drake.systems.behavior.nodes.registry import register_action
from hunav_drake.systems.behavior.nodes.status import NodeStatus
from hunav_drake.systems.behavior.nodes.tick_context import Row, TickContext
from hunav_drake.systems.common.layout import RADIUS, VX, VY, Command, X, Y
from hunav_drake.systems.common.schema import within

# The gap between the body and a wall, in meters.
_WALL_GAP = 0.15

# A person less far beside the robot's course is on it, in meters.
_BESIDE = 0.1

# The least gain of room for which people change sides, in meters.
_WORTH = 0.1

# The distance of the point ahead that a person who passes a robot walks to, in
# meters.
_AHEAD = 0.2

# The gap to a robot that people do not pass, body to body, in meters, and
# their deceleration for it, in m/s^2.
_KEEP_OFF = 0.5
_BRAKING = 2.5

# The additional distance of a robot at which passing ends, in meters: else it
# would begin again at once.
_LEEWAY = 0.5


@register_action("StandStill", memory={"ticks": 0.0}, ignored=IGNORED)
def stand_still(
    context: TickContext,
    own: list[float],
    *,
    seconds: Annotated[float, within(0, 1e9, "s")] = 0.0,
    turn_rate: TurnRate = TURN_RATE,
    deceleration: Deceleration = 0.0,
    status: BehaviorStatus = 1,
) -> NodeStatus:
    """Stands still and turns to the robot, if there is one.

    It runs for `seconds`, and for one tick at least, with the behavior status
    `status`. The person slows down by `deceleration` at most, or stops at once
    if it is 0.
    """
    come_to_rest(context, deceleration)
    robot = context.robot
    if robot is not None:
        face(context, robot[X], robot[Y], turn_rate)
    context.behavior_status = status
    own[0] += 1
    if steps_reach(own[0], context.person.time_step, seconds):
        own[0] = 0.0
        return NodeStatus.SUCCESS
    return NodeStatus.RUNNING


@register_action(
    "PassBy",
    memory={"chosen": 0.0, "point x": 0.0, "point y": 0.0},
    ignored=IGNORED,
)
def pass_by(
    context: TickContext,
    own: list[float],
    *,
    distance: Distance,
    clearance: PortDistance = 1.0,
    gap: PortDistance = 0.0,
    room: PortDistance = 0.0,
    robot: Role = "obstacle",
    status: BehaviorStatus = 1,
) -> NodeStatus:
    """Walks on towards the goal, past all robots at a distance of `clearance`.

    With a `gap` above 0, it leaves at least that between the bodies.
    The side is the one with the smaller detour, the right-hand one if a robot
    is right ahead, and is kept. Where walls or robots leave less room, the
    person passes where there is most: first the nearest robots, then those
    behind them. The point to walk to is never beyond a wall; where two bodies
    hardly fit in, the body touches the wall there. With a `room` above 0, the
    person does not pass a moving robot with less than that between the bodies,
    or a standing one with less than 0.05 m, but keeps 0.5 m off it, and leans
    on walls to get that room. The action runs until no robot is between the
    person and the goal, at most 0.5 m farther away than `distance`; its
    behavior status is `status`.
    """
    state, command = context.state, context.command
    clearance = between(context, clearance, gap)
    # (A person who leaned on a wall cuts in no sooner than that.)
    behind = clearance if room and own[0] else 0.0
    robots = before_goal(context, distance + _LEEWAY, clearance, behind)
    if not robots:
        own[0] = 0.0
        return NodeStatus.SUCCESS
    command[Command.ROBOT_ROLE] = ROLES[robot]
    context.behavior_status = status
    gx, gy = way(context)
    usual = -_BESIDE
    if own[0]:
        usual = gx * (own[2] - state[Y]) - gy * (own[1] - state[X])
    off = context.person.body_radius + WALL_GAP if room else state[RADIUS]
    lane = _find_lane(context, robots, clearance, usual, off)
    # (Before the robot it may be narrower than beside it.)
    reach = abs(lane) + off
    part = context.cast_ray(
        state[X] - math.copysign(reach, lane) * gy,
        state[Y] + math.copysign(reach, lane) * gx,
    )
    free = max(reach * part - off, 0.0)
    lane = math.copysign(min(abs(lane), free), lane)
    ahead = _AHEAD
    if room:
        if _keeps_off(context, robots, lane, room):
            return NodeStatus.RUNNING
        wall = abs(lane) + state[RADIUS]
        if (
            context.cast_ray(
                state[X] - math.copysign(wall, lane) * gy,
                state[Y] + math.copysign(wall, lane) * gx,
            )
            <= 1
        ):
            ahead = min(max(abs(lane), AIM), _AHEAD)
            command[Command.DESIRED_SPEED] = PRESSING
    dx, dy = ahead * gx - lane * gy, ahead * gy + lane * gx
    x, y = state[X] + dx, state[Y] + dy
    # (The way around a wall across leads to the goal itself.)
    if context.cast_ray(x + state[RADIUS] * gx, y + state[RADIUS] * gy) > 1:
        own[:] = [1.0, x, y]
        head_for(context, x, y, 0.0)
    return NodeStatus.RUNNING


@register_action("KeepOff", ignored=IGNORED)
def keep_off(context: TickContext, *, distance: Distance = 2.5) -> NodeStatus:
    """Keeps off a robot right ahead on the way to the goal, or at the goal.

    The person comes no nearer to it than 0.5 m, body to body, and moves along
    with it. The action fails if no robot within `distance` makes the person
    slow down, or if the person is at the goal.
    """
    goal, state = context.goal, context.state
    if goal is None or (
        math.hypot(goal[0] - state[X], goal[1] - state[Y])
        <= context.person.goal_radius + GOAL_MARGIN
    ):
        return NodeStatus.FAILURE
    most = context.command[Command.MAX_SPEED]
    robots = before_goal(context, distance, 0.0)
    _keeps_off(context, robots, 0.0, _KEEP_OFF)
    held = context.command[Command.HOLD] != 0
    slower = context.command[Command.MAX_SPEED] < most
    return NodeStatus.SUCCESS if held or slower else NodeStatus.FAILURE


def _keeps_off(
    context: TickContext, robots: list[OnWay], lane: float, room: float
) -> bool:
    """Stays off a robot that leaves no room to pass; returns whether it does.

    The lane is to the left of the way; 0 is straight on. `room` is the least
    gap between the bodies, in meters; 0.05 m is enough beside a robot that
    stands.
    """
    body = context.person.body_radius
    gx, gy = way(context)
    for it in robots:
        row = context.robots[it.row]
        both = body + row[RADIUS]
        along = row[VX] * gx + row[VY] * gy
        stands = math.hypot(row[VX], row[VY]) < SLOW
        needed = min(room, SQUEEZE) if stands else room
        is_free = abs(lane - it.beside) - both >= needed
        if lane:
            # (A lane is not quite along the walls, which are asked, too.)
            off = abs(lane - it.beside) - both
            is_free = off >= needed - _WORTH and _fits(
                context, row, lane - it.beside, needed
            )
        if it.ahead <= 0 or is_free:
            continue
        speed = along + (it.ahead - both - _KEEP_OFF)
        if speed <= 0:
            come_to_rest(context, _BRAKING)
        elif speed < context.command[Command.MAX_SPEED]:
            walk_at(context, speed, _BRAKING)
        return True
    return False


def _fits(context: TickContext, robot: Row, side: float, room: float) -> bool:
    """Returns whether a body fits between a robot and the wall beside it."""
    gx, gy = way(context)
    reach = 2 * context.person.body_radius + WALL_GAP + room + robot[RADIUS]
    reach = math.copysign(reach, side)
    x, y = robot[X] - reach * gy, robot[Y] + reach * gx
    return context.cast_ray(x, y, robot) > 1


def _find_lane(
    context: TickContext,
    robots: list[OnWay],
    clearance: float,
    usual: float,
    body: float,
) -> float:
    """Returns the lane past robots: meters to the left of the way."""
    blocking = [it.ahead for it in robots if abs(it.beside) < clearance]
    if not blocking:
        return 0.0
    room, lane = _widest_lane(context, robots, clearance, usual, body)
    if room < clearance - _WORTH:
        # Not past all of them at once, but past those that are side by side.
        first = min(blocking)
        abreast = [it for it in robots if abs(it.ahead - first) < clearance]
        _, lane = _widest_lane(context, abreast, clearance, usual, body)
    return lane


def _widest_lane(
    context: TickContext,
    robots: list[OnWay],
    clearance: float,
    usual: float,
    body: float,
) -> tuple[float, float]:
    """Returns the room, up to `clearance`, and the lane with the most of it."""
    beside = sorted(it.beside for it in robots)
    left, left_gap = _wall_beside(context, robots, clearance, 1.0)
    right, right_gap = _wall_beside(context, robots, clearance, -1.0)
    # Where two bodies hardly fit in, one touches the wall, on either side.
    narrow = min(left_gap, right_gap) < 2 * (context.state[RADIUS] + _WALL_GAP)
    off = body if narrow else context.state[RADIUS] + _WALL_GAP
    left, right = max(left - off, beside[-1]), min(right + off, beside[0])
    lanes = [
        *(b - clearance for b in beside),
        *(b + clearance for b in beside),
        *((a + b) / 2 for a, b in itertools.pairwise(beside)),
    ]
    rooms = [
        (min(clearance, *(abs(lane - b) for b in beside)), lane)
        for lane in (min(max(lane, right), left) for lane in lanes)
    ]
    enough = max(rooms)[0] - _WORTH
    return min(
        (it for it in rooms if it[0] >= enough),
        key=lambda it: abs(it[1] - usual),
    )


def _wall_beside(
    context: TickContext, robots: list[OnWay], clearance: float, side: float
) -> tuple[float, float]:
    """Returns the lane of the wall beside robots on a side: 1 left, -1 right.

    After it comes the gap between it and the body of the nearest robot.
    """
    gx, gy = way(context)
    outermost = max(robots, key=lambda it: side * it.beside)
    row = context.robots[outermost.row]
    reach = clearance + context.state[RADIUS] + _WALL_GAP
    wall = reach * context.cast_ray(
        row[X] - side * reach * gy, row[Y] + side * reach * gx, row
    )
    return outermost.beside + side * wall, wall - row[RADIUS]
