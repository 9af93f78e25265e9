"""DWB: the local planner of Nav2 that rolls out and scores velocities."""

from dataclasses import field
import math
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import (
    AfterValidator,
    Field,
    StrictBool,
    StrictFloat,
    ValidationInfo,
)
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import OMEGA, YAW
from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.poses import wrap_angle
from hunav_drake.systems.common.schema import (
    CONFIG,
    Integer,
    Length,
    PositiveLength,
    PositiveSpeed,
    Speed,
    fault,
    within,
)
from hunav_drake.systems.planning.costmap.costmap_config import Period
from hunav_drake.systems.planning.dwb.dwb_memory import DwbMemory, Trend
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
from hunav_drake.systems.world.maps.costs import Costmap

if TYPE_CHECKING:
    from hunav_drake.systems.planning.dwb.scoring import Parameters

# Slower measured speeds, in m/s, and turn rates, in rad/s, count as none.
_STILL = 0.001

# As many speeds are tried at most for the sake of a small goal.
_MOST_SPEEDS = 100

# Why there is no command, by what stands for the best sample.
_FAULTS = {
    -1: "each way ahead leads into something",
    -2: "the plan is nowhere on the local map",
}


Scale = Annotated[StrictFloat, within(0, 1e6)]
Fall = Annotated[StrictFloat, within(-100, -1e-6, "m/s^2")]
TurnFall = Annotated[StrictFloat, within(-1000, -1e-6, "rad/s^2")]
Samples = Annotated[Integer, Field(ge=2, le=1000)]

_MOST_VELOCITIES = 40_000


def _check_samples(turns: int, info: ValidationInfo) -> int:
    speeds = info.data.get("vx_samples", 0)
    if speeds * turns > _MOST_VELOCITIES:
        raise fault(
            f"must be at most {_MOST_VELOCITIES // speeds} with vx_samples"
            f" {speeds}, for {_MOST_VELOCITIES} velocities, got {turns}"
        )
    return turns


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class CriticScales:
    """How much each critic counts; 0 leaves it out."""

    rotate_to_goal: Scale = 32.0
    """How much counts to turn on the spot to the goal's heading, once there."""

    oscillation: Scale = 1.0
    """How much counts not to drive forth and back."""

    base_obstacle: Scale = 0.02
    """How much counts the cost of the middle of the robot."""

    obstacle_footprint: Scale = 0.0
    """How much counts the cost of the robot's outline."""

    goal_align: Scale = 24.0
    """How much counts to bring a point ahead of the robot towards the end of
    the local plan."""

    path_align: Scale = 32.0
    """How much counts to bring a point ahead of the robot onto the plan."""

    path_dist: Scale = 32.0
    """How much counts to bring the middle of the robot onto the plan."""

    goal_dist: Scale = 24.0
    """How much counts to bring the middle of the robot towards the end of the
    local plan."""

    prefer_forward: Scale = 0.0
    """How much counts to drive forwards."""

    twirling: Scale = 0.0
    """How much counts to drive straight on."""


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class CriticParameters:
    """What the critics are parametrized by besides their scales."""

    forward_point_distance: Length = 0.1
    """How far ahead of the robot the point of both Align critics is, in meters.
    """

    sum_scores: StrictBool = False
    """Whether costs along the way add up; else that of its end counts."""

    trans_stopped_velocity: Speed = 0.25
    """RotateToGoal: below which speed the robot turns, in m/s."""

    slowing_factor: Scale = 5.0
    """RotateToGoal: how much speed costs before the robot turns."""

    lookahead_time: Annotated[StrictFloat, within(-1, 60, "s")] = -1.0
    """RotateToGoal: how far ahead the heading is looked at, in seconds; -1 for
    the end of the way."""

    oscillation_reset_dist: PositiveLength = 0.05
    """Oscillation: after how far a direction is allowed again, in meters."""

    oscillation_reset_angle: Annotated[
        StrictFloat, within(0, math.pi, "rad", low_open=True)
    ] = 0.2
    """Oscillation: after what turn a direction is allowed again, in radians."""

    oscillation_reset_time: Annotated[StrictFloat, within(-1, 60, "s")] = -1.0
    """Oscillation: after what time a direction is allowed again, in seconds; -1
    for never."""

    x_only_threshold: Speed = 0.05
    """Oscillation: the speed up to which the turn rate is looked at, in m/s."""

    penalty: Scale = 1.0
    """PreferForward: what it costs to drive back, or slower than `strafe_x`
    with less turn than `strafe_theta`."""

    strafe_x: Speed = 0.1
    """PreferForward: the speed below which the penalty counts, in m/s."""

    strafe_theta: Annotated[StrictFloat, within(0, 100, "rad/s")] = 0.2
    """PreferForward: the turn rate below which the penalty counts, in rad/s."""

    theta_scale: Scale = 10.0
    """PreferForward: what the turn rate is multiplied by, where the penalty
    does not count."""


class Dynamics(NamedTuple):
    """What follows from the parameters and the task.

    Attributes:
        p: By name.
        values: As one array, which kernels read.
    """

    p: "Parameters"
    values: Array


class Weighed(NamedTuple):
    """What `weigh_samples` gives, and what the critics remember."""

    best: int
    vs: Array
    ws: Array
    scores: Array
    memory: DwbMemory


class Candidates(NamedTuple):
    """All that DWB has weighed in one cycle, for those who look at it.

    Attributes:
        velocities: Shape (n, 2), rows (v, omega), in m/s and rad/s.
        scores: Shape (n, 11): the total and the scaled scores of the critics,
            `Critic` in their order; infinite where a critic forbids it.
        best: The row of the one taken; -1 if all are forbidden.
        paths: What is predicted for each, shape (k, 3), rows (x, y, yaw).
    """

    velocities: Array
    scores: Array
    best: int
    paths: list[Array]


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

    min_vel_x: Annotated[StrictFloat, within(-10, 10, "m/s")] = 0.0
    """The least speed, in m/s; below 0 it may drive backwards."""

    max_vel_x: PositiveSpeed = 1.0
    """The largest speed, in m/s. What the robot can do limits it, too."""

    max_vel_theta: TurnRate | None = None
    """The largest turn rate, in rad/s; limited as above, and by default as the
    profile has it."""

    min_speed_xy: Speed = 0.0
    """The speed below which a sample must turn at least with `min_speed_theta`,
    in m/s."""

    min_speed_theta: Annotated[StrictFloat, within(0, 100, "rad/s")] = 0.0
    """The turn rate below which a sample must drive at least with
    `min_speed_xy`, in rad/s."""

    acc_lim_x: Acceleration | None = None
    """How fast the speed grows, in m/s^2; by default as the profile has it."""

    decel_lim_x: Fall | None = None
    """How fast the speed falls, in m/s^2, a negative number; by default as the
    profile has it."""

    acc_lim_theta: TurnAcceleration | None = None
    """How fast the turn rate grows, in rad/s^2; by default as the profile has
    it."""

    decel_lim_theta: TurnFall | None = None
    """How fast the turn rate falls, in rad/s^2, a negative number; by default
    as the profile has it."""

    vx_samples: Samples = 20
    """How many speeds are tried; more, up to 100, where the goal is smaller
    than the distance between two places that they lead to."""

    vtheta_samples: Annotated[Samples, AfterValidator(_check_samples)] = 20
    """How many turn rates are tried: with each speed, so that at most 40 000
    velocities are."""

    sim_time: Period = 1.7
    """How far ahead the robot is predicted, in seconds."""

    linear_granularity: Annotated[StrictFloat, within(0.001, 1e5, "m")] = 0.05
    """The longest step of the prediction, in meters."""

    angular_granularity: Annotated[
        StrictFloat, within(0.001, math.pi, "rad")
    ] = 0.025
    """The largest turn in a step of the prediction, in radians."""

    time_granularity: Annotated[StrictFloat, within(0.001, 60, "s")] | None = (
        None
    )
    """The step of the prediction, in seconds, instead of the two above."""

    trajectory_generator: Literal["standard", "limited_accel"] = "standard"
    """What is sampled: "standard", what is reached within `sim_time`, while the
    prediction accelerates; "limited_accel", what is reached within one cycle,
    and then held."""

    limit_vel_cmd_in_traj: StrictBool = False
    """Whether the command is the first velocity of the prediction, not the one
    that it comes to."""

    prune_distance: PositiveLength | None = None
    """The local plan begins at the first pose nearer to the robot than this, in
    meters; by default as the profile has it."""

    forward_prune_distance: PositiveLength | None = None
    """The local plan ends at the last pose no farther from the robot than this,
    in meters; by default as the profile has it."""

    shorten_transformed_plan: StrictBool = True
    """Whether the local plan ends there; else where the local map does."""

    scales: CriticScales = field(default_factory=CriticScales)
    """How much each critic counts."""

    critics: CriticParameters = field(default_factory=CriticParameters)
    """What else the critics are parametrized by."""

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
        return choose(self, task, view, local, costmap, memory)


def _parameters(planner: DwbPlanner, task: PlanningTask) -> "Parameters":
    """Returns what follows from the parameters of DWB and the task."""
    from hunav_drake.systems.planning.dwb.scoring import Parameters

    profile = planner.dwb_profile
    turn = either(planner.max_vel_theta, profile.max_vel_theta)
    high = min(planner.max_vel_x, task.limits.max_speed)
    low = max(min(planner.min_vel_x, high), -task.limits.max_reverse_speed)
    # Their ways must end close enough together for one to end at the goal.
    apart = (high - low) * planner.sim_time / task.goal_tolerance
    speeds = max(planner.vx_samples, min(math.ceil(apart) + 1, _MOST_SPEEDS))
    at_once = planner.trajectory_generator == "limited_accel"
    values = {
        **vars(planner),
        **vars(planner.critics),
        **vars(planner.scales),
        "low": low,
        "high": high,
        "turn": min(turn, task.limits.max_turn_rate),
        "reach_time": planner.period if at_once else planner.sim_time,
        "speeds": speeds,
        "turns": planner.vtheta_samples,
        "at_once": at_once,
        "time_granularity": either(planner.time_granularity, 0.0),
    }
    for name in (
        "acc_lim_x",
        "decel_lim_x",
        "acc_lim_theta",
        "decel_lim_theta",
    ):
        values[name] = either(values[name], getattr(profile, name))
    return Parameters(*(float(values[name]) for name in Parameters._fields))


def dynamics(planner: DwbPlanner, task: PlanningTask) -> Dynamics:
    """Returns what follows from the parameters of DWB and the task, once."""

    def make() -> Dynamics:
        p = _parameters(planner, task)
        values = np.array(p)
        values.setflags(write=False)
        return Dynamics(p, values)

    return planner.once(task, "dwb", make)


def choose(
    planner: DwbPlanner,
    task: PlanningTask,
    view: View,
    local: LocalPlan,
    costmap: Costmap,
    memory: DwbMemory,
) -> Control:
    """Returns the command of one cycle: see `DwbPlanner.control`."""
    weighed = _weigh(planner, task, view, local, costmap, memory)
    best, memory = weighed.best, weighed.memory
    if best < 0:
        return Control(0.0, 0.0, memory, _FAULTS[best])
    turns = len(weighed.ws)
    v, omega = float(weighed.vs[best // turns]), float(weighed.ws[best % turns])
    critics = planner.critics
    x, y, yaw = view.robot[: YAW + 1].tolist()
    trend = memory.x.after(v), memory.theta
    if abs(v) <= critics.x_only_threshold:
        trend = trend[0], memory.theta.after(omega)
    # A change of sign, which forbids the other one.
    changed = any(
        new.sign == -old.sign != 0
        for new, old in zip(trend, (memory.x, memory.theta), strict=True)
    )
    memory = memory._replace(
        x=trend[0], theta=trend[1], cycles=memory.cycles + 1
    )
    if changed:
        memory = memory._replace(pose=(x, y, yaw), cycles=0)
    moved = math.hypot(x - memory.pose[0], y - memory.pose[1])
    turned = abs(wrap_angle(yaw - memory.pose[2]))
    waited = memory.cycles * planner.period
    if (memory.x.only or memory.theta.only) and (
        moved > critics.oscillation_reset_dist
        or turned > critics.oscillation_reset_angle
        or 0 <= critics.oscillation_reset_time <= waited
    ):
        memory = memory._replace(x=Trend(), theta=Trend())
    if planner.limit_vel_cmd_in_traj:
        v, omega = _first_velocity(planner, task, view, v, omega)
    return Control(v, omega, memory)


def candidates(
    planner: DwbPlanner,
    task: PlanningTask,
    view: View,
    local: LocalPlan,
    costmap: Costmap,
    memory: DwbMemory | None = None,
) -> Candidates:
    """Returns all that DWB weighs in a cycle: velocities, scores, and ways.

    Args:
        planner: The parameters.
        task: What does not change.
        view: What the planner sees.
        local: What is to be followed.
        costmap: The local map.
        memory: What the critics remember; by default nothing.

    Raises:
        ValueError: If the plan is nowhere on the map.
    """
    from hunav_drake.systems.planning.dwb.scoring import roll_out

    weighed = _weigh(planner, task, view, local, costmap, memory or DwbMemory())
    best, vs, ws, scores, _ = weighed
    if best == -2:
        raise ValueError(f"there is nothing to weigh: {_FAULTS[best]}")
    velocities = np.column_stack([np.repeat(vs, len(ws)), np.tile(ws, len(vs))])
    state, values = robot_state(view), dynamics(planner, task).values
    paths = [roll_out(state, v, w, values) for v, w in velocities]
    return Candidates(velocities, scores, best, paths)


def robot_state(view: View) -> Array:
    """Returns (x, y, yaw, v, omega) of the robot as DWB takes it."""
    x, y, yaw, vx, vy, omega = view.robot[: OMEGA + 1].tolist()
    v = vx * math.cos(yaw) + vy * math.sin(yaw)
    return np.array(
        [
            *(x, y, yaw),
            v if abs(v) >= _STILL else 0.0,
            omega if abs(omega) >= _STILL else 0.0,
        ]
    )


def _weigh(
    planner: DwbPlanner,
    task: PlanningTask,
    view: View,
    local: LocalPlan,
    costmap: Costmap,
    memory: DwbMemory,
) -> Weighed:
    """Returns what is weighed in one cycle."""
    # Reading a scenario does without numba.
    from hunav_drake.systems.planning.dwb.weighing import weigh_samples

    if local.is_new:
        memory = DwbMemory()
    state = robot_state(view)
    x, y, _, v, _ = state.tolist()
    to_goal = math.hypot(local.goal[0] - x, local.goal[1] - y)
    in_window = memory.in_window or to_goal < task.goal_tolerance
    rotating = memory.rotating or (
        in_window and abs(v) <= planner.critics.trans_stopped_velocity
    )
    memory = memory._replace(in_window=in_window, rotating=rotating)

    best, vs, ws, scores = weigh_samples(
        *(state, np.array(local.goal), local.poses),
        *(costmap.costs, *costmap.origin, costmap.resolution),
        np.array(
            [
                float(in_window) + float(rotating),
                float(memory.x.only),
                float(memory.theta.only),
            ]
        ),
        *(planner.setup(task).footprint, dynamics(planner, task).values),
    )
    return Weighed(best, vs, ws, scores, memory)


def _first_velocity(
    planner: DwbPlanner, task: PlanningTask, view: View, v: float, w: float
) -> tuple[float, float]:
    """Returns the velocity of the first step of a prediction."""
    from hunav_drake.systems.planning.dwb.scoring import steps_of, toward

    p = dynamics(planner, task).p
    if p.at_once:
        return v, w
    now = robot_state(view)
    dt = p.sim_time / steps_of(v, w, p)
    return (
        toward(now[3], p.acc_lim_x, p.decel_lim_x, dt, v),
        toward(now[4], p.acc_lim_theta, p.decel_lim_theta, dt, w),
    )
