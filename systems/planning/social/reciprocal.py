"""The velocity by which a robot avoids people reciprocally, compiled by numba.

van den Berg, Guy, Lin & Manocha 2011; the rules are those of the crowd's ORCA.
"""

from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import (
    MATRIX,
    REAL,
    VECTOR,
    WALLS,
    jit_as,
)
from hunav_drake.systems.common.layout import RADIUS, VX, VY, X, Y
from hunav_drake.systems.crowd.orca.half_planes import best_velocity
from hunav_drake.systems.crowd.orca.rules import avoid_disc, avoid_walls
from hunav_drake.systems.world.walls import opened

# The places of the parameters.
(
    SPEED,
    RADIUS_TO_PEOPLE,
    RADIUS_TO_WALLS,
    NEIGHBOR_DISTANCE,
    HORIZON,
    WALL_HORIZON,
    SHARE,
    STEP,
) = range(8)


@jit_as(float64[::1], VECTOR, REAL, REAL, MATRIX, WALLS, VECTOR)
def avoiding_velocity(own, tx, ty, humans, table, p):
    """Returns the velocity in W, in m/s, that is nearest to a wanted one.

    Args:
        own: (x, y, vx, vy) of the middle of the robot's disc.
        tx: The wanted velocity, in m/s.
        ty: The same along the other axis.
        humans: Rows of `human_states`.
        table: `Obstacles.table`.
        p: The parameters.
    """
    walls = opened(table)
    rules = np.empty((len(walls.segments) + len(humans), 3))
    scratch = np.empty(rules.shape)
    sight = p[RADIUS_TO_WALLS] + p[SPEED] * p[WALL_HORIZON]
    hard = avoid_walls(
        *(rules, own[0], own[1], p[RADIUS_TO_WALLS], p[SPEED], walls),
        *(sight, p[WALL_HORIZON], p[STEP]),
    )
    count = hard
    far = p[NEIGHBOR_DISTANCE]
    for i in range(len(humans)):
        dx = humans[i, X] - own[0]
        dy = humans[i, Y] - own[1]
        if dx * dx + dy * dy > far * far:
            continue
        count += avoid_disc(
            *(rules[count], dx, dy, own[2:4]),
            *(own[2] - humans[i, VX], own[3] - humans[i, VY]),
            *(p[RADIUS_TO_PEOPLE] + humans[i, RADIUS], p[SHARE]),
            *(p[HORIZON], p[STEP]),
        )
    vx, vy = best_velocity(rules, hard, count, p[SPEED], tx, ty, scratch)
    result = np.empty(2)
    result[0] = vx
    result[1] = vy
    return result
