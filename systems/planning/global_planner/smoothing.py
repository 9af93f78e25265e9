"""Ways with their corners rounded off."""

import numpy as np
from scipy import ndimage

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.world.maps.costs import INSCRIBED, Costmap

# The lengths over which a way is averaged, in meters: the first that is good.
_LENGTHS = (0.3, 0.15, 0.075)


def smooth_path(points: Array, costmap: Costmap) -> Array:
    """Returns a way averaged along its length, with the same two ends.

    It is averaged less, or not at all, if it would lead through much higher
    costs otherwise.

    Args:
        points: Shape (k, 2), in W, in meters.
        costmap: What it costs to be where.
    """
    if len(points) < 3:
        return points
    lengths = np.hypot(*np.diff(points, axis=0).T)
    spacing = max(float(lengths.mean()), 1e-6)
    allowed = np.maximum(_costs(costmap, points), 0.5 * INSCRIBED)
    for length in _LENGTHS:
        sigma = length / spacing
        # Mirrored through its ends, so that these stay where they are.
        near = min(int(4 * sigma) + 1, len(points) - 1)
        mirrored = np.pad(
            points, ((near, near), (0, 0)), "reflect", reflect_type="odd"
        )
        smooth: Array = ndimage.gaussian_filter1d(
            mirrored, sigma, axis=0, mode="nearest"
        )[near:-near]
        smooth[0], smooth[-1] = points[0], points[-1]
        if (_costs(costmap, smooth) <= allowed).all():
            return smooth
    return points


def _costs(costmap: Costmap, points: Array) -> Array:
    cells = np.floor((points - costmap.origin) / costmap.resolution)
    rows, columns = costmap.costs.shape
    j = np.clip(cells[:, 0], 0, columns - 1).astype(np.int64)
    i = np.clip(cells[:, 1], 0, rows - 1).astype(np.int64)
    costs: Array = costmap.costs[i, j].astype(float)
    return costs
