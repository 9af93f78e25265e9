"""Where walls are around a robot, as points in all directions."""

import math

import numba
import numpy as np

from hunav_drake.systems.common.kernels import INTEGER, REAL, WALLS, jit_as
from hunav_drake.systems.world.ray_cast import first_hit
from hunav_drake.systems.world.walls import opened


@jit_as(numba.float64[:, ::1], REAL, REAL, REAL, INTEGER, WALLS)
def wall_points(x, y, reach, rays, table):
    """Returns where rays from a point meet walls first, shape (m, 2).

    There are `rays` of them, evenly in all directions, `reach` long, in meters;
    those that meet nothing have no point. `table` is `Obstacles.table`.
    """
    walls = opened(table)
    points = np.empty((rays, 2))
    count = 0
    for i in range(rays):
        angle = 2 * math.pi * i / rays
        dx = reach * math.cos(angle)
        dy = reach * math.sin(angle)
        part = first_hit(x, y, x + dx, y + dy, walls)
        if part < math.inf:
            points[count, 0] = x + part * dx
            points[count, 1] = y + part * dy
            count += 1
    return points[:count].copy()
