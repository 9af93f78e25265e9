"""MPPI: the local planner of Nav2 that samples and averages controls."""

from dataclasses import field
import math
from typing import Annotated, Any, ClassVar

import numpy as np
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
from hunav_drake.systems.people.parameters import SocialForceParameters
from hunav_drake.systems.planning.costmap.grid import Costmap
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

Weight = Annotated[StrictFloat, within(0, 1e9)]
Deviation = Annotated[StrictFloat, within(1e-6, 100)]
Steps = Annotated[Integer, Field(ge=1, le=1000)]
Points = Annotated[Integer, Field(ge=0, le=10_000)]


@dataclass(kw_only=True, config=CONFIG)
class CriticWeights:
    """How much each critic counts; 0 leaves it out."""

    # Within the bounds of the velocity.
    constraint: Weight = 4.0
    # Away from what the local map shows.
    cost: Weight = 3.81
    # To the goal, and to its heading, when near it.
    goal: Weight = 5.0
    goal_angle: Weight = 3.0
    # On the global plan; on along it; turned to it.
    path_align: Weight = 14.0
    path_follow: Weight = 5.0
    path_angle: Weight = 2.0
    # Not backwards.
    prefer_forward: Weight = 5.0
    # Little social force between the robot and people; 0 leaves MPPI as Nav2
    # has it.
    social: Weight = 1.0


@dataclass(kw_only=True, config=CONFIG)
class CriticSettings:
    """What the critics are parametrized by besides their weights."""

    # What it costs to collide, and, with the outline of the robot, to have its
    # middle so near to something that some heading would; the latter as a
    # cost of cells.
    collision_cost: Weight = 1e6
    critical_cost: Weight = 300.0

    # Whether a collision is that of the outline; else that of the disc.
    consider_footprint: StrictBool = False

    # How near to the goal, in meters, costs of cells that are not critical are
    # ignored, Goal and GoalAngle begin, PathFollow ends, and the other critics
    # of the plan and PreferForward end.
    near_goal_distance: Length = 1.0
    goal_threshold: Length = 1.4
    goal_angle_threshold: Length = 0.5
    path_follow_threshold: Length = 1.4
    path_threshold: Length = 0.5

    # PathAlign: how many points of the plan must be reached, and which part of
    # them may be blocked at most.
    path_align_offset: Points = 20
    max_path_occupancy_ratio: Annotated[StrictFloat, within(0, 1)] = 0.05

    # PathFollow and PathAngle: how many points beyond the furthest that is
    # reached they look; and the turn, in radians, from which PathAngle counts.
    path_follow_offset: Points = 5
    path_angle_offset: Points = 4
    max_angle_to_furthest: Annotated[StrictFloat, within(0, math.pi, "rad")] = (
        1.0
    )

    # Every how many steps Cost, PathAlign and Social look.
    cost_step: Steps = 2
    path_align_step: Steps = 4
    social_step: Steps = 4


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

    # How far ahead it looks: in so many steps of so many seconds, at least of
    # the period.
    time_steps: Annotated[Integer, Field(ge=2, le=1000)] = 56
    model_dt: Annotated[StrictFloat, within(1e-3, 1, "s")] = 0.05

    # How many rollouts there are in a cycle, and how often it improves.
    batch_size: Annotated[Integer, Field(ge=1, le=100_000)] = 1000
    iteration_count: Annotated[Integer, Field(ge=1, le=100)] = 1

    # The largest speeds forwards and backwards, in m/s, and the turn rate, in
    # rad/s. What the robot can do limits them, too.
    max_vel_x: PositiveSpeed = 0.6
    max_reverse_vel_x: Speed = 0.35
    max_vel_theta: TurnRate = 1.9

    # How fast they change at most, in m/s^2 and rad/s^2; as above.
    max_acc_x: Acceleration = 3.0
    max_acc_theta: TurnAcceleration = 3.5

    # The standard deviations of the noise, in m/s and rad/s; its seed; and
    # whether each cycle has its own.
    vx_std: Deviation = 0.2
    wz_std: Deviation = 0.4
    noise_seed: Annotated[Integer, Field(ge=0, lt=2**63)] = 0
    regenerate_noises: StrictBool = True

    # How much worse a rollout must be to count less by a factor of e, and how
    # much it costs to leave the last controls.
    temperature: Annotated[StrictFloat, within(1e-6, 1e6)] = 0.3
    gamma: Annotated[StrictFloat, within(0, 1e3)] = 0.015

    # How far the local plan goes, and the distance of its points, in meters.
    prune_distance: PositiveLength = 1.9
    path_spacing: Annotated[StrictFloat, within(1e-3, 1, "m")] = 0.05

    weights: CriticWeights = field(default_factory=CriticWeights)
    critics: CriticSettings = field(default_factory=CriticSettings)

    # The social forces of the critic Social.
    social_force: SocialForceParameters = field(
        default_factory=SocialForceParameters
    )

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
