"""Gaps and approach speeds of a robot and people, compiled by numba."""

import math

from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import MATRIX, VECTOR, jit_as
from hunav_drake.systems.common.layout import RADIUS, VX, VY, X, Y


@jit_as(float64[:, ::1], VECTOR, MATRIX)
def closing_speeds(robot, humans):
    """Returns the approach speeds of a robot and each person.

    With n the unit vector from robot to person, these are a = v_r . n and b =
    -v_i . n, shape (2, n), in m/s. They are 0 for coincident centers and for
    missing people (a row of NaN), which have no n.
    """
    speeds = np.empty((2, len(humans)))
    for i in range(len(humans)):
        dx = humans[i, X] - robot[X]
        dy = humans[i, Y] - robot[Y]
        distance = math.hypot(dx, dy)
        if distance == 0 or math.isnan(distance):
            speeds[0, i] = speeds[1, i] = 0.0
            continue
        speeds[0, i] = (robot[VX] * dx + robot[VY] * dy) / distance
        speeds[1, i] = -(humans[i, VX] * dx + humans[i, VY] * dy) / distance
    return speeds


@jit_as(float64[::1], VECTOR, MATRIX, VECTOR)
def gaps(robot, humans, bodies):
    """Returns the gaps between the disc of a robot and bodies of people.

    Shape (n,), in meters, negative where they overlap, and infinite for missing
    people (a row of NaN).
    """
    result = np.empty(len(humans))
    for i in range(len(humans)):
        distance = math.hypot(humans[i, X] - robot[X], humans[i, Y] - robot[Y])
        gap = distance - (robot[RADIUS] + bodies[i])
        result[i] = math.inf if math.isnan(gap) else gap
    return result
