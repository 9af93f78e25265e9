"""The legs of walking figures: their sections, and their cuts with a plane.

A lidar that scans at the height of legs sees the drawn legs: both take their
sections and their gait from here and from `gait` and `manners`.
"""

import math

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.layout import RADIUS, STATE_SIZE
from hunav_drake.systems.people.figure_config import (
    HEAD_POWER,
    TALL,
    WHEELED,
    WIDE,
    WIDTH_POWER,
)
from hunav_drake.systems.people.gait import (
    BASE_X,
    BASE_Y,
    BASE_YAW,
    HIP_HEIGHT,
    LEFT_HIP,
    LEFT_KNEE,
    RIGHT_HIP,
    RIGHT_KNEE,
    SHIN,
    THIGH,
)
from hunav_drake.systems.people.manners import LEAN

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

# The half axes of the trunk along x and y, and its height, in meters.
TRUNK_X, TRUNK_Y, TRUNK_Z = 0.105, 0.165, 0.6

# The radius of the neck and the half axes of the head, along x, y and z; the
# heights of the top of the neck and the middle of the head above the trunk.
_NECK, _HEAD_X, _HEAD_Y, _HEAD_Z = 0.048, 0.088, 0.073, 0.108
_NECK_TOP, _HEAD_MIDDLE = 0.06, 0.112

# A wheelchair: where the hips are in it, ahead of its person's middle; the
# radius of its large wheels, the half distance between them, and half their
# width, in meters.
WHEELCHAIR_X = -0.15
WHEEL, WHEEL_Y, RIM = 0.3, 0.29, 0.018

# A row of `legs_at`: the middle of an ellipse, the direction of its first half
# axis, in W, and both half axes; in meters and radians.
ELLIPSE_SIZE = 5


@jit
def figure_width(radius: float) -> float:
    """Returns the width of a figure, in widths of an adult, from its disc."""
    return min(max(radius / NOMINAL_RADIUS, WIDTH_LIMITS[0]), WIDTH_LIMITS[1])


@jit
def legs_at(
    figures: Array, human_states: Array, bodies: Array, height: float
) -> Array:
    """Returns the cuts of a plane at a height, in meters, with legs of people.

    They are approximated by ellipses. That of a leg which does not reach the
    plane, as a foot in the air above it, has half axes of 0. Where the plane is
    above the hips, as of children and of people who sit, it meets the trunk, or
    the neck or the head of the smallest, in place of the left leg, and what is
    left of both thighs, in place of the right one. The wheels of wheelchairs
    follow.

    Args:
        figures: From `pose_figures` or `hold_figures`.
        human_states: Shape (7n,): see `common.layout`.
        bodies: See `figure_rows`.
        height: Of the plane.

    Returns:
        Shape (2 (n + k), 5) with k wheelchairs, the left leg of each person,
        then the left wheel of each wheelchair before the right one: rows (x, y,
        yaw, a, b) in W, in meters and radians.
    """
    n = len(figures)
    wheeled = 0
    for i in range(n):
        wheeled += bodies[i, WHEELED] > 0.0
    result = np.zeros((2 * (n + wheeled), ELLIPSE_SIZE))
    next_wheel = 2 * n
    for i in range(n):
        q = figures[i]
        tall = bodies[i, TALL]
        width = figure_width(human_states[i * STATE_SIZE + RADIUS])
        width *= bodies[i, WIDE]
        # Legs hang from the trunk, which may lean.
        lean = q[LEAN] if q.size > LEAN else 0.0
        off = WHEELCHAIR_X if bodies[i, WHEELED] > 0.0 else 0.0
        for side in range(2):
            hip = q[LEFT_HIP] if side == 0 else q[RIGHT_HIP]
            knee = q[LEFT_KNEE] if side == 0 else q[RIGHT_KNEE]
            below = q[HIP_HEIGHT] - height
            x, a, b = _leg_at(hip - lean, knee, below, width, tall)
            y = width * (HIP_Y if side == 0 else -HIP_Y)
            _put(result[2 * i + side], q, x + off, y, a, b)
        above = height - q[HIP_HEIGHT]
        # Along the trunk, whose middle is at x.
        along = above / math.cos(lean)
        a, b = _upper_at(along, width, tall)
        if above >= 0.0 and a > 0.0 and abs(lean) < 1.0:
            # Thighs that still reach the plane count as one.
            if result[2 * i + 1, 3] > 0.0:
                x, long, half = _leg_at(
                    q[RIGHT_HIP] - lean, q[RIGHT_KNEE], -above, width, tall
                )
                half += width * HIP_Y
                _put(result[2 * i + 1], q, x + off, 0.0, long, half)
            x = off + along * math.sin(lean)
            _put(result[2 * i], q, x, 0.0, a / math.cos(lean), b)
        if bodies[i, WHEELED] > 0.0 and height < 2 * WHEEL:
            a = math.sqrt(WHEEL**2 - (height - WHEEL) ** 2)
            for y in (WHEEL_Y, -WHEEL_Y):
                _put(result[next_wheel], q, off, y, a, RIM)
                next_wheel += 1
    return result


@jit
def _upper_at(along: float, width: float, tall: float) -> tuple[float, float]:
    """Returns the half axes of trunk, neck or head, along the trunk."""
    above = along - TRUNK_Z * tall
    if above <= 0.0:
        return width * TRUNK_X, width * TRUNK_Y
    # (Children have large heads.)
    large = tall**HEAD_POWER
    wide = width * min(tall, 1.0) ** (HEAD_POWER - WIDTH_POWER)
    z = above / large
    part = max(1.0 - ((z - _HEAD_MIDDLE) / _HEAD_Z) ** 2, 0.0) ** 0.5
    neck = _NECK if z <= _NECK_TOP else 0.0
    return wide * max(neck, _HEAD_X * part), wide * max(neck, _HEAD_Y * part)


@jit
def _put(row: Array, q: Array, x: float, y: float, a: float, b: float) -> None:
    """Writes an ellipse at (x, y) from the base of a figure."""
    yaw = q[BASE_YAW]
    c, s = math.cos(yaw), math.sin(yaw)
    row[0] = q[BASE_X] + c * x - s * y
    row[1] = q[BASE_Y] + s * x + c * y
    row[2] = yaw
    row[3] = a
    row[4] = b


@jit
def _leg_at(
    hip: float, knee: float, below: float, width: float, tall: float
) -> tuple[float, float, float]:
    """Returns x of a leg's middle and its half axes, at a depth below hip."""
    shin = hip - knee
    knee_x = tall * THIGH * math.sin(hip)
    knee_below = tall * THIGH * math.cos(hip)
    low, high, b = _cut(hip, below, THIGH_SECTIONS, width, tall)
    for k in range(2):
        part = SHIN_SECTIONS if k == 0 else SHOE_SECTIONS
        rear, front, half = _cut(shin, below - knee_below, part, width, tall)
        low, high = min(low, knee_x + rear), max(high, knee_x + front)
        b = max(b, half)
    if low > high:
        return 0.0, 0.0, 0.0
    return 0.5 * (low + high), 0.5 * (high - low), b


@jit
def _cut(
    angle: float, below: float, sections: Array, width: float, tall: float
) -> tuple[float, float, float]:
    """Returns the cut of a plane below a joint with a part that hangs from it.

    Seen from the side, the part is a polygon between the ends of its sections.
    Returns the begin and the end of the cut, relative to the joint, and its
    half width, in meters; (infinity, -infinity, 0) for no cut.
    """
    c, s = math.cos(angle), math.sin(angle)
    low, high = math.inf, -math.inf
    count = len(sections)
    for k in range(2 * count):
        # Up along the rear ends, then down along the front ones.
        x, z = _corner(sections, k, width, tall)
        x_next, z_next = _corner(sections, (k + 1) % (2 * count), width, tall)
        above = x * s + z * c + below
        above_next = x_next * s + z_next * c + below
        if (above >= 0) == (above_next >= 0):
            continue
        part = above / (above - above_next)
        x += part * (x_next - x)
        z += part * (z_next - z)
        low = min(low, x * c - z * s)
        high = max(high, x * c - z * s)
    if low > high:
        return low, high, 0.0
    # The width of the section in the middle.
    z = (-0.5 * (low + high) * s - below * c) / tall
    heights = sections[:, 2]
    k = 1
    while k < count - 1 and heights[k] < z:
        k += 1
    part = (z - heights[k - 1]) / (heights[k] - heights[k - 1])
    part = min(max(part, 0.0), 1.0)
    half = sections[k - 1, 4] + part * (sections[k, 4] - sections[k - 1, 4])
    return low, high, width * half


@jit
def _corner(
    sections: Array, k: int, width: float, tall: float
) -> tuple[float, float]:
    """Returns (x, z) of a corner of a part, as seen from its side."""
    count = len(sections)
    if k < count:
        x, half, z = sections[k, 0], -sections[k, 3], sections[k, 2]
    else:
        k = 2 * count - 1 - k
        x, half, z = sections[k, 0], sections[k, 3], sections[k, 2]
    return width * (x + half), tall * z
