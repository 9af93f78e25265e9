"""The test whether a robot is at its goal."""

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.angles import turn_between


def is_at_goal[Value: (float, NDArray[np.float64])](
    pose: tuple[Value, Value, Value],
    goal: tuple[float, float, float],
    *,
    tolerance: float,
    yaw_tolerance: float,
) -> bool | NDArray[np.bool_]:
    """Tells whether, or where, a robot is at its goal.

    Args:
        pose: x, y and yaw of the robot, in meters and radians: numbers, or
            arrays of one shape.
        goal: The pose to reach, likewise.
        tolerance: It is at the goal if it is closer than this, in meters,
        yaw_tolerance: and turned from the goal's heading by this at most, in
            radians.

    Returns:
        Truth, or an array of it.
    """
    x, y, yaw = pose
    dx, dy = x - goal[0], y - goal[1]
    # In plain arithmetic: NumPy's functions take long for single numbers.
    near = dx * dx + dy * dy < tolerance * tolerance
    return near & (turn_between(yaw, goal[2]) <= yaw_tolerance)
