"""The free distance straight ahead of a robot, compiled by numba."""

import math

from hunav_drake.systems.common.kernels import MATRIX, REAL, WALLS, jit_as
from hunav_drake.systems.common.layout import RADIUS, X, Y
from hunav_drake.systems.world.nearest import nearest_within
from hunav_drake.systems.world.walls import opened


@jit_as(REAL, REAL, REAL, REAL, REAL, REAL, WALLS)
def clearance_ahead(x, y, heading, radius, reach, table):
    """Returns how far a disc can move straight ahead before it touches.

    The disc has its center at (x, y) in W, in meters, and its heading in
    radians. The result is at most `reach`, in meters. `table` is
    `Obstacles.table`.

    Sphere tracing: from each point, the disc can move by its distance from the
    nearest segment.
    """
    walls = opened(table)
    cx = math.cos(heading)
    cy = math.sin(heading)
    moved = 0.0
    while moved < reach:
        # Farther walls do not matter.
        far = reach - moved + radius + 1e-3
        _, _, d2 = nearest_within(
            x + moved * cx, y + moved * cy, far * far, walls
        )
        free = math.sqrt(d2) - radius
        if free < 1e-3:
            return moved
        moved += free
    return reach


@jit_as(REAL, REAL, REAL, REAL, REAL, REAL, REAL, MATRIX)
def people_ahead(x, y, c, s, radius, margin, humans):
    """Returns the distance that a disc can move straight ahead to a person.

    The disc of a radius is at (x, y) in W and moves along (c, s), the cosine
    and sine of its heading. People, rows of `human_states`, count up to
    `margin` beside its lane. The distance is negative if the disc overlaps a
    person, and infinite if nobody is ahead. All in meters.
    """
    free = math.inf
    for i in range(len(humans)):
        dx = humans[i, X] - x
        dy = humans[i, Y] - y
        ahead = c * dx + s * dy
        reach = radius + humans[i, RADIUS]
        if ahead > 0 and abs(c * dy - s * dx) < reach + margin:
            free = min(free, ahead - reach)
    return free
