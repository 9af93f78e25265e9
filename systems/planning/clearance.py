"""The free distance straight ahead of a robot, compiled by numba."""

import math

from hunav_drake.systems.common.kernels import MATRIX, REAL, jit_as
from hunav_drake.systems.world.nearest import nearest_on_segments


@jit_as(REAL, REAL, REAL, REAL, REAL, REAL, MATRIX)
def clearance_ahead(x, y, heading, radius, reach, segments):
    """Returns how far a disc can move straight ahead before it touches.

    Sphere tracing: at every point the disc may move on by its distance to the
    nearest segment.

    Args:
        x: Where the center is, in meters.
        y: Its y coordinate.
        heading: The direction of motion, in radians.
        radius: The radius of the disc, in meters.
        reach: The result is never more than this, in meters.
        segments: Shape (s, 4): see Obstacles.
    """
    cx = math.cos(heading)
    cy = math.sin(heading)
    moved = 0.0
    while moved < reach:
        _, _, d2 = nearest_on_segments(
            x + moved * cx, y + moved * cy, segments, 0, len(segments)
        )
        free = math.sqrt(d2) - radius
        if free < 1e-3:
            return moved
        moved += free
    return reach
