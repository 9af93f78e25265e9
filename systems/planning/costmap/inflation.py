"""The inflation layer: cells near obstacles cost more."""

import functools
import math

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.world.maps.costs import (
    FREE,
    INSCRIBED,
    LETHAL,
    UNKNOWN,
    Costs,
)

# Tolerance of distances, as a fraction of a cell.
_ROUNDING = 1e-9

# For more cells, times the reach in cells, SciPy is faster, once it is loaded.
_MUCH = 16_000_000


@functools.lru_cache(maxsize=32)
def inflation_costs(
    resolution: float,
    *,
    inscribed_radius: float,
    inflation_radius: float,
    cost_scaling_factor: float,
) -> Array:
    """Returns the costs of cells by their distance from a lethal cell.

    With d the distance between the centers of cells: 254 at d = 0, 253 up to
    the inscribed radius r, ``floor(252 exp(-k (d - r)))`` up to the inflation
    radius, 0 beyond (costmap_2d's `InflationLayer::computeCost`). The inflation
    radius is rounded up to whole cells (`Costmap2D::cellDistance`).

    Args:
        resolution: The side length of a cell, in meters.
        inscribed_radius: The radius r of the largest disc around the robot's
            center that lies in its footprint, in meters.
        inflation_radius: In meters.
        cost_scaling_factor: k, in 1/m.

    Returns:
        The costs by squared distance in cells, from 0 to the last that counts.
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
    """Returns costs with inflation around the lethal cells.

    `graded` are `inflation_costs`. Costs never decrease; unknown cells become
    inscribed or stay unknown.
    """
    lethal = costs == LETHAL
    if not lethal.any():
        return costs.copy()
    far = math.isqrt(len(graded))
    if lethal.size * far <= _MUCH:
        squares = _squared_distances(lethal, len(graded))
    else:
        # Imported here: that takes longer than the inflation of most maps.
        from scipy import ndimage

        distances = ndimage.distance_transform_edt(~lethal)
        squares = np.rint(distances * distances).astype(np.int64)
        np.minimum(squares, len(graded), out=squares)
    near = np.append(graded, FREE).astype(np.uint8)[squares]
    unknown = costs == UNKNOWN
    result: Costs = np.maximum(near, costs)
    result[unknown & (near >= INSCRIBED)] = near[unknown & (near >= INSCRIBED)]
    return result


def _squared_distances(lethal: Array, most: int) -> Array:
    """Returns each cell's squared distance from the next lethal cell, in cells.

    Values are at most `most`.
    """
    rows = np.arange(len(lethal))[:, np.newaxis]
    far = len(lethal) + math.isqrt(most) + 1
    below = np.maximum.accumulate(np.where(lethal, rows, -far))
    above = np.where(lethal, rows, len(lethal) + far)
    above = np.minimum.accumulate(above[::-1])[::-1]
    along = np.minimum(np.minimum(rows - below, above - rows) ** 2, most)
    squares: Array = along.copy()
    for k in range(1, min(math.isqrt(most), lethal.shape[1] - 1) + 1):
        for near, other in (
            (np.s_[:, k:], np.s_[:, :-k]),
            (np.s_[:, :-k], np.s_[:, k:]),
        ):
            np.minimum(squares[near], along[other] + k * k, out=squares[near])
    return squares
