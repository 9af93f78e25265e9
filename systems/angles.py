"""Arithmetic with angles."""

import math


def wrap_angle(angle: float) -> float:
    """Returns the same direction as an angle in (-pi, pi], in radians."""
    wrapped = math.remainder(angle, 2 * math.pi)
    return math.pi if wrapped == -math.pi else wrapped
