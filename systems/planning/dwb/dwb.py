"""DWB: Nav2's local planner, which rolls out and scores velocities."""

from dataclasses import field
import math
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Literal,
    NamedTuple,
    Self,
)

import numpy as np
from pydantic import (
    AfterValidator,
    Field,
    StrictBool,
    StrictFloat,
    ValidationInfo,
    model_validator,
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
    check_order,
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

# Measured speeds (m/s) and turn rates (rad/s) below this count as 0.
_STILL = 0.001

# The maximum number of speeds that a small goal tolerance asks for.
_MOST_SPEEDS = 100

# Why there is no command, by the number that replaces the best sample.
_FAULTS = {
    -1: "no velocity is free of collision",
    -2: "no part of the plan is on the local map",
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
    """Weights of the critics; 0 turns a critic off."""

    rotate_to_goal: Scale = 32.0
    """Weight of RotateToGoal: turning in place to the goal's heading, once
    there."""

    oscillation: Scale = 1.0
    """Weight of the Oscillation critic."""

    base_obstacle: Scale = 0.02
    """Weight of BaseObstacle: the cost at the robot's center."""

    obstacle_footprint: Scale = 0.0
    """Weight of ObstacleFootprint: the cost on the robot's footprint."""

    goal_align: Scale = 24.0
    """Weight of GoalAlign: the distance of a point ahead of the robot from the
    end of the local plan."""

    path_align: Scale = 32.0
    """Weight of PathAlign: the distance of a point ahead of the robot from the
    plan."""

    path_dist: Scale = 32.0
    """Weight of PathDist: the distance of the robot's center from the plan."""

    goal_dist: Scale = 24.0
    """Weight of GoalDist: the distance of the robot's center from the end of
    the local plan."""

    prefer_forward: Scale = 0.0
    """Weight of the PreferForward critic."""

    twirling: Scale = 0.0
    """Weight of the Twirling critic, which penalizes turn rates."""


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class CriticParameters:
    """Parameters of the critics besides their weights."""

    forward_point_distance: Length = 0.1
    """Distance of the point of GoalAlign and PathAlign ahead of the robot, in
    meters."""

    sum_scores: StrictBool = False
    """Whether costs are summed along the trajectory; otherwise the cost of its
    last pose counts."""

    trans_stopped_velocity: Speed = 0.25
    """RotateToGoal: speed below which the robot turns, in m/s."""

    slowing_factor: Scale = 5.0
    """RotateToGoal: weight of the squared speed before the robot turns."""

    lookahead_time: Annotated[StrictFloat, within(-1, 60, "s")] = -1.0
    """RotateToGoal: time ahead at which the heading is scored, in seconds; -1
    for the end of the trajectory."""

    oscillation_reset_dist: PositiveLength = 0.05
    """Oscillation: distance after which a direction is allowed again, in
    meters."""

    oscillation_reset_angle: Annotated[
        StrictFloat, within(0, math.pi, "rad", low_open=True)
    ] = 0.2
    """Oscillation: turn after which a direction is allowed again, in radians.
    """

    oscillation_reset_time: Annotated[StrictFloat, within(-1, 60, "s")] = -1.0
    """Oscillation: time after which a direction is allowed again, in seconds;
    -1 for never."""

    x_only_threshold: Speed = 0.05
    """Oscillation: speed up to which the turn rate is checked, too, in m/s."""

    penalty: Scale = 1.0
    """PreferForward: cost of driving backwards, or slower than `strafe_x` with
    a turn rate below `strafe_theta`."""

    strafe_x: Speed = 0.1
    """PreferForward: speed below which the penalty counts, in m/s."""

    strafe_theta: Annotated[StrictFloat, within(0, 100, "rad/s")] = 0.2
    """PreferForward: turn rate below which the penalty counts, in rad/s."""

    theta_scale: Scale = 10.0
    """PreferForward: factor of the turn rate where the penalty does not count.
    """


class Dynamics(NamedTuple):
    """Values derived from the parameters and the task.

    Attributes:
        p: The values by name.
        values: The values as an array for kernels.
    """

    p: "Parameters"
    values: Array


class Weighed(NamedTuple):
    """The result of `weigh_samples`, and the memory of the critics."""

    best: int
    vs: Array
    ws: Array
    scores: Array
    memory: DwbMemory


class Candidates(NamedTuple):
    """All candidates of one DWB cycle, for inspection.

    Attributes:
        velocities: Shape (n, 2), rows (v, omega), in m/s and rad/s.
        scores: Shape (n, 11): the total and the weighted scores of the critics
            in the order of `Critic`; infinite where a critic rejects the
            velocity.
        best: The row of the selected velocity; -1 if all are rejected.
        paths: The predicted trajectory of each, shape (k, 3), rows (x, y, yaw).
    """

    velocities: Array
    scores: Array
    best: int
    paths: list[Array]


@register_planner("dwb")
@dataclass(kw_only=True, config=CONFIG)
class DwbPlanner(NavigationPlanner):
    """Rolls out many velocities and takes the one with the best score.

    In each cycle it samples the speeds and turn rates that the robot can reach,
    predicts the trajectory of each pair over `sim_time`, and takes the pair
    with the lowest sum of critic scores (nav2_dwb_controller). The parameters
    have the names used there.
    """

    initial_control: ClassVar[Any] = DwbMemory()

    min_vel_x: Annotated[StrictFloat, within(-10, 10, "m/s")] = 0.0
    """Minimum speed, in m/s; a negative one lets the robot drive backwards."""

    max_vel_x: PositiveSpeed = 1.0
    """Maximum speed, in m/s. The robot's own limit holds, too."""

    max_vel_theta: TurnRate | None = None
    """Maximum turn rate, in rad/s; the robot's own limit holds, too. None: the
    value of the profile."""

    min_speed_xy: Speed = 0.0
    """Speed below which a sample needs a turn rate of at least
    `min_speed_theta`, in m/s."""

    min_speed_theta: Annotated[StrictFloat, within(0, 100, "rad/s")] = 0.0
    """Turn rate below which a sample needs a speed of at least `min_speed_xy`,
    in rad/s."""

    acc_lim_x: Acceleration | None = None
    """Linear acceleration, in m/s^2. None: the value of the profile."""

    decel_lim_x: Fall | None = None
    """Linear deceleration, in m/s^2, a negative number. None: the value of the
    profile."""

    acc_lim_theta: TurnAcceleration | None = None
    """Angular acceleration, in rad/s^2. None: the value of the profile."""

    decel_lim_theta: TurnFall | None = None
    """Angular deceleration, in rad/s^2, a negative number. None: the value of
    the profile."""

    vx_samples: Samples = 20
    """Number of sampled speeds; more, up to 100, where the end points of
    neighboring samples are farther apart than the goal tolerance."""

    vtheta_samples: Annotated[Samples, AfterValidator(_check_samples)] = 20
    """Number of turn rates sampled with each speed; at most 40 000 velocities
    in total."""

    sim_time: Period = 1.7
    """Time horizon of the prediction, in seconds."""

    linear_granularity: Annotated[StrictFloat, within(0.001, 1e5, "m")] = 0.05
    """Longest step of the prediction, in meters."""

    angular_granularity: Annotated[
        StrictFloat, within(0.001, math.pi, "rad")
    ] = 0.025
    """Largest turn in a step of the prediction, in radians."""

    time_granularity: Annotated[StrictFloat, within(0.001, 60, "s")] | None = (
        None
    )
    """Time step of the prediction, in seconds, instead of `linear_granularity`
    and `angular_granularity`."""

    trajectory_generator: Literal["standard", "limited_accel"] = "standard"
    """Velocities to sample: "standard", those that can be reached within
    `sim_time`, with acceleration in the prediction; "limited_accel", those that
    can be reached within one cycle, held constant in the prediction."""

    limit_vel_cmd_in_traj: StrictBool = False
    """Whether the command is the first velocity of the prediction instead of
    the sampled one."""

    prune_distance: PositiveLength | None = None
    """Distance from the robot below which the local plan begins, in meters.
    None: the value of the profile."""

    forward_prune_distance: PositiveLength | None = None
    """Distance from the robot at which the local plan ends, in meters. None:
    the value of the profile."""

    shorten_transformed_plan: StrictBool = True
    """Whether `forward_prune_distance` ends the local plan; otherwise the edge
    of the local costmap ends it."""

    scales: CriticScales = field(default_factory=CriticScales)
    """Weights of the critics."""

    critics: CriticParameters = field(default_factory=CriticParameters)
    """Other parameters of the critics."""

    @model_validator(mode="after")
    def _check_speeds(self) -> Self:
        check_order(self, "min_vel_x", "max_vel_x")
        return self

    @property
    def dwb_profile(self) -> DwbProfile:
        """Returns the values that depend on the release of Nav2."""
        return DWB_PROFILES[self.profile]

    def local_span(
        self, task: PlanningTask, view: View, poses: Array, first: int
    ) -> tuple[int, int]:
        """Returns which poses are local: see `NavigationPlanner.local_span`.

        They range from the first pose nearer than `prune_distance` to the last
        within `forward_prune_distance`.
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
        weighed = _weigh(self, task, view, local, costmap, memory, every=False)
        best, memory = weighed.best, weighed.memory
        if best < 0:
            return Control(0.0, 0.0, memory, _FAULTS[best])
        turns = len(weighed.ws)
        v, omega = (
            float(weighed.vs[best // turns]),
            float(weighed.ws[best % turns]),
        )
        critics = self.critics
        x, y, yaw = view.robot[: YAW + 1].tolist()
        trend = memory.x.after(v), memory.theta
        if abs(v) <= critics.x_only_threshold:
            trend = trend[0], memory.theta.after(omega)
        # A change of sign forbids the opposite sign.
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
        waited = memory.cycles * self.period
        if (memory.x.only or memory.theta.only) and (
            moved > critics.oscillation_reset_dist
            or turned > critics.oscillation_reset_angle
            or 0 <= critics.oscillation_reset_time <= waited
        ):
            memory = memory._replace(x=Trend(), theta=Trend())
        if self.limit_vel_cmd_in_traj:
            v, omega = _first_velocity(self, task, view, v, omega)
        return Control(v, omega, memory)


def _parameters(planner: DwbPlanner, task: PlanningTask) -> "Parameters":
    """Returns the values derived from the parameters and the task."""
    from hunav_drake.systems.planning.dwb.scoring import Parameters

    profile = planner.dwb_profile
    turn = either(planner.max_vel_theta, profile.max_vel_theta)
    high = min(planner.max_vel_x, task.limits.max_speed)
    low = max(min(planner.min_vel_x, high), -task.limits.max_reverse_speed)
    # The trajectories must end close enough together for one to end at the
    # goal.
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
    """Returns the values derived from the parameters and the task, cached."""

    def make() -> Dynamics:
        p = _parameters(planner, task)
        values = np.array(p)
        values.setflags(write=False)
        return Dynamics(p, values)

    return planner.once(task, "dwb", make)


def candidates(
    planner: DwbPlanner,
    task: PlanningTask,
    view: View,
    local: LocalPlan,
    costmap: Costmap,
    memory: DwbMemory | None = None,
) -> Candidates:
    """Returns the velocities, scores and trajectories of one cycle.

    Without `memory`, the critics have an empty one.

    Raises:
        ValueError: If no part of the plan is on the map.
    """
    from hunav_drake.systems.planning.dwb.scoring import roll_out

    memory = memory or DwbMemory()
    weighed = _weigh(planner, task, view, local, costmap, memory, every=True)
    best, vs, ws, scores, _ = weighed
    if best == -2:
        raise ValueError(f"there are no candidates: {_FAULTS[best]}")
    velocities = np.column_stack([np.repeat(vs, len(ws)), np.tile(ws, len(vs))])
    state, values = robot_state(view), dynamics(planner, task).values
    paths = [roll_out(state, v, w, values) for v, w in velocities]
    return Candidates(velocities, scores, best, paths)


def robot_state(view: View) -> Array:
    """Returns the robot's state (x, y, yaw, v, omega) for DWB."""
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
    *,
    every: bool,
) -> Weighed:
    """Returns the samples of one cycle, and the scores of `every` one."""
    # Imported here, so that reading a scenario does not load numba.
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
        *(planner.setup(task).footprint, dynamics(planner, task).values, every),
    )
    return Weighed(best, vs, ws, scores, memory)


def _first_velocity(
    planner: DwbPlanner, task: PlanningTask, view: View, v: float, w: float
) -> tuple[float, float]:
    """Returns the velocity (v, omega) of the first step of a prediction."""
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
