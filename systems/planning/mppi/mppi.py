"""MPPI: the local planner of Nav2 that samples and averages controls."""

from dataclasses import field
import math
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field, StrictBool, StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import (
    CONFIG,
    Integer,
    Length,
    PositiveLength,
    PositiveSpeed,
    Speed,
    within,
)
from hunav_drake.systems.people.parameters import SocialForceParameters
from hunav_drake.systems.planning.mppi.mppi_memory import MppiMemory
from hunav_drake.systems.planning.navigation.memory import Control, LocalPlan
from hunav_drake.systems.planning.navigation.navigation_planner import (
    NavigationPlanner,
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
from hunav_drake.systems.world.maps.costs import Costmap

Weight = Annotated[StrictFloat, within(0, 1e9)]
Deviation = Annotated[StrictFloat, within(1e-6, 100)]
Steps = Annotated[Integer, Field(ge=1, le=1000)]
Points = Annotated[Integer, Field(ge=0, le=10_000)]


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class CriticWeights:
    """How much each critic counts; 0 leaves it out."""

    constraint: Weight = 4.0
    """How much counts to stay within the bounds of the velocity."""

    cost: Weight = 3.81
    """How much counts to keep away from what the local map shows."""

    goal: Weight = 5.0
    """How much counts to get to the goal, when near it; for a `goal_tolerance`
    below 0.25 m, more by as much as it is smaller."""

    goal_angle: Weight = 3.0
    """How much counts to turn to the heading of the goal, when near it; 0 where
    `goal_yaw_tolerance` leaves any heading."""

    path_align: Weight = 14.0
    """How much counts to stay on the global plan."""

    path_follow: Weight = 5.0
    """How much counts to get on along the global plan."""

    path_angle: Weight = 2.0
    """How much counts to be turned to the global plan."""

    prefer_forward: Weight = 5.0
    """How much counts not to drive backwards."""

    social: Weight = 1.0
    """How much counts little social force between the robot and people; 0
    leaves MPPI as Nav2 has it."""


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class CriticSettings:
    """What the critics are parametrized by besides their weights."""

    collision_cost: Weight = 1e6
    """What it costs to collide."""

    critical_cost: Weight = 300.0
    """With the outline of the robot: what it costs to have its middle so near
    to something that in some heading it would collide, as a cost of cells."""

    consider_footprint: StrictBool = False
    """Whether a collision is that of the outline; else that of the disc."""

    near_goal_distance: Length = 1.0
    """How near to the goal costs of cells that are not critical are ignored, in
    meters."""

    goal_threshold: Length = 1.4
    """How near to the goal the critic Goal begins, in meters."""

    goal_angle_threshold: Length = 0.5
    """How near to the goal the critic GoalAngle begins, in meters; no farther
    than `goal_tolerance`, if that is below 0.25 m."""

    path_follow_threshold: Length = 1.4
    """How near to the goal the critic PathFollow ends, in meters."""

    path_threshold: Length = 0.5
    """How near to the goal PathAlign, PathAngle and PreferForward end, in
    meters."""

    path_align_offset: Points = 20
    """How many points of the plan must be reached for PathAlign to count."""

    max_path_occupancy_ratio: Annotated[StrictFloat, within(0, 1)] = 0.05
    """Which part of these points may be blocked at most, for PathAlign to
    count."""

    path_follow_offset: Points = 5
    """How many points beyond the furthest that is reached PathFollow looks."""

    path_angle_offset: Points = 4
    """How many points beyond the furthest that is reached PathAngle looks."""

    max_angle_to_furthest: Annotated[StrictFloat, within(0, math.pi, "rad")] = (
        1.0
    )
    """The turn from which on PathAngle counts, in radians."""

    cost_step: Steps = 2
    """At every how many steps of a rollout Cost looks."""

    path_align_step: Steps = 4
    """At every how many steps of a rollout PathAlign looks."""

    social_step: Steps = 4
    """At every how many steps of a rollout Social looks."""


@register_planner("mppi")
@dataclass(kw_only=True, config=CONFIG)
class MppiPlanner(NavigationPlanner):
    """Samples controls around the last best ones, and averages the good ones.

    Model predictive path integral control (Williams et al. 2017): in each
    cycle it adds noise to the controls of the next seconds, `batch_size`
    times, predicts for each where the robot goes, and takes the mean by how
    well critics like it. The parameters are those of nav2_mppi_controller; to
    its critics one is added, of the social forces between robot and people.

    The draws follow from `noise_seed` and the number of the cycle.
    """

    initial_control: ClassVar[Any] = MppiMemory()

    time_steps: Annotated[Integer, Field(ge=2, le=1000)] = 56
    """How many steps of `model_dt` it looks ahead: with 0.05 s each, 2.8 s,
    whatever the period of the planner."""

    model_dt: Annotated[StrictFloat, within(1e-3, 1, "s")] = 0.05
    """How long each of these steps is, in seconds. Where a command holds for
    longer, they are a bit shorter, so that it holds for whole steps, but never
    shorter than a step of the trial."""

    batch_size: Annotated[Integer, Field(ge=1, le=100_000)] = 1000
    """How many rollouts there are in a cycle."""

    iteration_count: Annotated[Integer, Field(ge=1, le=100)] = 1
    """How often a cycle improves its controls, each time with new rollouts."""

    max_vel_x: PositiveSpeed = 0.6
    """The largest speed forwards, in m/s. What the robot can do limits it, too.
    """

    max_reverse_vel_x: Speed = 0.35
    """The largest speed backwards, in m/s; limited as above."""

    max_vel_theta: TurnRate = 1.9
    """The largest turn rate, in rad/s; limited as above."""

    max_acc_x: Acceleration = 3.0
    """How fast the speed changes at most, in m/s^2; limited as above."""

    max_acc_theta: TurnAcceleration = 3.5
    """How fast the turn rate changes at most, in rad/s^2; limited as above."""

    vx_std: Deviation = 0.2
    """The standard deviation of the noise of speeds, in m/s."""

    wz_std: Deviation = 0.4
    """The standard deviation of the noise of turn rates, in rad/s."""

    noise_seed: Annotated[Integer, Field(ge=0, lt=2**63)] = 0
    """The seed of the noise."""

    regenerate_noises: StrictBool = True
    """Whether each cycle has noise of its own; else all have the same."""

    temperature: Annotated[StrictFloat, within(1e-6, 1e6)] = 0.3
    """How much worse a rollout must be to count less by a factor of e."""

    gamma: Annotated[StrictFloat, within(0, 1e3)] = 0.015
    """How much it costs to leave the last controls."""

    prune_distance: PositiveLength = 1.9
    """How far the local plan goes, in meters."""

    path_spacing: Annotated[StrictFloat, within(1e-3, 1, "m")] = 0.05
    """The distance between its points, in meters."""

    weights: CriticWeights = field(default_factory=CriticWeights)
    """How much each critic counts."""

    critics: CriticSettings = field(default_factory=CriticSettings)
    """What else the critics are parametrized by."""

    social_force: SocialForceParameters = field(
        default_factory=SocialForceParameters
    )
    """The social forces of the critic Social."""

    def local_span(
        self, task: PlanningTask, view: View, poses: Array, first: int
    ) -> tuple[int, int]:
        """Returns which poses are local: see `NavigationPlanner.local_span`.

        From the nearest one, to the last that is `prune_distance` along.
        """
        begin, end = NavigationPlanner.local_span(
            self, task, view, poses, first
        )
        steps = np.diff(poses[begin:end, :2], axis=0)
        way = np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))
        beyond = np.searchsorted(way, self.prune_distance, side="right")
        return begin, min(end, begin + 1 + int(beyond))

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
        from hunav_drake.systems.planning.mppi.optimize import optimize

        return optimize(self, task, view, local, costmap, memory)
