"""The conditions and actions of people who walk from goal to goal.

Each tree belongs to one person and its time is simulated time, so the ports
that name a person or a time step are accepted and ignored.
"""

import math
from typing import Annotated, Literal

from hunav_drake.systems.behavior.nodes.registry import (
    register_action,
    register_condition,
)
from hunav_drake.systems.behavior.nodes.status import Status
from hunav_drake.systems.behavior.tick_context import MAX_STATUS, Moment
from hunav_drake.systems.common.layout import Command, RobotRole, X, Y
from hunav_drake.systems.common.schema import within

# HuNavSim takes a goal for reached this far outside its radius, in meters.
GOAL_MARGIN = 0.1

IGNORED = ("agent_id", "time_step", "id", "dt")

Role = Literal["pedestrian", "obstacle", "unseen"]
ROLES = {
    "pedestrian": float(RobotRole.PEDESTRIAN),
    "obstacle": float(RobotRole.OBSTACLE),
    "unseen": float(RobotRole.UNSEEN),
}


@register_condition("IsGoalReached", ignored=IGNORED)
def is_goal_reached(moment: Moment) -> bool:
    """Holds within 0.1 m of the current goal's radius; never without goal."""
    goal = moment.goal
    if goal is None:
        return False
    state = moment.state
    distance = math.hypot(goal[0] - state[X], goal[1] - state[Y])
    return distance <= moment.person.goal_radius + GOAL_MARGIN


@register_action("UpdateGoal", ignored=IGNORED)
def update_goal(moment: Moment) -> Status:
    """Goes on to the next goal; fails if there is no goal to leave."""
    return Status.SUCCESS if moment.drop_goal() else Status.FAILURE


@register_action("RegularNav", ignored=IGNORED)
def regular_nav(
    moment: Moment,
    *,
    robot: Role = "pedestrian",
    ignore_robot: bool = False,
) -> None:
    """Walks to the current goal; the robot is what `robot` says.

    With `ignore_robot` it is unseen, whatever `robot` says.
    """
    role = ROLES["unseen" if ignore_robot else robot]
    moment.command[Command.ROBOT_ROLE] = role


@register_action("SetBehaviorStatus", ignored=IGNORED)
def set_behavior_status(
    moment: Moment, *, status: Annotated[int, within(0, MAX_STATUS)] = 1
) -> None:
    """Tells the world in which state of its behavior the person is."""
    moment.behavior_status = status


@register_condition(
    "TimeExpiredCondition",
    memory={"seconds": 0.0},
    ignored=(*IGNORED, "ts"),
)
def time_expired(
    moment: Moment,
    own: list[float],
    *,
    seconds: Annotated[float, within(0, 1e9, "s")] = 1.0,
    only_once: bool = False,
) -> bool:
    """Holds once its ticks, this one included, have lasted `seconds`.

    With `only_once` it holds for ever after; without, it counts anew.

    The time steps are added up, rounding included, as HuNavSim does: 800 steps
    of 0.05 s are a little less than 40 s, and 600 of them a little more than
    30 s.
    """
    passed = own[0] + moment.person.time_step
    if passed < seconds:
        own[0] = passed
        return False
    if not only_once:
        own[0] = 0.0
    return True
