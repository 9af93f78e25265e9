"""What planners with maps share: they add how to follow the global plan."""

from abc import abstractmethod
from collections.abc import Callable
import copy
from dataclasses import field
import math
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import Field, StrictBool, StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.arrays import Array
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
from hunav_drake.systems.planning.costmap.grid import Costmap
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
from hunav_drake.systems.planning.planner import (
    Plan,
    Planner,
    PlanningTask,
    View,
)

Seconds = Annotated[StrictFloat, within(0, 3600, "s")]
Replanning = Annotated[StrictFloat, within(0, 3600, "s", low_open=True)]


@dataclass(kw_only=True, config=CONFIG)
class ProgressChecker:
    """When a robot counts as not getting on: nav2's SimpleProgressChecker."""

    # How far it must come, in meters, in how long, in seconds.
    required_movement_radius: PositiveLength = 0.5
    movement_time_allowance: Replanning = 10.0


@dataclass(kw_only=True, config=CONFIG)
class Recoveries:
    """What is done when navigation fails: nav2_recoveries.

    Which of them, and in what order, the profile tells.
    """

    # How many times something is done before the planner gives up.
    most: Annotated[Integer, Field(ge=0, le=1000)] = 6

    # The turn on the spot, in radians, and its turn rates, in rad/s and
    # rad/s^2.
    spin_angle: Annotated[StrictFloat, within(0, 2 * math.pi, "rad")] = 1.57
    min_spin: Annotated[StrictFloat, within(0, 10, "rad/s", low_open=True)] = (
        0.4
    )
    max_spin: Annotated[StrictFloat, within(0, 10, "rad/s", low_open=True)] = (
        1.0
    )
    spin_acceleration: Annotated[
        StrictFloat, within(0, 100, "rad/s^2", low_open=True)
    ] = 3.2

    # How long it waits, in seconds.
    wait_time: Seconds = 5.0

    # How far back it drives, in meters, and how fast, in m/s.
    back_up_distance: Length = 0.3
    back_up_speed: Annotated[
        StrictFloat, within(0, 10, "m/s", low_open=True)
    ] = 0.05

    # How far ahead it looks whether it would touch something, in seconds.
    look_ahead: Seconds = 2.0


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


@dataclass(kw_only=True, config=CONFIG)
class NavigationPlanner(Planner):
    """Follows a global plan on costmaps, as the servers of Nav2 do together.

    Once per `replanning_period` it finds a way on the global map (`plan_path`);
    in each cycle a local controller, which a derived class gives by `control`,
    follows the part of it near the robot on the local map. If there is no way
    or no command, or if the robot does not get on, it tries recoveries, and
    after too many of them it gives up.

    What is None is as the profile tells.
    """

    initial_memory: ClassVar[Any] = NavigationMemory()
    decides_by: ClassVar[str] = "control"

    # Whether the local controller looks at the local map; else it gets one
    # without cells, and a cycle is faster.
    uses_local_map: ClassVar[bool] = True

    # What the local controller remembers at first; immutable.
    initial_control: ClassVar[Any] = None

    # The release of Nav2 and the robot whose parameters are taken.
    profile: ProfileName = "pmb2_foxy"

    # The radius of the robot on the maps, in meters; by default that of PMB2,
    # 0.275, for a robot from there up to the 0.35 m that the paper's metrics
    # take for it; for other robots their own.
    robot_radius: BodyRadius | None = None

    # How far obstacles are inflated, in meters, and how fast the cost falls.
    inflation_radius: PositiveLength = 0.55
    cost_scaling_factor: (
        Annotated[StrictFloat, within(0, 1000, "1/m")] | None
    ) = None

    local_costmap: LocalCostmap = field(default_factory=LocalCostmap)
    global_costmap: GlobalCostmap = field(default_factory=GlobalCostmap)
    obstacle_layer: ObstacleLayer = field(default_factory=ObstacleLayer)
    social_layer: SocialLayer = field(default_factory=SocialLayer)

    # The time between two global plans, in seconds.
    replanning_period: Replanning = 1.0

    # How far from the goal the global plan may end along x and y, in meters.
    plan_tolerance: Length = 0.5

    # Whether the corners of global plans are rounded off.
    smooth_plan: StrictBool = False

    progress_checker: ProgressChecker = field(default_factory=ProgressChecker)
    recoveries: Recoveries = field(default_factory=Recoveries)

    # How long there may be no command before it counts as a failure, in s.
    failure_tolerance: Seconds | None = None

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

    def plan(self, task: PlanningTask, view: View, memory: Any) -> Plan:
        """Decides the command of one cycle: see `Planner.plan`."""
        # Reading a scenario does without numba.
        from hunav_drake.systems.planning.navigation.navigate import navigate

        return navigate(self, task, view, memory)

    def MakeSystem(self, task: PlanningTask) -> Any:
        """Makes a `LocalPlanner` that decides by `plan`.

        Raises:
            ValueError: If a map of the world would be too large.
        """
        # Parameters that are changed later are those of later systems.
        planner = copy.deepcopy(self)
        planner.setup(task)
        return super(NavigationPlanner, planner).MakeSystem(task)

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
