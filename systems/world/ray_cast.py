"""The first wall on a straight line, compiled by numba."""

import math

from numba import float64

from hunav_drake.systems.common.kernels import REAL, WALLS, jit, jit_as
from hunav_drake.systems.world.walls import beyond, opened


@jit
def first_hit(px, py, qx, qy, walls):
    """Returns the result of `ray_cast`, given the parts of a table."""
    best = math.inf
    dx = qx - px
    dy = qy - py
    # The end of the remaining line.
    ex = qx
    ey = qy
    box = 0
    while box < len(walls.boxes):
        if beyond(px, py, ex, ey, 0.0, walls.boxes, box):
            box = walls.links[box, 0]
            continue
        run = walls.links[box, 1]
        box += 1
        if run < 0:
            continue
        for s in range(walls.runs[run, 0], walls.runs[run, 1]):
            ax = walls.segments[s, 0] - px
            ay = walls.segments[s, 1] - py
            bx = walls.segments[s, 2] - px
            by = walls.segments[s, 3] - py
            # The sides of the line on which the ends of the segment are.
            a = dx * ay - dy * ax
            b = dx * by - dy * bx
            if (a >= 0) == (b >= 0):
                continue
            # The point where the segment meets the line through p and q.
            part = a / (a - b)
            hx = ax + part * (bx - ax)
            hy = ay + part * (by - ay)
            along = (hx * dx + hy * dy) / (dx * dx + dy * dy)
            if 0 <= along <= 1 and along < best:
                best = along
                ex = px + best * dx
                ey = py + best * dy
    return best


@jit_as(float64, REAL, REAL, REAL, REAL, WALLS)
def ray_cast(px, py, qx, qy, table):
    """Returns the part of the line from p to q before the first wall.

    A wall that only touches the line counts or not as if the line were moved
    by a hair, so that no line slips through the joint of two segments.
    Positions (px, py) and (qx, qy) are in meters, `table` is
    `Obstacles.table`.

    Returns:
        The fraction of the line, in [0, 1]; infinity if no wall is on it.
    """
    return first_hit(px, py, qx, qy, opened(table))
