"""Who of a group goes through a door alone, compiled by numba.

People of a group pull each other to their center. In front of a door that is
too narrow for two, that holds both beside it; and behind a wall it pulls into
the wall. So for as long as that lasts, they go as if they were alone.
"""

import numba
import numpy as np

from hunav_drake.systems.common.kernels import MATRIX, VECTOR, WALLS, jit_as
from hunav_drake.systems.common.layout import Command, X, Y
from hunav_drake.systems.crowd.walls.beside import (
    passage_width,
    places_ahead,
    walls_beside,
    way_ahead,
)
from hunav_drake.systems.world.visibility_graph import sees
from hunav_drake.systems.world.walls import opened

# Who touches a wall is not behind it, in meters.
_TOUCH = 0.01


@jit_as(numba.boolean[::1], MATRIX, MATRIX, VECTOR, WALLS)
def parted(positions, command, radii, table):
    """Tells who (n,) is in a group that walls part.

    A wall is between them and the center of the group, or their way is, within
    the next 1.5 m, narrower than they and the widest other one abreast.

    Args:
        positions: Shape (n, 2 or more): x, y, ..., in meters.
        command: Shape (n, COMMAND_SIZE), with waypoints for goals.
        radii: Shape (n,), in meters.
        table: `Obstacles.table`.
    """
    walls = opened(table)
    n = len(positions)
    result = np.zeros(n, dtype=np.bool_)
    for i in range(n):
        group = command[i, Command.GROUP_ID]
        if group < 0:
            continue
        cx = 0.0
        cy = 0.0
        count = 0
        widest = 0.0
        for j in range(n):
            if command[j, Command.GROUP_ID] == group:
                cx += positions[j, X]
                cy += positions[j, Y]
                count += 1
                if j != i:
                    widest = max(widest, radii[j])
        if count < 2:
            continue
        x = positions[i, X]
        y = positions[i, Y]
        if not sees(x, y, cx / count, cy / count, _TOUCH, walls):
            result[i] = True
            continue
        goes, ex, ey, ahead, _ = way_ahead(x, y, command[i])
        if goes:
            px, py = places_ahead(x, y, ex, ey, ahead)
            beside = walls_beside(x, y, ex, ey, ahead, walls)
            width = passage_width(px, py, ex, ey, beside, walls)
            result[i] = width < 2 * (radii[i] + widest)
    return result
