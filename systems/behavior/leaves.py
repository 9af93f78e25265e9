"""The conditions and actions of HuNavSim's trees.

Each tree belongs to one person and its time is simulated time, so the ports
that name a person or a time step are accepted and ignored.
"""

import math
from typing import Annotated, Literal

from hunav_drake.systems.angles import wrap_angle
from hunav_drake.systems.behavior.decorators import steps_reach
from hunav_drake.systems.behavior.person import Moment
from hunav_drake.systems.behavior.registry import (
    register_action,
    register_condition,
)
from hunav_drake.systems.behavior.status import Status
from hunav_drake.systems.layout import YAW, Command, RobotRole, X, Y
from hunav_drake.systems.schema import within

# HuNavSim takes a goal for reached this far outside its radius, in meters.
GOAL_MARGIN = 0.1

# People see a little more than what lies before them, in radians.
FIELD_OF_VIEW = 2 * (math.pi / 2 + 0.17)

IGNORED = ("agent_id", "time_step", "id", "dt")

_ROLES = {
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
    robot: Literal["pedestrian", "obstacle", "unseen"] = "pedestrian",
) -> None:
    """Walks to the current goal; the robot is what `robot` says."""
    moment.command[Command.ROBOT_ROLE] = _ROLES[robot]


@register_condition("IsRobotVisible", ignored=IGNORED)
def is_robot_visible(
    moment: Moment,
    *,
    distance: Annotated[float, within(0, 1e5, "m")],
    field_of_view: Annotated[
        float, within(0, 2 * math.pi, "rad")
    ] = FIELD_OF_VIEW,
) -> bool:
    """Holds if a robot's center is near enough and in the field of view."""
    state = moment.state
    for robot in moment.robots:
        dx, dy = robot[X] - state[X], robot[Y] - state[Y]
        if math.hypot(dx, dy) > distance:
            continue
        bearing = wrap_angle(math.atan2(dy, dx) - state[YAW])
        if abs(bearing) <= field_of_view / 2:
            return True
    return False


@register_condition(
    "TimeExpiredCondition",
    memory={"ticks": 0.0},
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
    """
    if not steps_reach(own[0] + 1, moment.person.time_step, seconds):
        own[0] += 1
        return False
    if not only_once:
        own[0] = 0.0
    return True
