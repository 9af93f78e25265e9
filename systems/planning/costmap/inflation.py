"""The inflation layer: what is near something costs more."""

import functools
import math

import numpy as np
from scipy import ndimage

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.world.maps.costs import (
    FREE,
    INSCRIBED,
    LETHAL,
    UNKNOWN,
    Costs,
)

# The part of a cell by which distances may be off.
_ROUNDING = 1e-9


@functools.lru_cache(maxsize=32)
def inflation_costs(
    resolution: float,
    *,
    inscribed_radius: float,
    inflation_radius: float,
    cost_scaling_factor: float,
) -> Array:
    """Returns the costs of cells by their distance from something lethal.

    With d the distance between the middles of cells: 254 at d = 0, 253 up to
    the inscribed radius r, ``floor(252 exp(-k (d - r)))`` up to the inflation
    radius, 0 beyond (costmap_2d's `InflationLayer::computeCost`). There, the
    inflation radius is in whole cells, rounded up (`Costmap2D::cellDistance`).

    Args:
        resolution: The side of a cell, in meters.
        inscribed_radius: The largest disc about the middle of the robot that
            is all robot: r, in meters.
        inflation_radius: In meters.
        cost_scaling_factor: k, in 1/m.

    Returns:
        The costs by squared distances in cells, 0 to the last that counts.
    """
    reach = math.ceil(inflation_radius / resolution - _ROUNDING)
    squares = np.arange(reach * reach + 1)
    d = np.sqrt(squares) * resolution
    decay = np.exp(-cost_scaling_factor * (d - inscribed_radius))
    costs = np.floor((INSCRIBED - 1) * decay)
    near = d <= inscribed_radius + _ROUNDING * resolution
    costs = np.where(near, INSCRIBED, costs)
    costs[0] = LETHAL
    costs.setflags(write=False)
    return costs


def inflate(costs: Costs, graded: Array) -> Costs:
    """Returns costs with what is near lethal cells made to cost more.

    Costs never sink; unknown cells become inscribed or stay.

    Args:
        costs: Of a map.
        graded: The costs by squared distances: see `inflation_costs`.
    """
    lethal = costs == LETHAL
    if not lethal.any():
        return costs.copy()
    distance = ndimage.distance_transform_edt(~lethal)
    squares = np.rint(distance * distance).astype(np.int64)
    known = np.append(graded, FREE).astype(np.uint8)
    near = known[np.minimum(squares, len(graded))]
    unknown = costs == UNKNOWN
    result: Costs = np.maximum(near, costs)
    result[unknown & (near >= INSCRIBED)] = near[unknown & (near >= INSCRIBED)]
    return result
