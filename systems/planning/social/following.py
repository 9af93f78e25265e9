"""Functions of planners that follow a point ahead on the plan."""

import math

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import YAW, X, Y
from hunav_drake.systems.common.poses import wrap_angle
from hunav_drake.systems.planning.costmap.footprint import footprint_cost
from hunav_drake.systems.planning.navigation.memory import Control, LocalPlan
from hunav_drake.systems.planning.planner import PlanningTask, View
from hunav_drake.systems.world.maps.costs import LETHAL, Costmap

# The fraction of the tolerance within which it stops, to be off its edge.
INSIDE = 0.8

# The maximum rate of the turn in place, in rad/s, and its gain, in 1/s.
_TURN = 1.0
_GAIN = 2.0

# The horizon of the collision check, in seconds, and its number of steps.
_AHEAD = 0.6
_STEPS = 3


def carrot_at(
    view: View, local: LocalPlan, distance: float
) -> tuple[float, float]:
    """Returns the point (x, y) on the plan at a distance ahead.

    It is the first point beyond the distance after the last point within it, or
    the end of the plan.
    """
    x, y = view.robot[:2].tolist()
    away = np.hypot(local.poses[:, 0] - x, local.poses[:, 1] - y)
    last = len(away) - 1
    # (argmax gives 0 if none is within.)
    first = last - int((away[::-1] <= distance).argmax())
    if away[first] > distance:
        first = int(away.argmin())
    place = first + int((away[first:] > distance).argmax())
    if away[place] <= distance:
        place = last
    x, y = local.poses[place, :2].tolist()
    return x, y


def at_end(
    task: PlanningTask, view: View, local: LocalPlan, reaction: float
) -> Control | None:
    """Returns the turn to the heading of the goal, once at the goal.

    `reaction` is the time until another command takes effect, in seconds.
    """
    x, y, yaw = view.robot[: YAW + 1].tolist()
    left = math.hypot(local.goal[X] - x, local.goal[Y] - y)
    if left > INSIDE * task.goal_tolerance:
        return None
    error = wrap_angle(local.goal[YAW] - yaw)
    if abs(error) < 0.5 * task.goal_yaw_tolerance:
        return Control(0.0, 0.0)
    omega = min(_GAIN, 1 / reaction) * error
    return Control(0.0, min(max(omega, -_TURN), _TURN))


def is_free(
    footprint: Array, costmap: Costmap, view: View, v: float, omega: float
) -> bool:
    """Returns whether a velocity is free of collisions in the near future.

    `footprint` has shape (k, 2); v is in m/s, omega in rad/s.
    """
    x, y, yaw = view.robot[: YAW + 1].tolist()
    if v <= 0:
        return True
    dt = _AHEAD / _STEPS
    for _ in range(_STEPS):
        x += v * math.cos(yaw) * dt
        y += v * math.sin(yaw) * dt
        yaw += omega * dt
        cost = footprint_cost(
            *(costmap.costs, *costmap.origin, costmap.resolution),
            *(x, y, yaw, footprint),
        )
        if cost < 0 or cost >= LETHAL:
            return False
    return True
