"""The obstacle layer: obstacles from a lidar or from the ground truth."""

import math

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import X, Y
from hunav_drake.systems.planning.costmap.costmap_config import ObstacleLayer
from hunav_drake.systems.planning.costmap.marks import Marks
from hunav_drake.systems.planning.costmap.scan_kernel import clear_and_mark
from hunav_drake.systems.sensing.scans import sensor_pose
from hunav_drake.systems.sensing.sensor_config import LidarConfig
from hunav_drake.systems.world.maps.costs import FREE, Costs, Region


def scan_ends(lidar: LidarConfig, scan: Array, robot: Array) -> Array:
    """Returns the end points of a lidar's rays: shape (n, 3), (x, y, range).

    A ray that hits nothing ends at the maximum range.

    Args:
        lidar: The lidar that measured.
        scan: n distances, in meters; infinite if nothing is hit.
        robot: (x, y, yaw) of the robot, in W; more is ignored.
    """
    x, y, yaw = sensor_pose(lidar, robot)
    directions = yaw + lidar.angles()
    reach = np.minimum(np.nan_to_num(scan, posinf=math.inf), lidar.range_max)
    return np.column_stack(
        [x + reach * np.cos(directions), y + reach * np.sin(directions), reach]
    )


def moved(marks: Marks, region: Region) -> Costs:
    """Returns a copy of marks on another region; other cells are free."""
    result = np.full((region.rows, region.columns), FREE, dtype=np.uint8)
    rows, columns = marks.costs.shape
    up, left = region.row - marks.row, region.column - marks.column
    r0, r1 = max(up, 0), min(up + region.rows, rows)
    c0, c1 = max(left, 0), min(left + region.columns, columns)
    if r0 < r1 and c0 < c1:
        part = marks.costs[r0:r1, c0:c1]
        result[r0 - up : r1 - up, c0 - left : c1 - left] = part
    return result


def see(
    marks: Marks,
    region: Region,
    ends: Array,
    sensor: tuple[float, float],
    ranges: tuple[float, float],
) -> Marks:
    """Returns the marks of a region after one more scan.

    Args:
        marks: The previous marks, on any region of the same resolution.
        region: The region of the map now.
        ends: The end points of the rays: see `scan_ends`.
        sensor: The position (x, y) of the lidar, in W.
        ranges: The range up to which rays clear, and the range below which
            their ends are marked, in meters.
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
    """Returns the discs (x, y, radius) of the people to mark, shape (n, 3).

    Args:
        humans: Rows of `human_states`.
        robot: The row of the robot.
        config: The parameters of the layer.
    """
    if not config.people_in_scan or not len(humans):
        return np.zeros((0, 3))
    dx, dy = humans[:, X] - robot[X], humans[:, Y] - robot[Y]
    reach = config.marking_range + config.person_radius
    near = (dx * dx + dy * dy < reach * reach).nonzero()[0]
    discs = np.full((len(near), 3), config.person_radius)
    discs[:, :2] = humans[:, : Y + 1][near]
    return discs
