"""Conditions about robots: IsRobotVisible, IsRobotApproaching, ...

A condition that holds notices a robot, the nearest of those that fit. The
actions after it refer to that robot.
"""

import math
from typing import Annotated, NamedTuple

from hunav_drake.systems.behavior.leaves.walking import IGNORED
from hunav_drake.systems.behavior.nodes.control_flow import steps_reach
from hunav_drake.systems.behavior.nodes.registry import register_condition
from hunav_drake.systems.behavior.nodes.tick_context import Row, TickContext
from hunav_drake.systems.common.layout import RADIUS, VX, VY, YAW, X, Y
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


def course(robot: Row) -> tuple[float, float]:
    """Returns the unit vector of a robot's velocity; of its heading at rest."""
    speed = math.hypot(robot[VX], robot[VY])
    if speed < SLOW:
        return math.cos(robot[YAW]), math.sin(robot[YAW])
    return robot[VX] / speed, robot[VY] / speed


def _is_clear(context: TickContext, index: int, occlusion: bool) -> bool:
    """Returns whether no wall hides a robot; always without `occlusion`."""
    robot = context.robots[index]
    return not occlusion or context.sees(robot[X], robot[Y])


def _notice_nearest(
    context: TickContext, found: list[tuple[float, int]], occlusion: bool
) -> int:
    """Notices the nearest robot that no wall hides; returns its index or -1.

    The robots that fit otherwise are given by their distances and indices.
    """
    found.sort()
    for _, index in found:
        if _is_clear(context, index, occlusion):
            context.notice(index)
            return index
    return -1


@register_condition(
    "IsRobotVisible",
    memory={"ticks left": 0.0, "robot": 0.0, "noticed": 0.0},
    ignored=IGNORED,
)
def is_robot_visible(
    context: TickContext,
    own: list[float],
    *,
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
    state = context.state
    found = []
    for i, robot in enumerate(context.robots):
        dx, dy = robot[X] - state[X], robot[Y] - state[Y]
        away = math.hypot(dx, dy)
        is_noticed = own[2] and i == own[1]
        if away > distance + (hysteresis if is_noticed else 0.0):
            continue
        bearing = math.atan2(dy, dx) - state[YAW]
        off = abs(math.remainder(bearing, 2 * math.pi))
        if off <= field_of_view / 2:
            found.append((away, i))
    seen = _notice_nearest(context, found, occlusion) if found else -1
    if seen >= 0:
        ticks = round(memory / context.person.time_step)
        own[:] = [float(ticks), float(seen), 1.0]
        return True
    remembered = int(own[1])
    # (The memory may be of a trial with more robots.)
    if own[0] == 0 or remembered >= len(context.robots):
        own[2] = 0.0
        return False
    context.notice(remembered)
    robot = context.robots[remembered]
    away = math.hypot(robot[X] - state[X], robot[Y] - state[Y])
    is_near = away <= distance + hysteresis and _is_clear(
        context, remembered, occlusion
    )
    if not (track and is_near):
        own[0] -= 1
    return True


@register_condition("IsRobotApproaching", ignored=IGNORED)
def is_robot_approaching(
    context: TickContext,
    *,
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
    if only_without_goal and context.goal is not None:
        return False
    state = context.state
    head_on = head_on and not (
        at_rest and math.hypot(state[VX], state[VY]) < SLOW
    )
    found = []
    for i, robot in enumerate(context.robots):
        stands = math.hypot(robot[VX], robot[VY]) < SLOW
        hx, hy = course(robot)
        rx, ry = state[X] - robot[X], state[Y] - robot[Y]
        along = rx * hx + ry * hy
        if not 0 < along <= (standing_distance if stands else distance):
            continue
        facing = hx * math.cos(state[YAW]) + hy * math.sin(state[YAW])
        is_on_course = abs(hx * ry - hy * rx) <= width
        if is_on_course and (not head_on or facing <= _OPPOSITE):
            found.append((along, i))
    return _notice_nearest(context, found, occlusion) >= 0


@register_condition("IsRobotInTheWay", ignored=IGNORED)
def is_robot_in_the_way(
    context: TickContext,
    *,
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
    if not _is_any_near(context, distance):
        return False
    clearance = between(context, clearance, gap)
    found = [
        (it.ahead, it.row)
        for it in before_goal(context, distance, clearance)
        if abs(it.beside) < clearance
    ]
    return _notice_nearest(context, found, occlusion) >= 0


def _is_any_near(context: TickContext, distance: float) -> bool:
    """Returns whether any robot's center is at most a distance away."""
    state = context.state
    x, y = state[X], state[Y]
    for robot in context.robots:
        if math.hypot(robot[X] - x, robot[Y] - y) <= distance:
            return True
    return False


def between(context: TickContext, clearance: float, gap: float) -> float:
    """Returns the distance to keep from the centers of robots, in meters.

    It is `clearance`, or what leaves a `gap` above 0 between the bodies.
    """
    if gap > 0 and context.robots:
        widest = max([robot[RADIUS] for robot in context.robots])
        return max(clearance, context.state[RADIUS] + widest + gap)
    return clearance


class OnWay(NamedTuple):
    """The position of a robot relative to a person's line to the goal.

    Attributes:
        ahead: The distance ahead of the person, in meters.
        beside: The distance to the left of the line, in meters.
        row: Its place in `TickContext.robots`.
    """

    ahead: float
    beside: float
    row: int


def before_goal(
    context: TickContext, distance: float, clearance: float, behind: float = 0.0
) -> list[OnWay]:
    """Returns the robots between the person and the goal.

    They are at most `distance` away, and at most `behind` behind the person.
    Robots nearer to the goal than `clearance` cannot be passed, and do not
    count. All are in meters.
    """
    state, goal = context.state, context.goal
    if goal is None:
        return []
    gx, gy = goal[0] - state[X], goal[1] - state[Y]
    length = math.hypot(gx, gy)
    if length == 0:
        return []
    gx, gy = gx / length, gy / length
    found = []
    for i, robot in enumerate(context.robots):
        dx, dy = robot[X] - state[X], robot[Y] - state[Y]
        ahead, beside = dx * gx + dy * gy, gx * dy - gy * dx
        if math.hypot(dx, dy) > distance or not -behind < ahead < length:
            continue
        if math.hypot(length - ahead, beside) >= clearance:
            found.append(OnWay(ahead, beside, i))
    return found


def way(context: TickContext) -> tuple[float, float]:
    """Returns the unit vector to the goal; of the heading if there is none."""
    state, goal = context.state, context.goal
    if goal is not None:
        dx, dy = goal[0] - state[X], goal[1] - state[Y]
        length = math.hypot(dx, dy)
        if length > 0:
            return dx / length, dy / length
    return math.cos(state[YAW]), math.sin(state[YAW])


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
    than 0.3 m for `seconds`. With `with_goal`, it holds only for people who
    have a goal. It holds for one tick; then the time begins anew.
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
