"""Actions of people who meet a robot: StandStill, PassBy, KeepOff."""

import math
from typing import Annotated

import numpy as np

from hunav_drake.systems.behavior.leaves.pacing import (
    AIM,
    PRESSING,
    Deceleration,
    PortDistance,
    TurnRate,
    come_to_rest,
    face,
    head_for,
    speed_of,
    walk_at,
)
from hunav_drake.systems.behavior.leaves.reactions import TURN_RATE
from hunav_drake.systems.behavior.leaves.robot_conditions import (
    AHEAD,
    BESIDE,
    ROW,
    SLOW,
    Distance,
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
    robot_at,
    robot_of,
)
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit, jit_part
from hunav_drake.systems.common.schema import within
from hunav_drake.systems.common.sorting import stable_order

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
@jit
def stand_still(
    tick: Tick,
    own: Array,
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
    come_to_rest(tick, deceleration)
    index = robot_of(tick)
    if index >= 0:
        robot = robot_at(tick, index)
        face(tick, robot.x, robot.y, turn_rate)
    tick.behavior_status = status
    own[0] += 1
    if steps_reach(own[0], tick.time_step, seconds):
        own[0] = 0.0
        return SUCCESS
    return RUNNING


@register_action(
    "PassBy",
    memory={"chosen": 0.0, "point x": 0.0, "point y": 0.0},
    ignored=IGNORED,
)
@jit
def pass_by(
    tick: Tick,
    own: Array,
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
    clearance = between(tick, clearance, gap)
    # (A person who leaned on a wall cuts in no sooner than that.)
    behind = clearance if room > 0 and own[0] != 0 else 0.0
    robots = before_goal(tick, distance + _LEEWAY, clearance, behind)
    if len(robots) == 0:
        own[0] = 0.0
        return SUCCESS
    tick.robot_role = ROLES[int(robot)]
    tick.behavior_status = status
    gx, gy = way(tick)
    usual = -_BESIDE
    if own[0] != 0:
        usual = gx * (own[2] - tick.y) - gy * (own[1] - tick.x)
    off = tick.body_radius + WALL_GAP if room > 0 else tick.radius
    lane = _find_lane(tick, robots, clearance, usual, off)
    # (Before the robot it may be narrower than beside it.)
    reach = abs(lane) + off
    part = cast_ray(
        tick,
        tick,
        tick.x - math.copysign(reach, lane) * gy,
        tick.y + math.copysign(reach, lane) * gx,
    )
    free = max(reach * part - off, 0.0)
    lane = math.copysign(min(abs(lane), free), lane)
    ahead = _AHEAD
    if room > 0:
        if _keeps_off(tick, robots, lane, room):
            return RUNNING
        wall = abs(lane) + tick.radius
        part = cast_ray(
            tick,
            tick,
            tick.x - math.copysign(wall, lane) * gy,
            tick.y + math.copysign(wall, lane) * gx,
        )
        if part <= 1:
            ahead = min(max(abs(lane), AIM), _AHEAD)
            tick.desired_speed = PRESSING
    dx, dy = ahead * gx - lane * gy, ahead * gy + lane * gx
    x, y = tick.x + dx, tick.y + dy
    # (The way around a wall across leads to the goal itself.)
    end_x, end_y = x + tick.radius * gx, y + tick.radius * gy
    if cast_ray(tick, tick, end_x, end_y) > 1:
        own[0] = 1.0
        own[1] = x
        own[2] = y
        head_for(tick, x, y, 0.0)
    return RUNNING


@register_action("KeepOff", ignored=IGNORED)
@jit
def keep_off(tick: Tick, distance: Distance = 2.5) -> NodeStatus:
    """Keeps off a robot right ahead on the way to the goal, or at the goal.

    The person comes no nearer to it than 0.5 m, body to body, and moves along
    with it. The action fails if no robot within `distance` makes the person
    slow down, or if the person is at the goal.
    """
    if not has_goal(tick):
        return FAILURE
    x, y = goal_of(tick)
    if math.hypot(x - tick.x, y - tick.y) <= tick.reach + GOAL_MARGIN:
        return FAILURE
    most = tick.max_speed
    robots = before_goal(tick, distance, 0.0, 0.0)
    _keeps_off(tick, robots, 0.0, _KEEP_OFF)
    is_slower = tick.hold != 0 or tick.max_speed < most
    return SUCCESS if is_slower else FAILURE


@jit_part
def _keeps_off(tick, robots, lane, room):
    """Stays off a robot that leaves no room to pass; returns whether it does.

    The lane is to the left of the way; 0 is straight on. `room` is the least
    gap between the bodies, in meters; 0.05 m is enough beside a robot that
    stands.
    """
    body = tick.body_radius
    gx, gy = way(tick)
    for it in robots:
        row = robot_at(tick, int(it[ROW]))
        both = body + row.radius
        along = row.vx * gx + row.vy * gy
        needed = min(room, SQUEEZE) if speed_of(row) < SLOW else room
        off = abs(lane - it[BESIDE]) - both
        is_free = off >= needed
        if lane != 0:
            # (A lane is not quite along the walls, which are asked, too.)
            is_free = off >= needed - _WORTH and _fits(
                tick, row, lane - it[BESIDE], needed
            )
        if it[AHEAD] <= 0 or is_free:
            continue
        speed = along + (it[AHEAD] - both - _KEEP_OFF)
        if speed <= 0:
            come_to_rest(tick, _BRAKING)
        elif speed < tick.max_speed:
            walk_at(tick, speed, _BRAKING)
        return True
    return False


@jit_part
def _fits(tick, robot, side, room):
    """Returns whether a body fits between a robot and the wall beside it."""
    gx, gy = way(tick)
    reach = 2 * tick.body_radius + WALL_GAP + room + robot.radius
    reach = math.copysign(reach, side)
    x, y = robot.x - reach * gy, robot.y + reach * gx
    return cast_ray(tick, robot, x, y) > 1


@jit_part
def _find_lane(tick, robots, clearance, usual, body):
    """Returns the lane past robots: meters to the left of the way."""
    first = math.inf
    for it in robots:
        if abs(it[BESIDE]) < clearance:
            first = min(first, it[AHEAD])
    if first == math.inf:
        return 0.0
    room, lane = _widest_lane(tick, robots, clearance, usual, body)
    if room < clearance - _WORTH:
        # Not past all of them at once, but past those that are side by side.
        abreast = robots[np.abs(robots[:, AHEAD] - first) < clearance]
        _, lane = _widest_lane(tick, abreast, clearance, usual, body)
    return lane


@jit_part
def _widest_lane(tick, robots, clearance, usual, body):
    """Returns the room, up to `clearance`, and the lane with the most of it."""
    count = len(robots)
    beside = np.empty(count)
    for i, place in enumerate(stable_order(robots[:, BESIDE].copy())):
        beside[i] = robots[place, BESIDE]
    left, left_gap = _wall_beside(tick, robots, clearance, 1.0)
    right, right_gap = _wall_beside(tick, robots, clearance, -1.0)
    # Where two bodies hardly fit in, one touches the wall, on either side.
    narrow = min(left_gap, right_gap) < 2 * (tick.radius + _WALL_GAP)
    off = body if narrow else tick.radius + _WALL_GAP
    left = max(left - off, beside[count - 1])
    right = min(right + off, beside[0])
    lanes = np.empty((3 * count - 1, 2))
    for i in range(count):
        lanes[i, 1] = beside[i] - clearance
        lanes[count + i, 1] = beside[i] + clearance
        if i > 0:
            lanes[2 * count + i - 1, 1] = (beside[i - 1] + beside[i]) / 2
    enough = -math.inf
    for it in lanes:
        it[1] = min(max(it[1], right), left)
        it[0] = clearance
        for b in beside:
            it[0] = min(it[0], abs(it[1] - b))
        enough = max(enough, it[0] - _WORTH)
    best = -1
    for i in range(len(lanes)):
        off = abs(lanes[i, 1] - usual)
        if lanes[i, 0] >= enough and (
            best < 0 or off < abs(lanes[best, 1] - usual)
        ):
            best = i
    return lanes[best, 0], lanes[best, 1]


@jit_part
def _wall_beside(tick, robots, clearance, side):
    """Returns the lane of the wall beside robots on a side: 1 left, -1 right.

    After it comes the gap between it and the body of the nearest robot.
    """
    gx, gy = way(tick)
    outermost = 0
    for i in range(1, len(robots)):
        if side * robots[i, BESIDE] > side * robots[outermost, BESIDE]:
            outermost = i
    row = robot_at(tick, int(robots[outermost, ROW]))
    reach = clearance + tick.radius + _WALL_GAP
    wall = reach * cast_ray(
        tick, row, row.x - side * reach * gy, row.y + side * reach * gx
    )
    return robots[outermost, BESIDE] + side * wall, wall - row.radius
