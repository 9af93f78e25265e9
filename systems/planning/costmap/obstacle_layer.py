"""The obstacle layer: obstacles from a lidar or from the ground truth."""

import math

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.planning.costmap.costmap_config import ObstacleLayer
from hunav_drake.systems.planning.costmap.marks import Marks, moved
from hunav_drake.systems.planning.costmap.raster import discs_near
from hunav_drake.systems.planning.costmap.scan_kernel import clear_and_mark
from hunav_drake.systems.sensing.scans import sensor_pose
from hunav_drake.systems.sensing.sensor_config import LidarConfig
from hunav_drake.systems.world.maps.costs import FREE, Costs, Region

_NO_DISCS: Array = np.zeros((0, 3))
_NO_DISCS.setflags(write=False)


def scan_ends(lidar: LidarConfig, scan: Array, robot: Array) -> Array:
    """Returns the end points of a lidar's rays: shape (n, 3), (x, y, range).

    They are in W, in meters, from n distances in meters and the pose (x, y,
    yaw) of the robot. A ray without a hit ends at the maximum range.
    """
    x, y, yaw = sensor_pose(lidar, robot)
    directions = yaw + lidar.angles()
    reach = np.minimum(np.nan_to_num(scan, posinf=math.inf), lidar.range_max)
    return np.column_stack(
        [x + reach * np.cos(directions), y + reach * np.sin(directions), reach]
    )


def see(
    marks: Marks,
    region: Region,
    ends: Array,
    sensor: tuple[float, float],
    ranges: tuple[float, float],
) -> Marks:
    """Returns the marks of a region after one more scan.

    The rays run from the sensor (x, y) to `ends` (see `scan_ends`), in W.
    `ranges` are the range up to which rays clear, and the range below which
    their ends are marked, in meters. The old marks may be on any region of the
    same resolution.
    """
    costs = moved(marks, region)
    clear_and_mark(
        *(costs, *region.origin, region.resolution, *sensor, ends), *ranges
    )
    costs.setflags(write=False)
    return Marks(region.row, region.column, costs)


def free_disc(costs: Costs, region: Region, disc: Array) -> None:
    """Frees the cells with their center in a disc (x, y, radius), in place."""
    r = region.resolution
    x, y = disc[0] - region.origin[0], disc[1] - region.origin[1]
    rows = slice(
        max(math.floor((y - disc[2]) / r), 0),
        max(math.floor((y + disc[2]) / r) + 1, 0),
    )
    columns = slice(
        max(math.floor((x - disc[2]) / r), 0),
        max(math.floor((x + disc[2]) / r) + 1, 0),
    )
    part = costs[rows, columns]
    i = (rows.start + np.arange(part.shape[0]) + 0.5) * r - y
    j = (columns.start + np.arange(part.shape[1]) + 0.5) * r - x
    part[i[:, None] ** 2 + j**2 <= disc[2] ** 2] = FREE


def person_discs(humans: Array, robot: Array, config: ObstacleLayer) -> Array:
    """Returns the discs (x, y, radius) of the people to mark, shape (n, 3)."""
    if not config.people_in_scan or not len(humans):
        return _NO_DISCS
    reach = config.marking_range + config.person_radius
    discs: Array = discs_near(
        np.ascontiguousarray(humans), *robot[:2], reach, config.person_radius
    )
    return discs
