"""Ways with their corners rounded off."""

import numpy as np
from scipy import ndimage

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.planning.costmap.grid import INSCRIBED, Costmap

# The length over which a way is averaged, in meters.
_LENGTH = 0.3


def smooth_path(points: Array, costmap: Costmap) -> Array:
    """Returns a way averaged along its length, with the same two ends.

    A point stays where it is if the average of its neighbors costs more, or
    may not be crossed.

    Args:
        points: Shape (k, 2), in W, in meters.
        costmap: What it costs to be where.
    """
    if len(points) < 3:
        return points
    lengths = np.hypot(*np.diff(points, axis=0).T)
    spacing = max(float(lengths.mean()), 1e-6)
    sigma = _LENGTH / spacing
    # Mirrored through its ends, so that these stay where they are.
    near = int(4 * sigma) + 1
    padded = np.pad(
        points, ((near, near), (0, 0)), "reflect", reflect_type="odd"
    )
    smooth = ndimage.gaussian_filter1d(padded, sigma, axis=0, mode="nearest")
    smooth = smooth[near:-near]
    smooth[0], smooth[-1] = points[0], points[-1]
    old, new = _costs(costmap, points), _costs(costmap, smooth)
    worse = (new > old) & (new > 0.5 * INSCRIBED) | (new >= INSCRIBED)
    smooth[worse] = points[worse]
    return smooth


def _costs(costmap: Costmap, points: Array) -> Array:
    cells = np.floor((points - costmap.origin) / costmap.resolution)
    rows, columns = costmap.costs.shape
    j = np.clip(cells[:, 0], 0, columns - 1).astype(np.int64)
    i = np.clip(cells[:, 1], 0, rows - 1).astype(np.int64)
    costs: Array = costmap.costs[i, j].astype(float)
    return costs
