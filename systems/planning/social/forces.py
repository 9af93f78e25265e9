"""The social force on a robot, compiled by numba."""

from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import (
    MATRIX,
    REAL,
    VECTOR,
    WALLS,
    jit_as,
)
from hunav_drake.systems.common.layout import VX, VY, X, Y
from hunav_drake.systems.crowd.social_force.compiled_forces import (
    pair_force,
    wall_force,
)
from hunav_drake.systems.people.parameters import K_GOAL, K_OBSTACLE, TAU
from hunav_drake.systems.world.walls import opened

# The distance up to which walls exert a force, in meters.
_REACH = 3.0

# The forces of all walls count: with the nearest one alone, the force would
# jump in the middle of a corridor.
_ALL = 0


@jit_as(float64[::1], VECTOR, VECTOR, MATRIX, WALLS, REAL, VECTOR)
def robot_force(robot, goal, humans, table, radius, k):
    """Returns the social force (x, y) on a robot, as on a person, in m/s^2.

    `goal` is (x, y, speed), the attracting point and the desired speed; `table`
    is `Obstacles.table`; `k` are the parameters of the forces, in the order of
    `PARAMETERS`.
    """
    force = np.zeros(2)
    dx = goal[0] - robot[X]
    dy = goal[1] - robot[Y]
    distance = max(np.sqrt(dx * dx + dy * dy), 1e-9)
    force[0] = k[K_GOAL] * (dx / distance * goal[2] - robot[VX]) / k[TAU]
    force[1] = k[K_GOAL] * (dy / distance * goal[2] - robot[VY]) / k[TAU]
    for i in range(len(humans)):
        fx, fy = pair_force(
            humans[i, X] - robot[X],
            humans[i, Y] - robot[Y],
            robot[VX] - humans[i, VX],
            robot[VY] - humans[i, VY],
            k,
        )
        force[0] += fx
        force[1] += fy
    fx, fy = wall_force(
        *(robot[X], robot[Y], radius, k[K_OBSTACLE], k),
        *(opened(table), _REACH, _ALL),
    )
    force[0] += fx
    force[1] += fy
    return force
