"""The distances of the places of a grid from the nearest wall."""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.world.nearest import signed_distances

# The largest number of places of a field: 200 MB.
_MOST = 25_000_000


@dataclass(frozen=True, eq=False)
class DistanceField:
    """Distances to the nearest wall, on a grid with axes along those of W.

    Attributes:
        distances: Shape (rows, columns), in meters, read-only: negative inside
            solids, infinite without walls. ``distances[i, j]`` is that of the
            place ``origin + resolution * (j, i)``: rows go up along y.
        origin: The place (x, y) of ``distances[0, 0]``, in W, in meters.
        resolution: The distance between neighbors, in meters.
    """

    distances: Array
    origin: tuple[float, float]
    resolution: float

    def at(self, points: ArrayLike) -> Array:
        """Returns the distances of points (..., 2), in meters.

        They are those of the nearest places of the grid; within it, their
        error is at most ``resolution / sqrt(2)``.
        """
        cells = (
            np.asarray(points, dtype=float) - self.origin
        ) / self.resolution
        rows, columns = self.distances.shape
        j = np.clip(np.rint(cells[..., 0]), 0, columns - 1).astype(np.int64)
        i = np.clip(np.rint(cells[..., 1]), 0, rows - 1).astype(np.int64)
        return self.distances[i, j]


def distance_field(
    table: Array, resolution: float, bounds: tuple[float, float, float, float]
) -> DistanceField:
    """Returns the field of `Obstacles.distance_field` from its `table`."""
    x0, y0, x1, y1 = map(float, bounds)
    if not 0 < resolution < math.inf:
        raise ValueError(f"resolution must be positive, got {resolution} m")
    if not (
        -math.inf < x0 <= x1 < math.inf and -math.inf < y0 <= y1 < math.inf
    ):
        raise ValueError(
            "bounds must be (least x, least y, largest x, largest y) in meters,"
            f" got {bounds}"
        )
    # (Whole steps, but for rounding.)
    columns, rows = (
        math.ceil((high - low) / resolution - 1e-9) + 1
        for low, high in ((x0, x1), (y0, y1))
    )
    if rows * columns > _MOST:
        raise ValueError(
            f"resolution: {resolution} m gives {rows * columns} places within"
            f" the bounds; take at most {_MOST}"
        )
    distances: Array = signed_distances(
        x0, y0, resolution, rows, columns, table
    )
    distances.setflags(write=False)
    return DistanceField(distances, (x0, y0), float(resolution))
