"""Bearings in single precision, as HuNavSim's people have them; compiled.

In C++, the sine of a number in single precision is computed in it. That of the
C library is not always the correctly rounded one, so it is called here, too:
numba calls it for such numbers.
"""

import math

from numba import float32, float64

from hunav_drake.systems.common.kernels import jit_as


@jit_as(float32, float32, float32, float32)
def bearing(dx, dy, yaw):
    """Returns the bearing of an offset from a heading, in [-pi, pi]."""
    c = math.cos(yaw)
    s = math.sin(yaw)
    return math.atan2(-dx * s + dy * c, dx * c + dy * s)


@jit_as(float32, float32, float32, float64)
def bearing_in_view(dx, dy, yaw):
    """Returns the same from a heading in double precision."""
    c = math.cos(yaw)
    s = math.sin(yaw)
    x = float64(dx)
    y = float64(dy)
    return math.atan2(float32(-x * s + y * c), float32(x * c + y * s))


@jit_as(float32, float32)
def sine(angle):
    """Returns a sine in single precision."""
    return math.sin(angle)


@jit_as(float32, float32)
def cosine(angle):
    """Returns a cosine in single precision."""
    return math.cos(angle)
