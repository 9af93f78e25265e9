"""The costmaps of a planner: static parts and current observations."""

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.planning.costmap.costmap_config import (
    GlobalCostmap,
    LocalCostmap,
    ObstacleLayer,
    SocialLayer,
)
from hunav_drake.systems.planning.costmap.footprint import inscribed_radius
from hunav_drake.systems.planning.costmap.inflation import inflation_costs
from hunav_drake.systems.planning.costmap.layers import Surroundings, make_costs
from hunav_drake.systems.planning.costmap.marks import Marks
from hunav_drake.systems.planning.costmap.obstacle_layer import (
    person_discs,
    scan_ends,
    see,
)
from hunav_drake.systems.planning.costmap.social_layer import social_parameters
from hunav_drake.systems.planning.costmap.static_layer import (
    StaticMap,
    static_map,
)
from hunav_drake.systems.planning.navigation.memory import Sight
from hunav_drake.systems.planning.navigation.regions import (
    blocks_around,
    bounds_of,
    global_region,
    wall_region,
)
from hunav_drake.systems.sensing.scans import sensor_pose
from hunav_drake.systems.sensing.sensor_config import LidarConfig
from hunav_drake.systems.world.maps.costs import (
    MOST_CELLS,
    Costmap,
    Region,
    region_around,
)
from hunav_drake.systems.world.obstacles import Obstacles


class Maps:
    """Builds the costmaps of a planner; holds constant data only.

    Attributes:
        radius: The inscribed radius of the robot's footprint, in meters.
    """

    def __init__(
        self,
        obstacles: Obstacles,
        *,
        robot_radius: float,
        inflation: tuple[float, float],
        layer: ObstacleLayer,
        lidar: LidarConfig | None,
        social: SocialLayer,
        local: LocalCostmap,
        whole: GlobalCostmap,
    ) -> None:
        """Builds the constant parts.

        `inflation` is the inflation radius, in meters, and the cost scaling
        factor, in 1/m. `lidar` measures the scans; None without scans. No value
        of `local` is None.

        Raises:
            ValueError: If the global map would have more than 25 million
                cells.
        """
        self.radius = inscribed_radius(robot_radius)
        self._obstacles = obstacles
        self._layer = layer
        self._lidar = lidar
        self._local = tuple(local.layers)
        self._global = tuple(whole.layers)
        assert local.size is not None
        assert local.resolution is not None
        self._size, self._resolution = local.size, local.resolution
        self._margin = whole.margin
        self._whole_resolution = whole.resolution
        self._social = social_parameters(social)
        self._graded = {
            resolution: inflation_costs(
                resolution,
                inscribed_radius=self.radius,
                inflation_radius=inflation[0],
                cost_scaling_factor=inflation[1],
            )
            for resolution in (self._resolution, self._whole_resolution)
        }
        self._bounds = bounds_of(obstacles)
        if len(obstacles.segments):
            # (It covers the walls at least.)
            global_region(
                *(self._bounds, *self._bounds, whole.margin, whole.resolution)
            )
        self._reach = inflation[0]
        around = wall_region(self._bounds, inflation[0], self._resolution)
        self._walls: StaticMap | None = None
        if around.rows * around.columns <= MOST_CELLS:
            graded = self._graded[self._resolution]
            self._walls = static_map(obstacles, around, graded)

    def global_region(self, robot: Array, goal: Array) -> Region:
        """Returns the region of walls, robot, goal, and margin."""
        return global_region(
            self._bounds, robot, goal, self._margin, self._whole_resolution
        )

    def global_map(
        self, robot: Array, humans: Array, goal: Array, marks: Marks | None
    ) -> Costmap:
        """Returns the global map; `marks` are None for the ground truth."""
        region = self.global_region(robot, goal)
        graded = self._graded[self._whole_resolution]
        walls = static_map(self._obstacles, region, graded)
        around = self._around(robot, humans, walls, graded, marks)
        return region.as_map(make_costs(self._global, region, around))

    def static_global_map(self, robot: Array, goal: Array) -> Costmap:
        """Returns the global map without people."""
        nobody = np.zeros((0, 7))
        return self.global_map(robot, nobody, goal, None)

    def local_map(self, robot: Array, sight: Sight) -> Costmap:
        """Returns the local map around the robot from a sight."""
        x, y = robot[:2].tolist()
        region = region_around(x, y, self._size, self._resolution)
        graded = self._graded[self._resolution]
        walls = self._walls
        if walls is None:
            # A world too large for one map: the part around the robot.
            part = blocks_around(region, self._reach)
            walls = static_map(self._obstacles, part, graded)
        around = self._around(
            sight.robot, sight.humans, walls, graded, sight.marks
        )
        return region.as_map(make_costs(self._local, region, around))

    def local_marks(
        self, marks: Marks | None, robot: Array, scan: Array
    ) -> Marks:
        """Returns the marks on the local map after another scan."""
        x, y = robot[:2].tolist()
        region = region_around(x, y, self._size, self._resolution)
        return self._see(marks, region, robot, scan)

    def global_marks(
        self, marks: Marks | None, robot: Array, scan: Array, goal: Array
    ) -> Marks:
        """Returns the marks on the global map after another scan."""
        region = self.global_region(robot, goal)
        return self._see(marks, region, robot, scan)

    def _see(
        self, marks: Marks | None, region: Region, robot: Array, scan: Array
    ) -> Marks:
        lidar, layer = self._lidar, self._layer
        assert lidar is not None
        # A distance of the maximum range is not a hit.
        marking = min(layer.marking_range, lidar.range_max)
        return see(
            marks or Marks(),
            region,
            scan_ends(lidar, scan, robot),
            sensor_pose(lidar, robot)[:2],
            (layer.clearing_range, marking),
        )

    def _around(
        self,
        robot: Array,
        humans: Array,
        walls: StaticMap,
        graded: Array,
        marks: Marks | None,
    ) -> Surroundings:
        free = self.radius if self._layer.footprint_clearing else -1.0
        return Surroundings(
            walls=walls,
            discs=person_discs(humans, robot, self._layer),
            humans=humans,
            robot=np.array([robot[0], robot[1], free]),
            graded=graded,
            social=self._social,
            marks=marks,
        )
