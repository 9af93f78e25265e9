"""Conditions and actions of walking from goal to goal: RegularNav, ...

Each tree belongs to one person and its time is simulated time, so the ports
that name a person or a time step are accepted and ignored.
"""

import math
from typing import Annotated, Literal

import numpy as np

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
from hunav_drake.systems.behavior.nodes.status import NodeStatus
from hunav_drake.systems.behavior.nodes.tick_context import (
    MAX_BEHAVIOR_STATUS,
    TickContext,
)
from hunav_drake.systems.common.layout import (
    RADIUS,
    VX,
    VY,
    Command,
    RobotRole,
    X,
    Y,
)
from hunav_drake.systems.common.schema import within

# The distance beyond its radius at which HuNavSim takes a goal for reached, in
# meters.
GOAL_MARGIN = 0.1

# People slower than the first value, in m/s, stand. They block a person with
# the same goal if no more than the second is between the bodies, and they
# extend the goal by the third, times the square root of their number, both in
# meters.
_STANDING = 0.1
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
ROLES = {
    "pedestrian": float(RobotRole.PEDESTRIAN),
    "obstacle": float(RobotRole.OBSTACLE),
    "unseen": float(RobotRole.UNSEEN),
}


@register_condition("IsGoalReached", ignored=IGNORED)
def is_goal_reached(context: TickContext, *, shared: bool = True) -> bool:
    """Holds within 0.1 m of the goal's radius; never without a goal.

    If the goal is `shared`, it also holds where people who stand nearer to it
    are in the way: at most 0.4 m times the square root of their number outside
    of the radius.
    """
    goal = context.goal
    if goal is None:
        return False
    state = context.state
    distance = math.hypot(goal[0] - state[X], goal[1] - state[Y])
    if distance <= context.person.goal_radius + GOAL_MARGIN:
        return True
    return shared and _is_taken(context, goal, distance)


def _is_taken(
    context: TickContext, goal: tuple[float, float], distance: float
) -> bool:
    """Returns whether people who stand at a goal block the person's way."""
    beyond = (distance - context.person.goal_radius) / _CROWDING
    if beyond * beyond > context.num_humans - 1:
        return False
    people = context.human_states
    state = context.state
    away = np.hypot(people[:, X] - goal[0], people[:, Y] - goal[1])
    speed = np.hypot(people[:, VX], people[:, VY])
    standing = people[(away < distance) & (speed < _STANDING)]
    if beyond * beyond > len(standing):
        return False
    gap = np.hypot(standing[:, X] - state[X], standing[:, Y] - state[Y])
    gap -= standing[:, RADIUS] + state[RADIUS]
    ahead = (standing[:, X] - state[X]) * (goal[0] - state[X])
    ahead += (standing[:, Y] - state[Y]) * (goal[1] - state[Y])
    return bool(((gap <= _IN_THE_WAY) & (ahead > 0)).any())


@register_action("UpdateGoal", ignored=IGNORED)
def update_goal(context: TickContext) -> NodeStatus:
    """Goes on to the next goal; fails if there is no current goal."""
    return (
        NodeStatus.SUCCESS if context.go_to_next_goal() else NodeStatus.FAILURE
    )


@register_action("RegularNav", ignored=IGNORED)
def regular_nav(
    context: TickContext,
    *,
    robot: Role = "pedestrian",
    ignore_robot: bool = False,
) -> None:
    """Walks to the current goal; `robot` is its role in the social forces.

    With `ignore_robot` robots are unseen, whatever `robot` is.
    """
    role = ROLES["unseen" if ignore_robot else robot]
    context.command[Command.ROBOT_ROLE] = role


@register_action("SetBehaviorStatus", ignored=IGNORED)
def set_behavior_status(
    context: TickContext, *, status: BehaviorStatus = 1
) -> None:
    """Sets the behavior status: the state of the person's reaction."""
    context.behavior_status = status


@register_condition(
    "TimeExpiredCondition", memory={"seconds": 0.0}, ignored=(*IGNORED, "ts")
)
def time_expired(
    context: TickContext,
    own: list[float],
    *,
    seconds: Annotated[float, within(0, 1e9, "s")] = 1.0,
    only_once: bool = False,
) -> bool:
    """Holds once its ticks, this one included, have lasted `seconds`.

    With `only_once` it holds for ever after; without, it counts again.

    The time steps are added up, rounding included, as HuNavSim does: 800 steps
    of 0.05 s are a little less than 40 s, and 600 of them a little more than
    30 s.
    """
    passed = own[0] + context.person.time_step
    if passed < seconds:
        own[0] = passed
        return False
    if not only_once:
        own[0] = 0.0
    return True


@register_action(
    "KeepPlace", memory={"state": 0.0, "x": 0.0, "y": 0.0}, ignored=IGNORED
)
def keep_place(
    context: TickContext, own: list[float], *, speed: PortSpeed = 0.6
) -> NodeStatus:
    """Walks back to the place where the person stood without a goal.

    The place is where a person without a goal came to rest while this was
    ticked. A person more than 0.3 m away walks back at `speed` at most, unless
    a robot or another person is on the way. The action fails if there is
    nothing to do.
    """
    state, command = context.state, context.command
    if context.goal is not None:
        own[0] = 0.0
        return NodeStatus.FAILURE
    if not own[0]:
        if speed_of(context) < STANDING:
            own[:] = [1.0, state[X], state[Y]]
        return NodeStatus.FAILURE
    x, y = own[1], own[2]
    left = math.hypot(x - state[X], y - state[Y])
    there = left <= (_BACK_AT if own[0] > 1 else _OFF)
    if there or _is_blocked(context, x, y):
        own[0] = 1.0
        return NodeStatus.FAILURE
    own[0] = 2.0
    head_for(context, x, y, _BACK_AT / 2)
    walk_at(context, min(speed, command[Command.MAX_SPEED]))
    return NodeStatus.SUCCESS


def _is_blocked(context: TickContext, x: float, y: float) -> bool:
    """Returns whether a robot or another person is on the way to a place."""
    state, index = context.state, context.person.index
    rows = context.robots + [
        it for i, it in enumerate(context.humans) if i != index
    ]
    dx, dy = x - state[X], y - state[Y]
    length = max(math.hypot(dx, dy), 1e-9)
    for it in rows:
        rx, ry = it[X] - state[X], it[Y] - state[Y]
        part = min(max((rx * dx + ry * dy) / length**2, 0.0), 1.0)
        near = math.hypot(rx - part * dx, ry - part * dy)
        if near < state[RADIUS] + it[RADIUS] + _CLEAR:
            return True
    return False
