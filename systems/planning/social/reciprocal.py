"""ORCA's velocity of a robot among people, compiled by numba.

van den Berg, Guy, Lin & Manocha 2011; the rules are those of the crowd's ORCA.
"""

from typing import NamedTuple

from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import (
    MATRIX,
    REAL,
    VECTOR,
    WALLS,
    jit_as,
    reads,
)
from hunav_drake.systems.common.layout import RADIUS, VX, VY, X, Y
from hunav_drake.systems.crowd.orca.half_planes import best_velocity
from hunav_drake.systems.crowd.orca.rules import avoid_disc, avoid_walls
from hunav_drake.systems.world.walls import opened


class Parameters(NamedTuple):
    """The parameters of the avoidance; all are floats.

    `speed` is the maximum, `horizon` is `time_horizon`, and in `step` seconds
    overlapping discs separate. The others are as in `OrcaPlanner`; in SI units.
    """

    speed: float
    radius_to_people: float
    radius_to_walls: float
    neighbor_distance: float
    horizon: float
    wall_horizon: float
    share: float
    step: float


_parameters_in = reads(Parameters)


@jit_as(float64[::1], VECTOR, REAL, REAL, MATRIX, WALLS, VECTOR)
def avoiding_velocity(own, tx, ty, humans, table, parameters):
    """Returns the safe velocity nearest to a desired one, in W, in m/s.

    `own` is (x, y, vx, vy) of the center of the robot's disc, (tx, ty) the
    desired velocity, `table` `Obstacles.table`.
    """
    p = _parameters_in(parameters)
    walls = opened(table)
    rules = np.empty((len(walls.segments) + len(humans), 3))
    scratch = np.empty(rules.shape)
    sight = p.radius_to_walls + p.speed * p.wall_horizon
    hard = avoid_walls(
        *(rules, own[0], own[1], p.radius_to_walls, p.speed, walls),
        *(sight, p.wall_horizon, p.step),
    )
    count = hard
    far = p.neighbor_distance
    for i in range(len(humans)):
        dx = humans[i, X] - own[0]
        dy = humans[i, Y] - own[1]
        if dx * dx + dy * dy > far * far:
            continue
        count += avoid_disc(
            *(rules[count], dx, dy, own[2:4]),
            *(own[2] - humans[i, VX], own[3] - humans[i, VY]),
            *(p.radius_to_people + humans[i, RADIUS], p.share),
            *(p.horizon, p.step),
        )
    vx, vy = best_velocity(rules, hard, count, p.speed, tx, ty, scratch)
    result = np.empty(2)
    result[0] = vx
    result[1] = vy
    return result
