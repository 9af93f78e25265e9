"""The static layer: the walls of the world as cells, built once."""

import functools

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.planning.costmap.inflation import inflate
from hunav_drake.systems.planning.costmap.marks import Marks, moved
from hunav_drake.systems.planning.costmap.raster import mark_walls
from hunav_drake.systems.world.maps.costs import (
    FREE,
    LETHAL,
    Costmap,
    Costs,
    Region,
    region_of,
)
from hunav_drake.systems.world.obstacles import Obstacles


def walls_on(obstacles: Obstacles, region: Region) -> Costs:
    """Returns a map of walls: lethal on walls, else free.

    Lethal cells are those that an outline crosses, and those with their center
    inside a solid.
    """
    costs = np.full((region.rows, region.columns), FREE, dtype=np.uint8)
    mark_walls(costs, *region.origin, region.resolution, obstacles.table)
    return costs


def costmap_from_obstacles(
    obstacles: Obstacles,
    bounds: tuple[float, float, float, float],
    resolution: float = 0.05,
) -> Costmap:
    """Returns a costmap of walls, without inflation.

    Args:
        obstacles: The walls: `World.obstacles()`.
        bounds: (min x, min y, max x, max y) that it covers, in W, in meters.
        resolution: The side length of a cell, in meters.

    Raises:
        ValueError: If it would have more than 25 million cells.
    """
    region = region_of(bounds[:2], bounds[2:], resolution)
    return region.as_map(walls_on(obstacles, region))


def costmap_from_occupancy(
    occupancy: Array,
    *,
    origin: tuple[float, float] = (0.0, 0.0),
    resolution: float = 0.05,
    occupied: float = 0.65,
    unknown_is_free: bool = False,
) -> Costmap:
    """Returns a costmap from the occupancy probabilities of a map.

    Args:
        occupancy: Shape (rows, columns), in [0, 1], rows ascending in y; NaN
            for unknown cells.
        origin: The lower left corner, in W, in meters.
        resolution: The side length of a cell, in meters.
        occupied: The probability from which a cell counts as occupied.
        unknown_is_free: Whether unknown cells count as free.
    """
    costs = np.where(occupancy >= occupied, LETHAL, FREE).astype(np.uint8)
    if not unknown_is_free:
        costs[np.isnan(occupancy)] = 255
    return Costmap(costs, origin, resolution)


class StaticMap:
    """Holds the walls of a world as a map, plain and inflated; immutable.

    Attributes:
        region: The region of the map.
        walls: Lethal on walls, else free; read-only.
        inflated: The same, inflated; read-only.
    """

    def __init__(self, obstacles: Obstacles, region: Region, graded: Array):
        """Constructs both maps; use `static_map`, which caches them."""
        self.region = region
        self.walls = walls_on(obstacles, region)
        self.inflated = inflate(self.walls, graded)
        for costs in (self.walls, self.inflated):
            costs.setflags(write=False)

    def part(self, region: Region, *, inflated: bool) -> Costs:
        """Returns a copy of a region; cells beyond the map are free."""
        costs = self.inflated if inflated else self.walls
        return moved(Marks(self.region.row, self.region.column, costs), region)


@functools.lru_cache(maxsize=16)
def _static_map(
    obstacles: Obstacles, region: Region, graded: bytes
) -> StaticMap:
    return StaticMap(obstacles, region, np.frombuffer(graded))


def static_map(
    obstacles: Obstacles, region: Region, graded: Array
) -> StaticMap:
    """Returns the walls of a world on a region, cached.

    `graded` are `inflation_costs`.
    """
    return _static_map(obstacles, region, graded.tobytes())
