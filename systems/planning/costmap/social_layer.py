"""The social layer: cells near people and ahead of them cost more.

Each person has Gaussian costs in the frame of the walking direction: wider in
front than behind, longer with speed, and another one to the right. A person
slower than 0.1 m/s has a round one. Values below the cutoff give no cost;
others are rounded down. (nav2_social_costmap_plugin, `SocialLayer`.)
"""

import math
from typing import NamedTuple

import numba
import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import (
    MATRIX,
    REAL,
    VECTOR,
    jit,
    jit_as,
    reads,
)
from hunav_drake.systems.common.layout import VX, VY, X, Y
from hunav_drake.systems.planning.costmap.costmap_config import SocialLayer
from hunav_drake.systems.planning.costmap.raster import CELLS
from hunav_drake.systems.world.maps.costs import Costs, Region

# The original's angle to a person's right, in radians.
_RIGHT = 1.57

STANDING_SPEED = 0.1


class Parameters(NamedTuple):
    """The parameters of the costs around a person; covariances in m^2.

    All are floats, from `SocialLayer`; `speed_factor` and `use_right` are 0
    where they are not used.
    """

    amplitude: float
    cutoff: float
    still: float
    front: float
    side: float
    rear: float
    rear_side: float
    right: float
    right_side: float
    speed_factor: float
    use_right: float


_parameters_in = reads(Parameters)


@jit
def _reach(x, p):
    """Returns where a Gaussian of variance x falls to the cutoff."""
    return math.sqrt(2 * x * math.log(p.amplitude / p.cutoff))


@jit_as(numba.void, CELLS, REAL, REAL, REAL, MATRIX, VECTOR)
def add_people(costs, ox, oy, resolution, people, parameters):
    """Writes the costs of people where they exceed those of the map.

    Unknown cells stay unknown. `people` has shape (n, 4), rows (x, y, vx, vy).
    """
    p = _parameters_in(parameters)
    if p.cutoff >= p.amplitude:
        return
    rows, columns = costs.shape
    most = math.log(p.amplitude / p.cutoff) * (1 + 1e-9)
    for i in range(len(people)):
        x, y, vx, vy = people[i]
        speed = math.hypot(vx, vy)
        still = speed < STANDING_SPEED
        front = p.front * (1 + speed * p.speed_factor)
        c = 1.0
        s = 0.0
        cr = 0.0
        sr = -1.0
        # The extent of the costs along x and y, on either side.
        if still:
            reach = _reach(p.still, p)
            x0 = y0 = -reach
            x1 = y1 = reach
        else:
            c = vx / speed
            s = vy / speed
            turn = math.atan2(vy, vx) - _RIGHT
            cr = math.cos(turn)
            sr = math.sin(turn)
            wide = max(p.rear, p.rear_side)
            if p.use_right != 0:
                wide = max(wide, p.right, p.right_side)
            reach = _reach(wide, p)
            # Half an ellipse in front, and a disc.
            far = _reach(front, p)
            side = _reach(p.side, p)
            ex = math.hypot(far * c, side * s)
            ey = math.hypot(far * s, side * c)
            x0 = -max(reach, ex if c < 0 else side * abs(s))
            x1 = max(reach, ex if c > 0 else side * abs(s))
            y0 = -max(reach, ey if s < 0 else side * abs(c))
            y1 = max(reach, ey if s > 0 else side * abs(c))
        low = max(0, math.floor((y + y0 - oy) / resolution))
        high = min(rows - 1, math.floor((y + y1 - oy) / resolution))
        left = max(0, math.floor((x + x0 - ox) / resolution))
        right = min(columns - 1, math.floor((x + x1 - ox) / resolution))
        for row in range(low, high + 1):
            dy = oy + (row + 0.5) * resolution - y
            for column in range(left, right + 1):
                dx = ox + (column + 0.5) * resolution - x
                if still:
                    q = (dx * dx + dy * dy) / (2 * p.still)
                else:
                    u = c * dx + s * dy
                    w = c * dy - s * dx
                    if u > 0:
                        q = u * u / (2 * front) + w * w / (2 * p.side)
                    else:
                        q = u * u / (2 * p.rear) + w * w / (2 * p.rear_side)
                    u = cr * dx + sr * dy
                    if p.use_right != 0 and u > 0:
                        w = cr * dy - sr * dx
                        q = min(
                            q,
                            u * u / (2 * p.right) + w * w / (2 * p.right_side),
                        )
                if q > most:
                    continue
                value = p.amplitude * math.exp(-q)
                old = costs[row, column]
                if value >= p.cutoff and old != 255 and value > old:
                    costs[row, column] = np.uint8(min(math.floor(value), 254))


def social_parameters(config: SocialLayer) -> Array:
    """Returns the `Parameters` of a layer as an array for `add_people`."""
    factor = config.speed_factor_multiplier if config.use_vel_factor else 0.0
    return np.array(
        Parameters(
            amplitude=config.amplitude,
            cutoff=config.cutoff,
            still=config.covariance_when_still,
            front=config.covariance_front_height,
            side=config.covariance_front_width,
            rear=config.covariance_rear_height,
            rear_side=config.covariance_rear_width,
            right=config.covariance_right_height,
            right_side=config.covariance_right_width,
            speed_factor=factor,
            use_right=float(config.use_passing),
        )
    )


def add_social_costs(
    costs: Costs, region: Region, humans: Array, parameters: Array
) -> None:
    """Writes the costs of people into a map, where they are higher.

    `humans` are rows of `human_states`, `parameters` are `social_parameters`.
    Unknown cells stay unknown.
    """
    if len(humans):
        people = np.ascontiguousarray(humans[:, [X, Y, VX, VY]])
        add_people(costs, *region.origin, region.resolution, people, parameters)
