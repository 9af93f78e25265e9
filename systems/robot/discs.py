"""Gaps, approach speeds and contacts of discs, compiled by numba."""

import math

from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import MATRIX, REAL, VECTOR, jit_as
from hunav_drake.systems.common.layout import RADIUS, VX, VY, X, Y
from hunav_drake.systems.robot.contact_rows import (
    PERSON_SPEED,
    ROBOT_SPEED,
    count_contacts,
)


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


@jit_as(float64[:, ::1], VECTOR, MATRIX, VECTOR, MATRIX, MATRIX, REAL)
def touch_discs(robot, humans, bodies, touches, memory, duration):
    """Returns the memory of contacts after a step: see `count_contacts`.

    `touches` has a row of port ``robot_touches`` of a `HumanCrowd` per person,
    or none: people who would otherwise overlap with the robot touch it, too.
    """
    gap = gaps(robot, humans, bodies)
    closing = closing_speeds(robot, humans)
    touching = gap < 0
    met = closing.copy()
    for i in range(len(touches)):
        touching[i] = touching[i] or touches[i, 0] > 0
        # (In the step itself: people change their velocities instantly.)
        met[1, i] = touches[i, 1]
    nothing = np.empty((0, 2))
    after = count_contacts(memory, touching, nothing, gap, met, duration)
    for i in range(len(after)):
        after[i, ROBOT_SPEED] = closing[0, i]
        after[i, PERSON_SPEED] = closing[1, i]
    return after
