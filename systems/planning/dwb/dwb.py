"""DWB: the local planner of Nav2 that rolls out and scores velocities."""

from dataclasses import field
import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, StrictBool, StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.schema import (
    CONFIG,
    Integer,
    Length,
    PositiveLength,
    PositiveSpeed,
    Speed,
    within,
)
from hunav_drake.systems.planning.costmap.costmap_config import Period
from hunav_drake.systems.planning.costmap.grid import Costmap
from hunav_drake.systems.planning.dwb.dwb_memory import DwbMemory
from hunav_drake.systems.planning.navigation.memory import Control, LocalPlan
from hunav_drake.systems.planning.navigation.navigation_planner import (
    NavigationPlanner,
)
from hunav_drake.systems.planning.navigation.profiles import (
    DWB_PROFILES,
    DwbProfile,
    either,
)
from hunav_drake.systems.planning.planner import (
    PlanningTask,
    View,
    register_planner,
)
from hunav_drake.systems.robot.robot_config import (
    Acceleration,
    TurnAcceleration,
    TurnRate,
)

Scale = Annotated[StrictFloat, within(0, 1e6)]
Fall = Annotated[StrictFloat, within(-100, -1e-6, "m/s^2")]
TurnFall = Annotated[StrictFloat, within(-1000, -1e-6, "rad/s^2")]
Samples = Annotated[Integer, Field(ge=2, le=1000)]


@dataclass(kw_only=True, config=CONFIG)
class CriticScales:
    """How much each critic counts; 0 leaves it out."""

    # Turn on the spot to the goal's heading, once there.
    rotate_to_goal: Scale = 32.0
    # No forth and back.
    oscillation: Scale = 1.0
    # The cost of the middle of the robot, and of its outline.
    base_obstacle: Scale = 0.02
    obstacle_footprint: Scale = 0.0
    # Towards the end of the local plan, and onto the plan, of a point ahead.
    goal_align: Scale = 24.0
    path_align: Scale = 32.0
    # The same of the middle of the robot.
    path_dist: Scale = 32.0
    goal_dist: Scale = 24.0
    # Forwards, and straight on.
    prefer_forward: Scale = 0.0
    twirling: Scale = 0.0


@dataclass(kw_only=True, config=CONFIG)
class CriticParameters:
    """What the critics are parametrized by besides their scales."""

    # How far ahead of the robot the point of both Align critics is, in m.
    forward_point_distance: Length = 0.1

    # Whether costs along the way add up; else that of its end counts.
    sum_scores: StrictBool = False

    # RotateToGoal: below which speed, in m/s, the robot turns; how much speed
    # counts before; and how far ahead, in seconds, the heading is looked at,
    # -1 for the end of the way.
    trans_stopped_velocity: Speed = 0.25
    slowing_factor: Scale = 5.0
    lookahead_time: Annotated[StrictFloat, within(-1, 60, "s")] = -1.0

    # Oscillation: after how far, in meters, what turn, in radians, or what
    # time, in seconds, -1 for never, a direction is allowed again; and the
    # speed, in m/s, up to which the turn rate is looked at.
    oscillation_reset_dist: PositiveLength = 0.05
    oscillation_reset_angle: Annotated[
        StrictFloat, within(0, math.pi, "rad", low_open=True)
    ] = 0.2
    oscillation_reset_time: Annotated[StrictFloat, within(-1, 60, "s")] = -1.0
    x_only_threshold: Speed = 0.05

    # PreferForward: what it costs to drive back, or slower than `strafe_x`,
    # in m/s, with less turn than `strafe_theta`, in rad/s; else the turn rate
    # times `theta_scale` counts.
    penalty: Scale = 1.0
    strafe_x: Speed = 0.1
    strafe_theta: Annotated[StrictFloat, within(0, 100, "rad/s")] = 0.2
    theta_scale: Scale = 10.0


@register_planner("dwb")
@dataclass(kw_only=True, config=CONFIG)
class DwbPlanner(NavigationPlanner):
    """Rolls out many velocities, and takes the one that critics like best.

    In each cycle it samples speeds and turn rates that the robot can reach,
    predicts for each pair where the robot goes in the next `sim_time`, and
    takes the one with the lowest sum of scores (nav2_dwb_controller). The
    parameters are named as there.
    """

    initial_control: ClassVar[Any] = DwbMemory()

    # The least and the largest speed, in m/s, and the turn rate, in rad/s.
    # What the robot can do limits them, too.
    min_vel_x: Annotated[StrictFloat, within(-10, 10, "m/s")] = 0.0
    max_vel_x: PositiveSpeed = 1.0
    max_vel_theta: TurnRate | None = None

    # Below these, a sample needs the other to be above.
    min_speed_xy: Speed = 0.0
    min_speed_theta: Annotated[StrictFloat, within(0, 100, "rad/s")] = 0.0

    # How fast the speed, in m/s^2, and the turn rate, in rad/s^2, change.
    acc_lim_x: Acceleration | None = None
    decel_lim_x: Fall | None = None
    acc_lim_theta: TurnAcceleration | None = None
    decel_lim_theta: TurnFall | None = None

    # How many speeds and turn rates are tried.
    vx_samples: Samples = 20
    vtheta_samples: Samples = 20

    # How far ahead the robot is predicted, in seconds.
    sim_time: Period = 1.7

    # How fine, in meters and in radians; with a time, in seconds, only that.
    linear_granularity: PositiveLength = 0.05
    angular_granularity: Annotated[
        StrictFloat, within(0, math.pi, "rad", low_open=True)
    ] = 0.025
    time_granularity: Period | None = None

    # "standard": what is reached within `sim_time`, the prediction
    # accelerates. "limited_accel": what is reached within one cycle, and is
    # held.
    trajectory_generator: Literal["standard", "limited_accel"] = "standard"

    # Whether the command is the first velocity of the prediction, not the one
    # that it comes to.
    limit_vel_cmd_in_traj: StrictBool = False

    # Where the local plan begins and ends, in meters from the robot; without
    # shortening, it ends where the local map does.
    prune_distance: PositiveLength | None = None
    forward_prune_distance: PositiveLength | None = None
    shorten_transformed_plan: StrictBool = True

    scales: CriticScales = field(default_factory=CriticScales)
    critics: CriticParameters = field(default_factory=CriticParameters)

    @property
    def dwb_profile(self) -> DwbProfile:
        """What depends on the release."""
        return DWB_PROFILES[self.profile]

    def local_span(
        self, task: PlanningTask, view: View, poses: Array, first: int
    ) -> tuple[int, int]:
        """Returns which poses are local: see `NavigationPlanner.local_span`.

        From the first that is nearer than `prune_distance`, to the last that
        is no farther than `forward_prune_distance`.
        """
        from hunav_drake.systems.planning.dwb.map_grid import plan_span

        profile = self.dwb_profile
        window = self.setup(task).window
        prune = either(self.prune_distance, profile.prune_distance)
        forward = either(
            self.forward_prune_distance, profile.forward_prune_distance
        )
        far = min(window, forward) if self.shorten_transformed_plan else window
        x, y = view.robot[:2].tolist()
        search = math.inf if profile.search_all else prune
        begin, end = plan_span(poses, first, x, y, min(far, prune), far, search)
        return begin, end

    def control(
        self,
        task: PlanningTask,
        view: View,
        local: LocalPlan,
        costmap: Costmap,
        memory: Any,
    ) -> Control:
        """Decides the command: see `NavigationPlanner.control`."""
        # Reading a scenario does without numba.
        from hunav_drake.systems.planning.dwb.choose import choose

        return choose(self, task, view, local, costmap, memory)
