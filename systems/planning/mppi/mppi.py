"""MPPI: the local planner of Nav2 that samples and averages controls."""

from dataclasses import astuple, field
import functools
import math
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import Field, StrictBool, StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import count_steps
from hunav_drake.systems.common.layout import OMEGA
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
from hunav_drake.systems.planning.mppi.parameters import (
    NUM_SCORES,
    Critic,
    Parameters,
)
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

FAULT = "each way ahead leads into something"

# Of a cycle, one after the other: draws of the improvements, and of the second
# try.
_TRIES = 2


# The distance within which the goal counts as reached that weights are meant
# for, in meters; and a turn that leaves any heading, in radians.
_USUAL_TOLERANCE = 0.25
_ANY_HEADING = 3.14

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


class Setting(NamedTuple):
    """What follows from the parameters of MPPI and the task.

    Attributes:
        p: The parameters, by name.
        values: As one array, which kernels read.
        weights: Shape (11,): those of the critics, by `Critic`.
        forces: Those of the social force.
        steps: How many steps a rollout has.
        hold: For how many of them a command holds: the controls move on by
            as many in a cycle. 0 for steps longer than a cycle, in which they
            stay where they are.
    """

    p: Parameters
    values: Array
    weights: Array
    forces: Array
    steps: int
    hold: int


class Rollouts(NamedTuple):
    """All that MPPI has weighed in one improvement.

    Attributes:
        alive: How many of them do not collide.
        controls: Shape (steps, 2): the average, rows (v, omega).
        scores: Shape (batch_size, 11): the total, the scaled scores of the
            critics, `Critic` in their order, and how far they leave the last
            controls.
        poses: Shape (batch_size, steps, 3), rows (x, y, yaw).
    """

    alive: int
    controls: Array
    scores: Array
    poses: Array


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
        return optimize(self, task, view, local, costmap, memory)


def setting(planner: MppiPlanner, task: PlanningTask) -> Setting:
    """Returns what follows from the parameters of MPPI and the task."""
    limits, critics = task.limits, planner.critics
    dt, hold = planner.model_dt, 0
    if planner.period > dt * (1 - 1e-9):
        hold = min(
            math.ceil(planner.period / dt - 1e-9),
            count_steps(planner.period, task.time_step),
        )
        dt = planner.period / hold
    steps = max(2, round(planner.time_steps * planner.model_dt / dt))
    values = {
        **vars(planner),
        **vars(critics),
        "dt": dt,
        "min_v": -min(planner.max_reverse_vel_x, limits.max_reverse_speed),
        "max_v": min(planner.max_vel_x, limits.max_speed),
        "max_turn": min(planner.max_vel_theta, limits.max_turn_rate),
        "acc_v": min(planner.max_acc_x, limits.max_acceleration),
        "acc_turn": min(planner.max_acc_theta, limits.max_turn_acceleration),
        "std_v": planner.vx_std,
        "std_turn": planner.wz_std,
        "hold": hold,
    }
    weights = np.zeros(NUM_SCORES)
    for name, weight in vars(planner.weights).items():
        weights[Critic[name.upper()]] = weight
    # The critics of the goal must not balance each other before it is reached,
    # as where the robot stands beside it, with the right heading.
    if task.goal_tolerance < _USUAL_TOLERANCE:
        weights[Critic.GOAL] *= _USUAL_TOLERANCE / task.goal_tolerance
        values["goal_angle_threshold"] = min(
            task.goal_tolerance, critics.goal_angle_threshold
        )
    if task.goal_yaw_tolerance >= _ANY_HEADING:
        weights[Critic.GOAL_ANGLE] = 0.0
    p = Parameters(*(float(values[name]) for name in Parameters._fields))
    arrays = np.array(p), weights, np.array(astuple(planner.social_force))
    for array in arrays:
        array.setflags(write=False)
    return Setting(p, *arrays, steps, hold)


@functools.lru_cache(maxsize=2)
def draw_noise(seed: int, number: int, batch: int, steps: int) -> Array:
    """Returns standard normal noise that follows from a seed and a number.

    Args:
        seed: In [0, 2^63).
        number: Which draw it is.
        batch: How many rollouts there are.
        steps: How many steps each has.

    Returns:
        Shape (batch, steps, 2), read-only.
    """
    bits = np.random.Philox(key=[seed, number])
    noise = np.random.Generator(bits).standard_normal((batch, steps, 2))
    noise.setflags(write=False)
    return noise


def even_path(poses: Array, spacing: float) -> Array:
    """Returns points at equal distances along a plan, shape (k, 2), k > 0.

    Args:
        poses: Shape (j, 3), j > 0, rows (x, y, yaw).
        spacing: The distance, in meters. The last point is the plan's end, if
            that is not another half of it away.
    """
    steps = np.diff(poses[:, :2], axis=0)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*steps.T))])
    count = int(way[-1] / spacing + 0.5)
    along = np.minimum(spacing * np.arange(count + 1), way[-1])
    return np.column_stack(
        [np.interp(along, way, poses[:, c]) for c in range(2)]
    )


def robot_state(view: View) -> Array:
    """Returns (x, y, yaw, v, omega) of the robot; v is along its heading."""
    x, y, yaw, vx, vy, omega = view.robot[: OMEGA + 1].tolist()
    v = vx * math.cos(yaw) + vy * math.sin(yaw)
    return np.array([x, y, yaw, v, omega])


def roll_out_all(
    planner: MppiPlanner,
    task: PlanningTask,
    view: View,
    local: LocalPlan,
    costmap: Costmap,
    memory: MppiMemory,
    number: int = 0,
) -> Rollouts:
    """Returns what MPPI weighs in one improvement, for those who look at it.

    Args:
        planner: The parameters.
        task: What does not change.
        view: What the planner sees.
        local: What is to be followed.
        costmap: The local map.
        memory: What it remembers.
        number: Which draw of noise it takes.
    """
    # Reading a scenario does without numba.
    from hunav_drake.systems.planning.mppi.improving import improve

    made = _setting(planner, task)
    controls = memory.controls
    if len(controls) != made.steps:
        controls = np.zeros((made.steps, 2))
    noise = draw_noise(
        planner.noise_seed, number, planner.batch_size, made.steps
    )
    result = improve(
        *(robot_state(view), controls, memory.past, noise),
        np.array(local.goal),
        even_path(local.poses, planner.path_spacing),
        planner.path_spacing,
        *(costmap.costs, *costmap.origin, costmap.resolution),
        *(planner.setup(task).footprint, view.humans, made.forces),
        *(made.weights, made.values),
    )
    return Rollouts(*result)


def optimize(
    planner: MppiPlanner,
    task: PlanningTask,
    view: View,
    local: LocalPlan,
    costmap: Costmap,
    memory: MppiMemory,
) -> Control:
    """Returns the command of one cycle: see `MppiPlanner.control`."""
    made = _setting(planner, task)
    number = 0
    for attempt in range(_TRIES):
        tried = memory
        if attempt > 0:
            # It may be the old controls that lead into something.
            tried = MppiMemory(cycle=memory.cycle)
        alive = 0
        for _ in range(planner.iteration_count):
            if planner.regenerate_noises:
                per_cycle = _TRIES * planner.iteration_count
                number = memory.cycle * per_cycle + number % per_cycle
            result = roll_out_all(
                planner, task, view, local, costmap, tried, number
            )
            number += 1
            # (Controls that are not finite follow from a Context made up.)
            alive = result.alive if np.isfinite(result.controls).all() else 0
            tried = tried._replace(controls=result.controls)
        if alive > 0:
            return _command(tried, made)
    return Control(0.0, 0.0, memory, FAULT)


def _command(memory: MppiMemory, made: Setting) -> Control:
    """Returns the command that new controls begin with, and what is kept."""
    controls, hold = memory.controls, made.hold
    # The first control is that of the last command.
    place = min(hold, 1)
    v = min(max(controls[place, 0], made.p.min_v), made.p.max_v)
    most = made.p.max_turn
    omega = min(max(controls[place, 1], -most), most)
    passed = controls[: max(hold, 1)]
    past = np.vstack([memory.past, passed])[-len(memory.past) :]
    if hold:
        rest = np.repeat(controls[-1:], min(hold, len(controls)), axis=0)
        controls = np.vstack([controls[hold:], rest])
    for array in (past, controls):
        array.setflags(write=False)
    memory = MppiMemory(controls, past, memory.cycle + 1)
    return Control(float(v), float(omega), memory)


def _setting(planner: MppiPlanner, task: PlanningTask) -> Setting:
    return planner.once(task, "mppi", lambda: setting(planner, task))
