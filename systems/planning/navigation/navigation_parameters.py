"""What planners with maps are parametrized by, and what follows from it."""

from abc import abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import field
import math
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import Field, StrictBool, StrictFloat
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
    """When a robot counts as not getting on: nav2's SimpleProgressChecker."""

    required_movement_radius: PositiveLength = 0.5
    """How far the robot must come in the time allowed, in meters."""

    movement_time_allowance: Replanning = 10.0
    """The time allowed for that distance, in seconds."""


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class Recoveries:
    """What is done when navigation fails: nav2_recoveries.

    Which of them, and in what order, the profile tells.
    """

    most: Annotated[Integer, Field(ge=0, le=1000)] = 6
    """How many times something is done before the planner gives up."""

    spin_angle: Annotated[StrictFloat, within(0, 2 * math.pi, "rad")] = 1.57
    """The turn on the spot, in radians."""

    min_spin: Annotated[StrictFloat, within(0, 10, "rad/s", low_open=True)] = (
        0.4
    )
    """The least turn rate of that turn, in rad/s."""

    max_spin: Annotated[StrictFloat, within(0, 10, "rad/s", low_open=True)] = (
        1.0
    )
    """The largest turn rate of that turn, in rad/s."""

    spin_acceleration: Annotated[
        StrictFloat, within(0, 100, "rad/s^2", low_open=True)
    ] = 3.2
    """How fast its turn rate changes, in rad/s^2."""

    wait_time: Seconds = 5.0
    """How long it waits, in seconds."""

    back_up_distance: Length = 0.3
    """How far back it drives, in meters."""

    back_up_speed: Annotated[
        StrictFloat, within(0, 10, "m/s", low_open=True)
    ] = 0.05
    """How fast it drives back, in m/s."""

    look_ahead: Seconds = 2.0
    """How far ahead it looks whether it would touch something, in seconds."""


class NavigationSetup(NamedTuple):
    """What follows from the parameters and the task, made once.

    Attributes:
        maps: Makes the costmaps: a `Maps`.
        robot_radius: The radius that the robot is planned with, in meters.
        footprint: The outline of the robot, shape (16, 2).
        window: Half the side of the local map, in meters.
        failure_tolerance: How long there may be no command, in seconds.
        recoveries: What is done when navigation fails.
        one_at_a_time: Whether one of them is done per failure, in turns.
        update_period: That of the local map, in seconds.
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
    """What a `NavigationPlanner` has, but for how it navigates by it."""

    initial_memory: ClassVar[Any] = NavigationMemory()
    decides_by: ClassVar[str] = "control"

    uses_local_map: ClassVar[bool] = True
    """Whether the local controller looks at the local map; else it gets one
    without cells, and a cycle is faster."""

    initial_control: ClassVar[Any] = None
    """What the local controller remembers at first; immutable."""

    profile: ProfileName = "pmb2_foxy"
    """The release of Nav2 and the robot whose parameters are taken."""

    robot_radius: BodyRadius | None = None
    """The radius of the robot on the maps, in meters; by default that of PMB2,
    0.275, for a robot from there up to the 0.35 m that the paper's metrics take
    for it; for other robots their own."""

    inflation_radius: Annotated[
        StrictFloat, within(0, 20, "m", low_open=True)
    ] = 0.55
    """How far around obstacles cells cost something, in meters."""

    cost_scaling_factor: (
        Annotated[StrictFloat, within(0, 1000, "1/m")] | None
    ) = None
    """How fast that cost falls with the distance, in 1/m; by default as the
    profile has it."""

    local_costmap: LocalCostmap = field(default_factory=LocalCostmap)
    """The map around the robot, on which commands are judged."""

    global_costmap: GlobalCostmap = field(default_factory=GlobalCostmap)
    """The map of the whole world, on which ways are found."""

    obstacle_layer: ObstacleLayer = field(default_factory=ObstacleLayer)
    """What the maps show of walls and people, and how they learn of it."""

    social_layer: SocialLayer = field(default_factory=SocialLayer)
    """The costs around people, on maps whose layers name "social"."""

    replanning_period: Replanning = 1.0
    """The time between two global plans, in seconds."""

    plan_tolerance: Length = 0.5
    """How far from the goal the global plan may end along x and y, in meters.
    """

    smooth_plan: StrictBool = False
    """Whether the corners of global plans are rounded off."""

    progress_checker: ProgressChecker = field(default_factory=ProgressChecker)
    """When the robot counts as not getting on."""

    recoveries: Recoveries = field(default_factory=Recoveries)
    """What is tried when it does not get on, or finds no way or command."""

    failure_tolerance: Seconds | None = None
    """How long there may be no command before it counts as a failure, in s."""

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

        A pure function: what it is to remember goes through its memory, and
        what can be made once from the task through `once`.

        Args:
            task: What does not change.
            view: What the planner sees now.
            local: What is to be followed.
            costmap: The local map: the room of now, and people of this cycle
                or a few before.
            memory: What it remembered in the last cycle, and
                `initial_control` in the first and after a recovery.
        """

    def local_span(
        self, task: PlanningTask, view: View, poses: Array, first: int
    ) -> tuple[int, int]:
        """Returns which poses of the global plan are local: first and end.

        By default from the one nearest to the robot, up to where the plan
        leaves the local map.

        Args:
            task: What does not change.
            view: What the planner sees now.
            poses: The global plan, shape (k, 3).
            first: The first pose that it has not passed.

        Returns:
            The first and one after the last; the same number if there are
            none.
        """
        x, y = view.robot[:2].tolist()
        away = np.hypot(poses[first:, 0] - x, poses[first:, 1] - y)
        begin = int(away.argmin())
        beyond = away[begin:] > self.setup(task).window
        # (Of none, the first is the first of all.)
        end = begin + int(beyond.argmax())
        if not beyond[end - begin]:
            end = len(away)
        return first + begin, first + end

    def local_map(
        self, task: PlanningTask, view: View, memory: NavigationMemory
    ) -> Costmap:
        """Returns the local map, around the robot.

        Args:
            task: What does not change.
            view: What the planner sees now.
            memory: What the last cycle remembered.

        Returns:
            The map that this cycle judged commands on, or would have; one
            without cells before it has looked.
        """
        if memory.sight.cycle < 0:
            return NO_MAP
        maps: Maps = self.setup(task).maps
        return maps.local_map(view.robot, memory.sight)

    def global_map(
        self, task: PlanningTask, view: View, memory: NavigationMemory
    ) -> Costmap:
        """Returns the global map: that on which a way would be found now.

        The arguments are those of `local_map`.
        """
        maps: Maps = self.setup(task).maps
        return maps.global_map(view.robot, view.humans, view.goal, memory.marks)

    # (The class variable of Planner hangs on a parameter here.)
    @property
    def scan_size(self) -> int | None:  # type: ignore[override]
        """How many distances of a lidar it asks for: all, or none."""
        return None if self.obstacle_layer.source == "lidar" else 0

    def once[Made](
        self, task: PlanningTask, name: str, make: Callable[[], Made]
    ) -> Made:
        """Returns what is made from the parameters and a task only once.

        Args:
            task: The task.
            name: What it is called.
            make: Makes it.
        """
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
        """Looks whether the maps of the world are small enough."""
        from hunav_drake.systems.planning.navigation import regions

        usual = NAVIGATION_PROFILES[self.profile].local_resolution
        local = either(self.local_costmap.resolution, usual)
        yield from regions.region_faults(
            *(obstacles, (start, goal), self.inflation_radius),
            *(local, self.global_costmap),
        )

    def setup(self, task: PlanningTask) -> NavigationSetup:
        """Returns what follows from the parameters and a task."""
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
