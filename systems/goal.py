"""What it is to be at a goal."""

import math
from typing import Any


def is_at_goal(
    pose: tuple[Any, Any, Any],
    goal: tuple[float, float, float],
    *,
    tolerance: float,
    yaw_tolerance: float,
) -> Any:
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
    dx = pose[0] - goal[0]
    dy = pose[1] - goal[1]
    turn = abs((pose[2] - goal[2] + math.pi) % (2 * math.pi) - math.pi)
    # Without NumPy, which takes long for single numbers.
    return (dx * dx + dy * dy < tolerance * tolerance) & (turn <= yaw_tolerance)
