"""The regions of a planner's costmaps, and checks of their size."""

from collections.abc import Iterator
import math

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.planning.costmap.costmap_config import GlobalCostmap
from hunav_drake.systems.world.maps.costs import Region, region_of
from hunav_drake.systems.world.obstacles import Obstacles

# A robot outside the walls extends the global map in steps of this, in meters.
_STRIDE = 5.0

# The side of a block of cells.
_BLOCK = 512


def region_faults(
    obstacles: Obstacles, ends: tuple[Array, Array], whole: GlobalCostmap
) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yields the costmaps of a world that would be too large, and why.

    `ends` are the robot's start and goal, in W.
    """
    bounds = bounds_of(obstacles)
    try:
        global_region(bounds, *ends, whole.margin, whole.resolution)
    except ValueError as error:
        yield ("global_costmap", "resolution"), str(error)


def bounds_of(obstacles: Obstacles) -> tuple[Array, Array]:
    """Returns the corners of all walls; infinite ones without walls."""
    points = obstacles.segments.reshape(-1, 2)
    if not len(points):
        return np.full(2, math.inf), np.full(2, -math.inf)
    return points.min(axis=0), points.max(axis=0)


def wall_region(
    bounds: tuple[Array, Array], inflation_radius: float, resolution: float
) -> Region:
    """Returns the region of the walls and their inflation, of any size."""
    if math.isinf(bounds[0][0]):
        return region_of((0.0, 0.0), (0.0, 0.0), resolution)
    # (The inflation may exceed the radius by one cell.)
    near = inflation_radius + 2 * resolution
    return region_of(
        tuple((bounds[0] - near).tolist()),
        tuple((bounds[1] + near).tolist()),
        resolution,
        most=math.inf,
    )


def blocks_around(region: Region, inflation_radius: float) -> Region:
    """Returns whole blocks of the lattice that cover a region.

    They also cover the walls whose inflation reaches it.
    """
    near = math.ceil(inflation_radius / region.resolution) + 2
    row = (region.row - near) // _BLOCK * _BLOCK
    column = (region.column - near) // _BLOCK * _BLOCK
    rows = region.row + region.rows + near - row
    columns = region.column + region.columns + near - column
    return Region(
        row,
        column,
        -(-rows // _BLOCK) * _BLOCK,
        -(-columns // _BLOCK) * _BLOCK,
        region.resolution,
    )


def global_region(
    bounds: tuple[Array, Array],
    robot: Array,
    goal: Array,
    margin: float,
    resolution: float,
) -> Region:
    """Returns the region of the global map."""
    low, high = np.minimum(bounds[0], goal[:2]), np.maximum(bounds[1], goal[:2])
    if (robot[:2] < bounds[0]).any() or (robot[:2] > bounds[1]).any():
        low = np.minimum(low, _STRIDE * np.floor(robot[:2] / _STRIDE))
        high = np.maximum(high, _STRIDE * np.ceil(robot[:2] / _STRIDE))
    return region_of(
        tuple((low - margin).tolist()),
        tuple((high + margin).tolist()),
        resolution,
    )
