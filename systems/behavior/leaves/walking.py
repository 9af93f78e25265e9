"""Conditions and actions of walking from goal to goal: RegularNav, ...

Each tree belongs to one person and its time is simulated time, so the ports
that name a person or a time step are accepted and ignored.
"""

import math
from typing import Annotated, Literal

from hunav_drake.systems.behavior.leaves.invitations import host_of, obey
from hunav_drake.systems.behavior.leaves.pacing import (
    STANDING,
    PortSpeed,
    head_for,
    speed_of,
    walk_at,
)
from hunav_drake.systems.behavior.nodes.registry import (
    register_action,
    register_condition,
)
from hunav_drake.systems.behavior.nodes.status import (
    FAILURE,
    SUCCESS,
    NodeStatus,
)
from hunav_drake.systems.behavior.nodes.tick import (
    Tick,
    goal_of,
    has_goal,
    human_at,
    next_goal,
    robot_at,
    standing_of,
)
from hunav_drake.systems.behavior.nodes.tick_context import MAX_BEHAVIOR_STATUS
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit, jit_part
from hunav_drake.systems.common.layout import RobotRole
from hunav_drake.systems.common.schema import within
from hunav_drake.systems.people.standing import bar_the_way

# The distance beyond its radius at which HuNavSim takes a goal for reached, in
# meters.
GOAL_MARGIN = 0.1

# People who stand block a person with the same goal if no more than the first
# value is between the bodies, and they extend the goal by the second, times the
# square root of their number, both in meters.
_IN_THE_WAY = 0.3
_CROWDING = 0.4

# A person this far from its place goes back until this near to it, unless a
# robot or person is this near to the way, disc to disc; in meters.
_OFF = 0.3
_BACK_AT = 0.1
_CLEAR = 0.3

IGNORED = ("agent_id", "time_step", "id", "dt")

BehaviorStatus = Annotated[int, within(0, MAX_BEHAVIOR_STATUS)]

Role = Literal["pedestrian", "obstacle", "unseen"]
# The RobotRole of each of them, in this order.
ROLES = (
    float(RobotRole.PEDESTRIAN),
    float(RobotRole.OBSTACLE),
    float(RobotRole.UNSEEN),
)
UNSEEN = float(RobotRole.UNSEEN)


@jit_part
def act(tick, robot):
    """Shows that the person does something, with a role of the robots."""
    tick.behavior_status = 1
    tick.robot_role = ROLES[int(robot)]


@register_condition("IsGoalReached", ignored=IGNORED)
@jit
def is_goal_reached(tick: Tick, shared: bool = True) -> bool:
    """Holds within 0.1 m of the goal's radius; never without a goal.

    It never holds while others have invited the person.

    If the goal is `shared`, it also holds where people who stand nearer to it
    are in the way: at most 0.4 m times the square root of their number outside
    of the radius.
    """
    if not has_goal(tick) or host_of(tick) >= 0:
        return False
    x, y = goal_of(tick)
    distance = math.hypot(x - tick.x, y - tick.y)
    if distance <= tick.reach + GOAL_MARGIN:
        return True
    return bool(shared) and _is_taken(tick, x, y, distance)


@jit_part
def _is_taken(tick, x, y, distance):
    """Returns whether people who stand at a goal block the person's way."""
    beyond = (distance - tick.reach) / _CROWDING
    if beyond * beyond > tick.num_humans - 1:
        return False
    return bar_the_way(
        *(standing_of(tick), tick.x, tick.y, tick.radius),
        *(x, y, distance, _IN_THE_WAY, beyond * beyond),
    )


@register_action("UpdateGoal", ignored=IGNORED)
@jit
def update_goal(tick: Tick) -> NodeStatus:
    """Goes on to the next goal; fails without a goal, and while invited."""
    is_bound = host_of(tick) >= 0
    return SUCCESS if not is_bound and next_goal(tick) else FAILURE


@register_action("RegularNav", ignored=IGNORED)
@jit
def regular_nav(
    tick: Tick, robot: Role = "pedestrian", ignore_robot: bool = False
) -> NodeStatus:
    """Walks to the current goal; `robot` is its role in the social forces.

    With `ignore_robot` robots are unseen, whatever `robot` is. People who are
    invited to a circle or a walk go there instead.
    """
    tick.robot_role = UNSEEN if ignore_robot else ROLES[int(robot)]
    host = host_of(tick)
    if host >= 0:
        obey(tick, host)
    return SUCCESS


@register_action("SetBehaviorStatus", ignored=IGNORED)
@jit
def set_behavior_status(tick: Tick, status: BehaviorStatus = 1) -> NodeStatus:
    """Sets the behavior status: the state of the person's reaction."""
    tick.behavior_status = status
    return SUCCESS


@register_condition(
    "TimeExpiredCondition", memory={"seconds": 0.0}, ignored=(*IGNORED, "ts")
)
@jit
def time_expired(
    tick: Tick,
    own: Array,
    seconds: Annotated[float, within(0, 1e9, "s")] = 1.0,
    only_once: bool = False,
) -> bool:
    """Holds once its ticks, this one included, have lasted `seconds`.

    With `only_once` it holds for ever after; without, it counts again.

    The time steps are added up, rounding included, as HuNavSim does: 800 steps
    of 0.05 s are a little less than 40 s, and 600 of them a little more than
    30 s.
    """
    passed = own[0] + tick.time_step
    if passed < seconds:
        own[0] = passed
        return False
    if not only_once:
        own[0] = 0.0
    return True


@register_action(
    "KeepPlace", memory={"state": 0.0, "x": 0.0, "y": 0.0}, ignored=IGNORED
)
@jit
def keep_place(tick: Tick, own: Array, speed: PortSpeed = 0.6) -> NodeStatus:
    """Walks back to the place where the person stood without a goal.

    The place is where a person without a goal came to rest while this was
    ticked. A person more than 0.3 m away walks back at `speed` at most, unless
    a robot or another person is on the way. The action fails if there is
    nothing to do.
    """
    if has_goal(tick) or host_of(tick) >= 0:
        own[0] = 0.0
        return FAILURE
    if own[0] == 0:
        if speed_of(tick) < STANDING:
            own[0] = 1.0
            own[1] = tick.x
            own[2] = tick.y
        return FAILURE
    x, y = own[1], own[2]
    left = math.hypot(x - tick.x, y - tick.y)
    there = left <= (_BACK_AT if own[0] > 1 else _OFF)
    if there or _is_blocked(tick, x, y):
        own[0] = 1.0
        return FAILURE
    own[0] = 2.0
    head_for(tick, x, y, _BACK_AT / 2)
    walk_at(tick, min(speed, tick.max_speed), 0.0)
    return SUCCESS


@jit_part
def _is_blocked(tick, x, y):
    """Returns whether a robot or another person is on the way to a place."""
    for i in range(tick.num_robots):
        if _is_on_way(tick, x, y, robot_at(tick, i)):
            return True
    for i in range(tick.num_humans):
        if i != tick.index and _is_on_way(tick, x, y, human_at(tick, i)):
            return True
    return False


@jit_part
def _is_on_way(tick, x, y, it):
    """Returns whether a body is on the straight way to a place."""
    dx, dy = x - tick.x, y - tick.y
    length = max(math.hypot(dx, dy), 1e-9)
    rx, ry = it.x - tick.x, it.y - tick.y
    part = min(max((rx * dx + ry * dy) / length**2, 0.0), 1.0)
    near = math.hypot(rx - part * dx, ry - part * dy)
    return near < tick.radius + it.radius + _CLEAR
