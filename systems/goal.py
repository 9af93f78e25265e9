"""What it is to be at a goal."""

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.angles import wrap_angles
from hunav_drake.systems.layout import YAW, X, Y


def is_at_goal(
    states: NDArray[np.float64],
    goal: tuple[float, float, float],
    *,
    tolerance: float,
    yaw_tolerance: float,
) -> NDArray[np.bool_]:
    """Tells where a robot is at its goal.

    Args:
        states: Rows of the robot, shape (..., 7): see `layout`.
        goal: The pose (x, y, yaw) to reach, in meters and radians.
        tolerance: It is at the goal where it is closer than this, in meters,
        yaw_tolerance: and turned from the goal's heading by this at most, in
            radians.

    Returns:
        Shape (...).
    """
    x, y, yaw = goal
    away = np.hypot(states[..., X] - x, states[..., Y] - y)
    turn = abs(wrap_angles(states[..., YAW] - yaw))
    at_goal: NDArray[np.bool_] = (away < tolerance) & (turn <= yaw_tolerance)
    return at_goal
