"""The parameters of planners with costmaps, and derived values."""

from abc import abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import field
import math
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple, Self

import numpy as np
from pydantic import Field, StrictBool, StrictFloat, model_validator
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import (
    CONFIG,
    BodyRadius,
    Integer,
    Length,
    PositiveLength,
    check_order,
    within,
)
from hunav_drake.systems.planning.costmap.costmap_config import (
    GlobalCostmap,
    LocalCostmap,
    ObstacleLayer,
    SocialLayer,
)
from hunav_drake.systems.planning.navigation.memory import (
    Control,
    LocalPlan,
    NavigationMemory,
)
from hunav_drake.systems.planning.navigation.profiles import (
    NAVIGATION_PROFILES,
    ProfileName,
    either,
    navigation_radius,
)
from hunav_drake.systems.planning.planner import PlanningTask, View
from hunav_drake.systems.planning.pure_planner import Planner
from hunav_drake.systems.world.maps.costs import NO_MAP, Costmap
from hunav_drake.systems.world.obstacles import Obstacles

if TYPE_CHECKING:
    from hunav_drake.systems.planning.navigation.maps import Maps

Seconds = Annotated[StrictFloat, within(0, 3600, "s")]
Replanning = Annotated[StrictFloat, within(0, 3600, "s", low_open=True)]


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class ProgressChecker:
    """Progress checker, as Nav2's SimpleProgressChecker."""

    required_movement_radius: PositiveLength = 0.5
    """Distance that the robot must move within the time allowance, in meters.
    """

    movement_time_allowance: Replanning = 10.0
    """Time allowance for that distance, in seconds."""


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class Recoveries:
    """Recoveries when navigation fails, as in nav2_recoveries.

    The profile gives their kinds and order.
    """

    most: Annotated[Integer, Field(ge=0, le=1000)] = 6
    """Maximum number of recovery rounds before the planner gives up."""

    spin_angle: Annotated[StrictFloat, within(0, 2 * math.pi, "rad")] = 1.57
    """Angle of the turn in place, in radians."""

    min_spin: Annotated[StrictFloat, within(0, 10, "rad/s", low_open=True)] = (
        0.4
    )
    """Minimum turn rate of the turn in place, in rad/s."""

    max_spin: Annotated[StrictFloat, within(0, 10, "rad/s", low_open=True)] = (
        1.0
    )
    """Maximum turn rate of the turn in place, in rad/s."""

    spin_acceleration: Annotated[
        StrictFloat, within(0, 100, "rad/s^2", low_open=True)
    ] = 3.2
    """Angular acceleration of the turn in place, in rad/s^2."""

    wait_time: Seconds = 5.0
    """Duration of a wait, in seconds."""

    back_up_distance: Length = 0.3
    """Distance to back up, in meters."""

    back_up_speed: Annotated[
        StrictFloat, within(0, 10, "m/s", low_open=True)
    ] = 0.05
    """Speed of backing up, in m/s."""

    look_ahead: Seconds = 2.0
    """Time horizon of the collision check while backing up, in seconds."""

    @model_validator(mode="after")
    def _check_spins(self) -> Self:
        check_order(self, "min_spin", "max_spin")
        return self


class NavigationSetup(NamedTuple):
    """Values derived from the parameters and the task, computed once.

    `maps` is a `Maps`; `robot_radius`, in meters, and `footprint`, shape (16,
    2), are those of the robot in planning; `window` is half the side length of
    the local costmap, in meters. The others are those of the profile or the
    parameter of that name.
    """

    maps: Any
    robot_radius: float
    footprint: Array
    window: float
    failure_tolerance: float
    recoveries: tuple[str, ...]
    one_at_a_time: bool
    update_period: float


@explain
@dataclass(kw_only=True, config=CONFIG)
class NavigationParameters(Planner):
    """The parameters and maps of a `NavigationPlanner`."""

    initial_memory: ClassVar[Any] = NavigationMemory()
    decides_by: ClassVar[str] = "control"

    uses_local_map: ClassVar[bool] = True
    """Whether the local controller uses the local costmap; otherwise it gets
    one without cells, and a cycle is faster."""

    initial_control: ClassVar[Any] = None
    """The initial memory of the local controller; immutable."""

    profile: ProfileName = "pmb2_foxy"
    """Profile of default parameters: a robot and a release of Nav2."""

    robot_radius: BodyRadius | None = None
    """Radius of the robot on the costmaps, in meters. None: 0.275, that of
    PMB2, for robots between it and the 0.35 m of the paper's metrics; the
    robot's own radius otherwise."""

    inflation_radius: Annotated[
        StrictFloat, within(0, 20, "m", low_open=True)
    ] = 0.55
    """Inflation radius around obstacles, in meters."""

    cost_scaling_factor: (
        Annotated[StrictFloat, within(0, 1000, "1/m")] | None
    ) = None
    """Decay rate of the inflation cost with distance, in 1/m. None: the value
    of the profile."""

    local_costmap: LocalCostmap = field(default_factory=LocalCostmap)
    """Local costmap around the robot, on which commands are evaluated."""

    global_costmap: GlobalCostmap = field(default_factory=GlobalCostmap)
    """Global costmap of the whole world, on which global paths are planned."""

    obstacle_layer: ObstacleLayer = field(default_factory=ObstacleLayer)
    """Obstacle layer: the walls and people on the costmaps, and their source.
    """

    social_layer: SocialLayer = field(default_factory=SocialLayer)
    """Social layer: the costs around people, on costmaps with the layer
    "social"."""

    replanning_period: Replanning = 1.0
    """Time between two global plans, in seconds."""

    plan_tolerance: Length = 0.5
    """Tolerance of the end of the global plan around the goal, along x and y,
    in meters."""

    smooth_plan: StrictBool = False
    """Whether global plans are smoothed."""

    progress_checker: ProgressChecker = field(default_factory=ProgressChecker)
    """Parameters of the progress checker."""

    recoveries: Recoveries = field(default_factory=Recoveries)
    """Recoveries for a lack of progress, of a path, or of a command."""

    failure_tolerance: Seconds | None = None
    """Time without a command that is tolerated before a recovery, in seconds.
    None: the value of the profile."""

    @abstractmethod
    def control(
        self,
        task: PlanningTask,
        view: View,
        local: LocalPlan,
        costmap: Costmap,
        memory: Any,
    ) -> Control:
        """Decides the command that follows a local plan.

        A pure function: keep state in its memory, and cache what depends on the
        task alone by `once`.

        Args:
            task: The constant data.
            view: The planner's current observation.
            local: The local plan to follow.
            costmap: The local costmap: the current walls, and the people of
                this cycle or of a few cycles before.
            memory: Its memory of the last cycle; `initial_control` in the first
                cycle and after a recovery.
        """

    def local_span(
        self, task: PlanningTask, view: View, poses: Array, first: int
    ) -> tuple[int, int]:
        """Returns the local poses of the global plan: first and end index.

        By default, they range from the pose nearest to the robot to where the
        plan leaves the local costmap.

        Args:
            task: The constant data.
            view: The planner's current observation.
            poses: The global plan, shape (k, 3).
            first: The index of the first pose that it has not passed.

        Returns:
            The index of the first pose and one past the last; equal if there
            are none.
        """
        x, y = view.robot[:2].tolist()
        away = np.hypot(poses[first:, 0] - x, poses[first:, 1] - y)
        begin = int(away.argmin())
        beyond = away[begin:] > self.setup(task).window
        # (argmax gives 0 if none is beyond.)
        end = begin + int(beyond.argmax())
        if not beyond[end - begin]:
            end = len(away)
        return first + begin, first + end

    def local_map(
        self, task: PlanningTask, view: View, memory: NavigationMemory
    ) -> Costmap:
        """Returns the local costmap on which this cycle evaluates commands.

        It has no cells before the first observation. `memory` is that of the
        last cycle.
        """
        if memory.sight.cycle < 0:
            return NO_MAP
        maps: Maps = self.setup(task).maps
        return maps.local_map(view.robot, memory.sight)

    def global_map(
        self, task: PlanningTask, view: View, memory: NavigationMemory
    ) -> Costmap:
        """Returns the global map on which a path would be planned now.

        The arguments are those of `local_map`.
        """
        maps: Maps = self.setup(task).maps
        return maps.global_map(view.robot, view.humans, view.goal, memory.marks)

    # (The class variable of Planner depends on a parameter here.)
    @property
    def scan_size(self) -> int | None:  # type: ignore[override]
        """The number of lidar distances it needs: None for all, or 0."""
        return None if self.obstacle_layer.source == "lidar" else 0

    def once[Made](
        self, task: PlanningTask, name: str, make: Callable[[], Made]
    ) -> Made:
        """Returns the named value that depends on a task alone, cached."""
        of, things = self.__dict__.get("_made", (None, {}))
        if of is not task:
            things = {}
            self.__dict__["_made"] = task, things
        if name not in things:
            things[name] = make()
        result: Made = things[name]
        return result

    def find_faults(
        self, obstacles: Obstacles, start: Array, goal: Array
    ) -> Iterator[tuple[tuple[str, ...], str]]:
        """Yields faults if the maps of the world are too large."""
        from hunav_drake.systems.planning.navigation import regions

        yield from regions.region_faults(
            obstacles, (start, goal), self.global_costmap
        )

    def setup(self, task: PlanningTask) -> NavigationSetup:
        """Returns the values derived from the parameters and a task, cached."""
        return self.once(task, "navigation", lambda: self._set_up(task))

    def _set_up(self, task: PlanningTask) -> NavigationSetup:
        from hunav_drake.systems.planning.costmap.footprint import (
            circle_footprint,
        )
        from hunav_drake.systems.planning.navigation.maps import Maps

        profile = NAVIGATION_PROFILES[self.profile]
        radius = either(
            self.robot_radius, navigation_radius(task.robot_radius, profile)
        )
        given = self.local_costmap
        local = LocalCostmap(
            size=either(given.size, profile.local_size),
            resolution=either(given.resolution, profile.local_resolution),
            update_period=either(
                given.update_period, profile.local_update_period
            ),
            layers=given.layers,
        )
        assert local.size is not None
        assert local.update_period is not None
        scaling = either(self.cost_scaling_factor, profile.cost_scaling_factor)
        maps = Maps(
            task.obstacles,
            robot_radius=radius,
            inflation=(self.inflation_radius, scaling),
            layer=self.obstacle_layer,
            lidar=task.lidar,
            social=self.social_layer,
            local=local,
            whole=self.global_costmap,
        )
        return NavigationSetup(
            maps=maps,
            robot_radius=radius,
            footprint=circle_footprint(radius),
            window=0.5 * local.size,
            failure_tolerance=either(
                self.failure_tolerance, profile.failure_tolerance
            ),
            recoveries=profile.recoveries,
            one_at_a_time=profile.one_at_a_time,
            update_period=local.update_period,
        )
