"""The legs of walking figures: their sections, and where they meet a plane.

A lidar that scans at the height of legs sees what is drawn: both have their
sections and their gait from here and from `gait`.
"""

import math

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.layout import RADIUS, STATE_SIZE
from hunav_drake.systems.scene.gait import (
    BASE_X,
    BASE_Y,
    BASE_YAW,
    GAIT_SIZE,
    HIP_HEIGHT,
    LEFT_HIP,
    LEFT_KNEE,
    RIGHT_HIP,
    RIGHT_KNEE,
    SHIN,
    THIGH,
    pose_figures,
)

# The radius of the disc, in meters, at which a figure has the width of an
# adult; other radii make it wider or slimmer, within reason.
NOMINAL_RADIUS = 0.35
WIDTH_LIMITS = (0.6, 1.6)

# Half the distance between the hips, in meters.
HIP_Y = 0.09

# Horizontal sections of a leg that hangs straight down: the middle (x, y, z)
# below the joint that it hangs from, and the half widths along x and y, all in
# meters. The lowest of the shoe reaches from HEEL to TOE, which the gait puts
# on the floor.
THIGH_SECTIONS: Array = np.array(
    [
        [0.000, 0, -0.455, 0.040, 0.040],
        [0.000, 0, -0.420, 0.063, 0.061],
        [0.004, 0, -0.300, 0.071, 0.068],
        [0.000, 0, -0.120, 0.086, 0.082],
        [0.000, 0, 0.000, 0.086, 0.080],
        [0.000, 0, 0.050, 0.060, 0.060],
    ]
)
SHIN_SECTIONS: Array = np.array(
    [
        [0.000, 0, -0.400, 0.058, 0.053],
        [-0.004, 0, -0.260, 0.059, 0.055],
        [-0.006, 0, -0.120, 0.065, 0.060],
        [0.000, 0, 0.000, 0.064, 0.061],
        [0.000, 0, 0.040, 0.046, 0.046],
    ]
)
SHOE_SECTIONS: Array = np.array(
    [
        [0.045, 0, -SHIN, 0.105, 0.040],
        [0.048, 0, -0.445, 0.125, 0.046],
        [0.044, 0, -0.425, 0.120, 0.045],
        [0.020, 0, -0.400, 0.080, 0.044],
        [0.000, 0, -0.370, 0.050, 0.042],
    ]
)
for _sections in (THIGH_SECTIONS, SHIN_SECTIONS, SHOE_SECTIONS):
    _sections.setflags(write=False)

# The shin is seen down to here, below the knee; from there on, the shoe.
_ANKLE = -0.4

# A row of `legs_at`: the middle of an ellipse, the direction of its first half
# axis, in W, and both half axes; in meters and radians.
ELLIPSE_SIZE = 5


@jit
def figure_width(radius: float) -> float:
    """Returns how wide a figure is, in widths of an adult, by its disc."""
    return min(max(radius / NOMINAL_RADIUS, WIDTH_LIMITS[0]), WIDTH_LIMITS[1])


@jit
def legs_at(gait: Array, human_states: Array, height: float) -> Array:
    """Returns what a horizontal plane cuts out of the legs of people.

    Legs are taken for ellipses. One that does not reach the plane, as a foot
    in the air above it, has half axes of 0.

    Args:
        gait: Phases and paces, shape (2n,): see `gait`.
        human_states: The rows of the people, shape (7n,).
        height: That of the plane above the floor, in meters.

    Returns:
        Shape (2n, 5), the left leg of each person before the right one: rows
        (x, y, yaw, a, b) in W, in meters and radians.
    """
    figures = pose_figures(gait, human_states)
    n = gait.size // GAIT_SIZE
    result = np.zeros((2 * n, ELLIPSE_SIZE))
    for i in range(n):
        q = figures[i]
        width = figure_width(human_states[i * STATE_SIZE + RADIUS])
        yaw = q[BASE_YAW]
        c, s = math.cos(yaw), math.sin(yaw)
        for side in range(2):
            hip = q[LEFT_HIP] if side == 0 else q[RIGHT_HIP]
            knee = q[LEFT_KNEE] if side == 0 else q[RIGHT_KNEE]
            x, a, b = _leg_at(hip, knee, q[HIP_HEIGHT] - height, width)
            y = width * (HIP_Y if side == 0 else -HIP_Y)
            row = result[2 * i + side]
            row[0] = q[BASE_X] + c * x - s * y
            row[1] = q[BASE_Y] + s * x + c * y
            row[2] = yaw
            row[3] = a
            row[4] = b
    return result


@jit
def _leg_at(
    hip: float, knee: float, below: float, width: float
) -> tuple[float, float, float]:
    """Returns x of a leg's middle, and its half axes, so far below the hip."""
    knee_below = THIGH * math.cos(hip)
    if below <= knee_below:
        return _cut(hip, below, THIGH_SECTIONS, width)
    below -= knee_below
    angle = hip - knee
    x, a, b = _cut(angle, below, SHIN_SECTIONS, width)
    if below > -_ANKLE * math.cos(angle):
        x, a, b = _cut(angle, below, SHOE_SECTIONS, width)
    return THIGH * math.sin(hip) + x, a, b


@jit
def _cut(
    angle: float, below: float, sections: Array, width: float
) -> tuple[float, float, float]:
    """Returns the same for a part that hangs at an angle, from its joint.

    A plane that is level cuts a part that leans in a longer ellipse.
    """
    c, s = math.cos(angle), math.sin(angle)
    z = -below / c
    x = a = b = 0.0
    # The middle is off the line from joint to joint; twice is near enough.
    for _ in range(2):
        k = 1
        while k < len(sections) - 1 and sections[k, 2] < z:
            k += 1
        low, high = sections[k - 1], sections[k]
        part = (z - low[2]) / (high[2] - low[2])
        if part < 0.0 or part > 1.0:
            return 0.0, 0.0, 0.0
        x = width * (low[0] + part * (high[0] - low[0]))
        a = width * (low[3] + part * (high[3] - low[3]))
        b = width * (low[4] + part * (high[4] - low[4]))
        z = (-below - x * s) / c
    return x * c - z * s, a / c, b
