"""MPPI: Nav2's local planner, which samples and averages controls."""

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

FAULT = "no velocity is free of collision"

# The number of attempts in a cycle; each takes its own noise.
_TRIES = 2


# The goal tolerance that the weights are meant for, in meters, and the yaw
# tolerance that allows any heading, in radians.
_USUAL_TOLERANCE = 0.25
_ANY_HEADING = 3.14

Weight = Annotated[StrictFloat, within(0, 1e9)]
Deviation = Annotated[StrictFloat, within(1e-6, 100)]
Steps = Annotated[Integer, Field(ge=1, le=1000)]
Points = Annotated[Integer, Field(ge=0, le=10_000)]


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class CriticWeights:
    """Weights of the critics; 0 turns a critic off."""

    constraint: Weight = 4.0
    """Weight of the Constraint critic: velocities beyond their bounds."""

    cost: Weight = 3.81
    """Weight of the Cost critic: costs of the local costmap."""

    goal: Weight = 5.0
    """Weight of the Goal critic: distance from the goal, when near it. A
    `goal_tolerance` below 0.25 m increases it in inverse proportion."""

    goal_angle: Weight = 3.0
    """Weight of the GoalAngle critic: angle to the goal's heading, when near
    it. It is 0 where `goal_yaw_tolerance` allows any heading."""

    path_align: Weight = 14.0
    """Weight of the PathAlign critic: distance from the global plan."""

    path_follow: Weight = 5.0
    """Weight of the PathFollow critic: progress along the global plan."""

    path_angle: Weight = 2.0
    """Weight of the PathAngle critic: angle to the global plan."""

    prefer_forward: Weight = 5.0
    """Weight of the PreferForward critic: distance driven backwards."""

    social: Weight = 1.0
    """Weight of the Social critic: social forces between the robot and people.
    0 gives Nav2's MPPI."""


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class CriticSettings:
    """Parameters of the critics besides their weights."""

    collision_cost: Weight = 1e6
    """Cost of a collision."""

    critical_cost: Weight = 300.0
    """With `consider_footprint`: cost of a robot center so near to an obstacle
    that the robot would collide with it at some heading, on the scale of cell
    costs."""

    consider_footprint: StrictBool = False
    """Whether collisions are checked with the robot's footprint; otherwise with
    its disc."""

    near_goal_distance: Length = 1.0
    """Distance from the goal below which non-critical costs are ignored, in
    meters."""

    goal_threshold: Length = 1.4
    """Goal: distance from the goal below which it counts, in meters."""

    goal_angle_threshold: Length = 0.5
    """GoalAngle: distance from the goal below which it counts, in meters; at
    most `goal_tolerance`, if that is below 0.25 m."""

    path_follow_threshold: Length = 1.4
    """PathFollow: distance from the goal below which it does not count, in
    meters."""

    path_threshold: Length = 0.5
    """PathAlign, PathAngle, PreferForward: distance from the goal below which
    they do not count, in meters."""

    path_align_offset: Points = 20
    """PathAlign: number of path points that must be reached for it to count."""

    max_path_occupancy_ratio: Annotated[StrictFloat, within(0, 1)] = 0.05
    """PathAlign: maximum fraction of these points that may be blocked for it to
    count."""

    path_follow_offset: Points = 5
    """PathFollow: number of path points from the furthest reached to the
    target."""

    path_angle_offset: Points = 4
    """PathAngle: number of path points from the furthest reached to the target.
    """

    max_angle_to_furthest: Annotated[StrictFloat, within(0, math.pi, "rad")] = (
        1.0
    )
    """PathAngle: angle to the target above which it counts, in radians."""

    cost_step: Steps = 2
    """Cost: stride in steps of a rollout at which it is evaluated."""

    path_align_step: Steps = 4
    """PathAlign: stride in steps of a rollout at which it is evaluated."""

    social_step: Steps = 4
    """Social: stride in steps of a rollout at which it is evaluated."""


class Setting(NamedTuple):
    """Values derived from the parameters and the task.

    `p` are the parameters, also as an array for kernels: `values`. `weights`,
    shape (11,), are those of the critics, by `Critic`; `forces` those of the
    social force. A rollout has `steps` steps, for `hold` of which a command
    holds; the controls shift by as many per cycle. 0 is for steps longer than a
    cycle, where they do not shift.
    """

    p: Parameters
    values: Array
    weights: Array
    forces: Array
    steps: int
    hold: int


class Rollouts(NamedTuple):
    """All rollouts of one iteration of MPPI.

    Attributes:
        alive: The number of collision-free rollouts.
        controls: Shape (steps, 2): the average, rows (v, omega).
        scores: Shape (batch_size, 11): the total, the weighted scores of the
            critics in the order of `Critic`, and the deviation from the last
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
    """Samples controls around the last ones and averages them by their scores.

    Model predictive path integral control (Williams et al. 2017): in each cycle
    it adds noise to the controls of the next seconds, `batch_size` times,
    predicts the trajectory of each, and takes the mean weighted by critic
    scores. The parameters are those of nav2_mppi_controller; one critic is
    added, for the social forces between robot and people.

    The noise depends on `noise_seed` and the number of the cycle.
    """

    initial_control: ClassVar[Any] = MppiMemory()

    time_steps: Annotated[Integer, Field(ge=2, le=1000)] = 56
    """Number of prediction steps of `model_dt`: with 0.05 s, a horizon of 2.8 s
    for any period of the planner."""

    model_dt: Annotated[StrictFloat, within(1e-3, 1, "s")] = 0.05
    """Duration of a prediction step, in seconds. Where a command holds for
    longer, steps are shortened so that it holds for a whole number of them, but
    never below a step of the trial."""

    batch_size: Annotated[Integer, Field(ge=1, le=100_000)] = 1000
    """Number of rollouts per iteration."""

    iteration_count: Annotated[Integer, Field(ge=1, le=100)] = 1
    """Number of iterations per cycle, each with new rollouts."""

    max_vel_x: PositiveSpeed = 0.6
    """Maximum forward speed, in m/s. The robot's own limit holds, too."""

    max_reverse_vel_x: Speed = 0.35
    """Maximum backward speed, in m/s. The robot's own limit holds, too."""

    max_vel_theta: TurnRate = 1.9
    """Maximum turn rate, in rad/s. The robot's own limit holds, too."""

    max_acc_x: Acceleration = 3.0
    """Maximum linear acceleration, in m/s^2. The robot's own limit holds, too.
    """

    max_acc_theta: TurnAcceleration = 3.5
    """Maximum angular acceleration, in rad/s^2. The robot's own limit holds,
    too."""

    vx_std: Deviation = 0.2
    """Standard deviation of the noise of speeds, in m/s."""

    wz_std: Deviation = 0.4
    """Standard deviation of the noise of turn rates, in rad/s."""

    noise_seed: Annotated[Integer, Field(ge=0, lt=2**63)] = 0
    """Seed of the noise."""

    regenerate_noises: StrictBool = True
    """Whether each cycle draws new noise; otherwise all use the same."""

    temperature: Annotated[StrictFloat, within(1e-6, 1e6)] = 0.3
    """Score difference that lowers the weight of a rollout by a factor e."""

    gamma: Annotated[StrictFloat, within(0, 1e3)] = 0.015
    """Weight of the deviation from the last controls."""

    prune_distance: PositiveLength = 1.9
    """Length of the local plan, in meters."""

    path_spacing: Annotated[StrictFloat, within(1e-3, 1, "m")] = 0.05
    """Distance between points of the local plan, in meters."""

    weights: CriticWeights = field(default_factory=CriticWeights)
    """Weights of the critics."""

    critics: CriticSettings = field(default_factory=CriticSettings)
    """Other parameters of the critics."""

    social_force: SocialForceParameters = field(
        default_factory=SocialForceParameters
    )
    """Parameters of the social forces in the Social critic."""

    def local_span(
        self, task: PlanningTask, view: View, poses: Array, first: int
    ) -> tuple[int, int]:
        """Returns which poses are local: see `NavigationPlanner.local_span`.

        They range from the nearest one over a path length of `prune_distance`.
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
        made = self.once(task, "mppi", lambda: setting(self, task))
        number = 0
        for attempt in range(_TRIES):
            tried = memory
            if attempt > 0:
                # The old controls may be what leads to a collision.
                tried = MppiMemory(cycle=memory.cycle)
            alive = 0
            for _ in range(self.iteration_count):
                if self.regenerate_noises:
                    per_cycle = _TRIES * self.iteration_count
                    number = memory.cycle * per_cycle + number % per_cycle
                result = roll_out_all(
                    self, task, view, local, costmap, tried, number
                )
                number += 1
                # (They are not finite only for a Context with invalid values.)
                is_finite = np.isfinite(result.controls).all()
                alive = result.alive if is_finite else 0
                tried = tried._replace(controls=result.controls)
            if alive > 0:
                return _command(tried, made)
        return Control(0.0, 0.0, memory, FAULT)


def setting(planner: MppiPlanner, task: PlanningTask) -> Setting:
    """Returns the values derived from the parameters and the task."""
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
    # The goal critics must not balance before the goal is reached, as where the
    # robot stands beside it with the right heading.
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
    """Returns standard normal noise for a seed and a draw, read-only.

    The seed is in [0, 2^63); the shape is (batch, steps, 2).
    """
    bits = np.random.Philox(key=[seed, number])
    noise = np.random.Generator(bits).standard_normal((batch, steps, 2))
    noise.setflags(write=False)
    return noise


def even_path(poses: Array, spacing: float) -> Array:
    """Returns evenly spaced points along a plan, shape (k, 2), k > 0.

    The last point is the end of the plan, or less than half the spacing before
    it. In meters.
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
    """Returns all rollouts of one iteration, for inspection, too.

    `number` is that of the noise draw.
    """
    # Imported here, so that reading a scenario does not load numba.
    from hunav_drake.systems.planning.mppi.improving import improve

    made = planner.once(task, "mppi", lambda: setting(planner, task))
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


def _command(memory: MppiMemory, made: Setting) -> Control:
    """Returns the command at the start of new controls, with the new memory."""
    controls, hold = memory.controls, made.hold
    # The first control is the last command.
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
