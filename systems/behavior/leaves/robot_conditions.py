"""Conditions about robots: IsRobotVisible, IsRobotApproaching, ...

A condition that holds notices a robot, the nearest of those that fit. The
actions after it refer to that robot.
"""

import math
from typing import Annotated

import numpy as np

from hunav_drake.systems.behavior.leaves.pacing import speed_of, wrapped
from hunav_drake.systems.behavior.leaves.walking import IGNORED
from hunav_drake.systems.behavior.nodes.control_flow import steps_reach
from hunav_drake.systems.behavior.nodes.pointers import numbers_at
from hunav_drake.systems.behavior.nodes.registry import register_condition
from hunav_drake.systems.behavior.nodes.tick import (
    Tick,
    goal_of,
    has_goal,
    robot_at,
    sees,
)
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit, jit_part
from hunav_drake.systems.common.schema import within

# The field of view of people, a little more than half a turn, in radians.
FIELD_OF_VIEW = 2 * (math.pi / 2 + 0.17)

# A robot slower than this stands, in m/s.
SLOW = 0.05

# The largest movement of a person who stands, in the time of waiting, in
# meters: people who want to walk on do not stand quite still.
_STILL = 0.3

# The cosine of headings that meet head-on: within 60 degrees of opposite.
_OPPOSITE = -math.cos(math.pi / 3)

Distance = Annotated[float, within(0, 1e5, "m")]

# The columns of `before_goal`.
AHEAD, BESIDE, ROW = 0, 1, 2


@jit_part
def course(robot):
    """Returns the unit vector of a robot's velocity; of its heading at rest."""
    speed = speed_of(robot)
    if speed < SLOW:
        return math.cos(robot.yaw), math.sin(robot.yaw)
    return robot.vx / speed, robot.vy / speed


@jit_part
def _is_clear(tick, index, occlusion):
    """Returns whether no wall hides a robot; always without `occlusion`."""
    robot = robot_at(tick, index)
    return occlusion == 0 or sees(tick, robot.x, robot.y)


@jit_part
def _fitting(tick):
    """Returns an array for the distance of each robot; else infinity."""
    return numbers_at(tick.distances)


@jit_part
def _notice_nearest(tick, occlusion):
    """Notices the nearest robot that no wall hides; returns its index or -1.

    The robots that fit otherwise have their distances in `_fitting`.
    """
    found = _fitting(tick)
    while True:
        nearest, index = math.inf, -1
        for i in range(tick.num_robots):
            if found[i] < nearest:
                nearest, index = found[i], i
        if index < 0:
            return -1
        if _is_clear(tick, index, occlusion):
            tick.noticed = index
            return index
        found[index] = math.inf


@register_condition(
    "IsRobotVisible",
    memory={"ticks left": 0.0, "robot": 0.0, "noticed": 0.0},
    ignored=IGNORED,
)
@jit
def is_robot_visible(
    tick: Tick,
    own: Array,
    distance: Distance,
    field_of_view: Annotated[
        float, within(0, 2 * math.pi, "rad")
    ] = FIELD_OF_VIEW,
    occlusion: bool = True,
    memory: Annotated[float, within(0, 1e9, "s")] = 0.0,
    track: bool = False,
    hysteresis: Distance = 0.0,
) -> bool:
    """Holds if a robot's center is near, in view, and not behind a wall.

    Walls have no effect without `occlusion`. A robot that is noticed counts as
    near up to `hysteresis` beyond `distance`. A person who loses sight of the
    robot remembers it for the time `memory`; with `track`, that time does not
    run while the robot is merely out of view: near, and not behind a wall.
    """
    found = _fitting(tick)
    for i in range(tick.num_robots):
        robot = robot_at(tick, i)
        found[i] = math.inf
        dx, dy = robot.x - tick.x, robot.y - tick.y
        away = math.hypot(dx, dy)
        is_noticed = own[2] != 0 and i == own[1]
        if away > distance + (hysteresis if is_noticed else 0.0):
            continue
        off = abs(wrapped(math.atan2(dy, dx) - tick.yaw))
        if off <= field_of_view / 2:
            found[i] = away
    seen = _notice_nearest(tick, occlusion)
    if seen >= 0:
        own[0] = round(memory / tick.time_step)
        own[1] = seen
        own[2] = 1.0
        return True
    remembered = int(own[1])
    # (The memory may be of a trial with more robots.)
    if own[0] == 0 or not 0 <= remembered < tick.num_robots:
        own[2] = 0.0
        return False
    tick.noticed = remembered
    robot = robot_at(tick, remembered)
    away = math.hypot(robot.x - tick.x, robot.y - tick.y)
    is_near = away <= distance + hysteresis and _is_clear(
        tick, remembered, occlusion
    )
    if not (track and is_near):
        own[0] -= 1
    return True


@register_condition("IsRobotClose", ignored=IGNORED)
@jit
def is_robot_close(tick: Tick, threshold: Distance = 1.0) -> bool:
    """Holds if the center of a robot is nearer than `threshold`."""
    found = _fitting(tick)
    for i in range(tick.num_robots):
        robot = robot_at(tick, i)
        away = math.hypot(robot.x - tick.x, robot.y - tick.y)
        found[i] = away if away < threshold else math.inf
    return bool(_notice_nearest(tick, False) >= 0)


@register_condition("IsRobotFacingAgent", ignored=IGNORED)
@jit
def is_robot_facing_agent(
    tick: Tick,
    angle: Annotated[float, within(0, math.pi, "rad")] = 0.3,
    distance: Distance = 1e5,
    occlusion: bool = True,
) -> bool:
    """Holds if a robot faces the person within `angle`, in sight."""
    found = _fitting(tick)
    for i in range(tick.num_robots):
        robot = robot_at(tick, i)
        dx, dy = tick.x - robot.x, tick.y - robot.y
        away = math.hypot(dx, dy)
        off = abs(wrapped(math.atan2(dy, dx) - robot.yaw))
        found[i] = away if away <= distance and off <= angle else math.inf
    return bool(_notice_nearest(tick, occlusion) >= 0)


@register_condition("IsRobotApproaching", ignored=IGNORED)
@jit
def is_robot_approaching(
    tick: Tick,
    distance: Distance,
    width: Distance = 1.0,
    head_on: bool = False,
    occlusion: bool = True,
    standing_distance: Distance = 0.0,
    at_rest: bool = False,
    only_without_goal: bool = False,
) -> bool:
    """Holds if a robot is about to pass near the person.

    The person is ahead of it, at most `distance` along its course and `width`
    beside it. With `head_on`, the person must also face it; with `at_rest`, a
    person who stands need not. A robot that stands counts only up to
    `standing_distance`, as if it were to drive on. With `only_without_goal`,
    the condition never holds for a person who has a goal.
    """
    if only_without_goal and has_goal(tick):
        return False
    must_face = bool(head_on)
    if at_rest and speed_of(tick) < SLOW:
        must_face = False
    found = _fitting(tick)
    for i in range(tick.num_robots):
        robot = robot_at(tick, i)
        found[i] = math.inf
        hx, hy = course(robot)
        rx, ry = tick.x - robot.x, tick.y - robot.y
        along = rx * hx + ry * hy
        stands = speed_of(robot) < SLOW
        if not 0 < along <= (standing_distance if stands else distance):
            continue
        facing = hx * math.cos(tick.yaw) + hy * math.sin(tick.yaw)
        is_on_course = abs(hx * ry - hy * rx) <= width
        if is_on_course and (not must_face or facing <= _OPPOSITE):
            found[i] = along
    return bool(_notice_nearest(tick, occlusion) >= 0)


@register_condition("IsRobotInTheWay", ignored=IGNORED)
@jit
def is_robot_in_the_way(
    tick: Tick,
    distance: Distance,
    clearance: Distance = 1.0,
    gap: Distance = 0.0,
    occlusion: bool = True,
) -> bool:
    """Holds if the straight line to the goal passes too close to a robot.

    The robot is at most `distance` away, between the person and the goal, and
    nearer than `clearance` to the line from the one to the other; a `gap`
    above 0 extends that to robots that it does not leave between the bodies. A
    robot so near to the goal itself cannot be passed, and does not count.
    """
    # (Most robots are far away, most of the time.)
    if not _is_any_near(tick, distance):
        return False
    clearance = between(tick, clearance, gap)
    found = _fitting(tick)
    for i in range(tick.num_robots):
        found[i] = math.inf
    for it in before_goal(tick, distance, clearance, 0.0):
        if abs(it[BESIDE]) < clearance:
            found[int(it[ROW])] = it[AHEAD]
    return bool(_notice_nearest(tick, occlusion) >= 0)


@jit_part
def _is_any_near(tick, distance):
    """Returns whether any robot's center is at most a distance away."""
    for i in range(tick.num_robots):
        robot = robot_at(tick, i)
        if math.hypot(robot.x - tick.x, robot.y - tick.y) <= distance:
            return True
    return False


@jit_part
def between(tick, clearance, gap):
    """Returns the distance to keep from the centers of robots, in meters.

    It is `clearance`, or what leaves a `gap` above 0 between the bodies.
    """
    if gap > 0:
        for i in range(tick.num_robots):
            robot = robot_at(tick, i)
            clearance = max(clearance, tick.radius + robot.radius + gap)
    return clearance


@jit_part
def before_goal(tick, distance, clearance, behind):
    """Returns the robots between the person and the goal.

    They are at most `distance` away, and at most `behind` behind the person.
    Robots nearer to the goal than `clearance` cannot be passed, and do not
    count. All are in meters.

    Returns:
        Shape (k, 3): for each its distance ahead of the person, and to the
        left of the line to the goal, in meters, and its index.
    """
    found = np.empty((tick.num_robots, 3))
    count = 0
    if not has_goal(tick):
        return found[:0]
    x, y = goal_of(tick)
    gx, gy = x - tick.x, y - tick.y
    length = math.hypot(gx, gy)
    if length == 0:
        return found[:0]
    gx, gy = gx / length, gy / length
    for i in range(tick.num_robots):
        robot = robot_at(tick, i)
        dx, dy = robot.x - tick.x, robot.y - tick.y
        ahead, beside = dx * gx + dy * gy, gx * dy - gy * dx
        if math.hypot(dx, dy) > distance or not -behind < ahead < length:
            continue
        if math.hypot(length - ahead, beside) >= clearance:
            found[count, AHEAD] = ahead
            found[count, BESIDE] = beside
            found[count, ROW] = i
            count += 1
    return found[:count]


@jit_part
def way(tick):
    """Returns the unit vector to the goal; of the heading if there is none."""
    if has_goal(tick):
        x, y = goal_of(tick)
        dx, dy = x - tick.x, y - tick.y
        length = math.hypot(dx, dy)
        if length > 0:
            return dx / length, dy / length
    return math.cos(tick.yaw), math.sin(tick.yaw)


_WAITING = {
    "ticks": 0.0,
    "x": math.inf,
    "y": math.inf,
    "robot x": math.inf,
    "robot y": math.inf,
}


@jit_part
def _begin_anew(own):
    own[0] = 0.0
    for i in range(1, 5):
        own[i] = math.inf


@register_condition("IsRobotWaiting", memory=_WAITING, ignored=IGNORED)
@jit
def is_robot_waiting(
    tick: Tick,
    own: Array,
    distance: Distance = 1.0,
    margin: Distance = 0.2,
    seconds: Annotated[float, within(0, 1e9, "s")] = 5.0,
    occlusion: bool = True,
    with_goal: bool = False,
) -> bool:
    """Holds once a robot and the person have stood in each other's way.

    The person is ahead of the robot, less than `margin` beside the way of its
    body, their bodies are at most `distance` apart, and neither has moved more
    than 0.3 m for `seconds`. With `with_goal`, it holds only for people who
    have a goal. It holds for one tick; then the time begins anew.
    """
    index = _nearest_ahead(tick, distance, margin)
    if index < 0 or (with_goal and not has_goal(tick)):
        if own[1] != math.inf:
            _begin_anew(own)
        return False
    robot = robot_at(tick, index)
    moved = math.hypot(tick.x - own[1], tick.y - own[2])
    driven = math.hypot(robot.x - own[3], robot.y - own[4])
    if not (moved <= _STILL and driven <= _STILL):
        own[0] = 0.0
        own[1] = tick.x
        own[2] = tick.y
        own[3] = robot.x
        own[4] = robot.y
        return False
    own[0] += 1
    if not steps_reach(own[0], tick.time_step, seconds):
        return False
    if occlusion and not sees(tick, robot.x, robot.y):
        return False
    _begin_anew(own)
    tick.noticed = index
    return True


@jit_part
def _nearest_ahead(tick, distance, margin):
    """Returns the row of the nearest robot that has the person ahead, or -1."""
    nearest, found = math.inf, -1
    for i in range(tick.num_robots):
        robot = robot_at(tick, i)
        rx, ry = tick.x - robot.x, tick.y - robot.y
        body = robot.radius + tick.radius
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
