"""Arithmetic with angles and poses."""

import math

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask


def wrap_angle(angle: float) -> float:
    """Returns the same direction as an angle in (-pi, pi], in radians."""
    wrapped = math.remainder(angle, 2 * math.pi)
    return math.pi if wrapped == -math.pi else wrapped


def wrap_angles(angles: Array) -> Array:
    """Returns the same directions as angles in (-pi, pi], in radians."""
    turns = np.ceil((angles - np.pi) / (2 * np.pi))
    wrapped: Array = angles - 2 * np.pi * turns
    return wrapped


def turn_between[Value: (float, Array)](first: Value, second: float) -> Value:
    """Returns the least turn between two headings, in [0, pi], in radians."""
    return abs((first - second + math.pi) % (2 * math.pi) - math.pi)


def is_at_goal[Value: (float, Array)](
    pose: tuple[Value, Value, Value],
    goal: tuple[float, float, float],
    *,
    tolerance: float,
    yaw_tolerance: float,
) -> bool | Mask:
    """Returns whether, or where, a robot is at its goal.

    There, it is closer to the goal than the tolerance, in meters, and its
    heading differs by at most the yaw tolerance, in radians. The pose (x, y,
    yaw) may be of arrays of one shape.
    """
    x, y, yaw = pose
    dx, dy = x - goal[0], y - goal[1]
    # In plain arithmetic: NumPy's functions take long for single numbers.
    near = dx * dx + dy * dy < tolerance * tolerance
    return near & (turn_between(yaw, goal[2]) <= yaw_tolerance)
