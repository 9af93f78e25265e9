"""Arithmetic with angles."""

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def wrap_angle(angle: float) -> float:
    """Returns the same direction as an angle in (-pi, pi], in radians."""
    wrapped = math.remainder(angle, 2 * math.pi)
    return math.pi if wrapped == -math.pi else wrapped


def wrap_angles(angles: Array) -> Array:
    """Returns the same directions as angles in (-pi, pi], in radians."""
    turns = np.ceil((angles - np.pi) / (2 * np.pi))
    wrapped: Array = angles - 2 * np.pi * turns
    return wrapped


def turn_between[Value: (float, NDArray[np.float64])](
    first: Value, second: float
) -> Value:
    """Returns the least turn between two headings, in [0, pi], in radians."""
    return abs((first - second + math.pi) % (2 * math.pi) - math.pi)
