"""One cycle of DWB: sample, score, choose, remember."""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import OMEGA, YAW
from hunav_drake.systems.common.poses import wrap_angle
from hunav_drake.systems.planning.dwb import scoring
from hunav_drake.systems.planning.dwb.dwb_memory import DwbMemory, Trend
from hunav_drake.systems.planning.dwb.weighing import weigh_samples
from hunav_drake.systems.planning.navigation.memory import Control, LocalPlan
from hunav_drake.systems.planning.navigation.profiles import either
from hunav_drake.systems.planning.planner import PlanningTask, View
from hunav_drake.systems.world.maps.costs import Costmap

if TYPE_CHECKING:
    from hunav_drake.systems.planning.dwb.dwb import DwbPlanner

# Slower measured speeds, in m/s, and turn rates, in rad/s, count as none.
_STILL = 0.001

# As many speeds are tried at most for the sake of a small goal.
_MOST_SPEEDS = 100

# Why there is no command, by what stands for the best sample.
_FAULTS = {
    -1: "each way ahead leads into something",
    -2: "the plan is nowhere on the local map",
}


class Dynamics(NamedTuple):
    """What the samples of DWB are drawn within, and the kernel's parameters.

    Attributes:
        bounds: The bounds that `weigh_samples` takes.
        p: The parameters of `score_samples`.
    """

    bounds: Array
    p: Array


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
            `CRITICS` in their order; infinite where a critic forbids it.
        best: The row of the one taken; -1 if all are forbidden.
        paths: What is predicted for each, shape (k, 3), rows (x, y, yaw).
    """

    velocities: Array
    scores: Array
    best: int
    paths: list[Array]


def dynamics(planner: "DwbPlanner", task: PlanningTask) -> Dynamics:
    """Returns what follows from the parameters of DWB and the task."""
    profile, critics = planner.dwb_profile, planner.critics
    turn = either(planner.max_vel_theta, profile.max_vel_theta)
    high = min(planner.max_vel_x, task.limits.max_speed)
    at_once = planner.trajectory_generator == "limited_accel"
    p = np.zeros(scoring.NUM_PARAMETERS)
    for place, value in {
        scoring.SIM_TIME: planner.sim_time,
        scoring.LINEAR_GRANULARITY: planner.linear_granularity,
        scoring.ANGULAR_GRANULARITY: planner.angular_granularity,
        scoring.TIME_GRANULARITY: either(planner.time_granularity, 0.0),
        scoring.ACC_X: either(planner.acc_lim_x, profile.acc_lim_x),
        scoring.DECEL_X: either(planner.decel_lim_x, profile.decel_lim_x),
        scoring.ACC_THETA: either(planner.acc_lim_theta, profile.acc_lim_theta),
        scoring.DECEL_THETA: either(
            planner.decel_lim_theta, profile.decel_lim_theta
        ),
        scoring.AT_ONCE: float(at_once),
        scoring.MAX_SPEED: high,
        scoring.MIN_SPEED: planner.min_speed_xy,
        scoring.MIN_TURN: planner.min_speed_theta,
        scoring.FORWARD_POINT: critics.forward_point_distance,
        scoring.SLOWING_FACTOR: critics.slowing_factor,
        scoring.LOOKAHEAD_TIME: critics.lookahead_time,
        scoring.SUM_SCORES: float(critics.sum_scores),
        scoring.PENALTY: critics.penalty,
        scoring.STRAFE_X: critics.strafe_x,
        scoring.STRAFE_THETA: critics.strafe_theta,
        scoring.THETA_SCALE: critics.theta_scale,
    }.items():
        p[place] = value
    for place, name in enumerate(scoring.CRITICS, start=1):
        p[place] = getattr(planner.scales, name)
    p.setflags(write=False)
    low = max(min(planner.min_vel_x, high), -task.limits.max_reverse_speed)
    # Their ways must end close enough together for one to end at the goal.
    apart = (high - low) * planner.sim_time / task.goal_tolerance
    speeds = max(planner.vx_samples, min(math.ceil(apart) + 1, _MOST_SPEEDS))
    bounds = np.array(
        [
            *(low, high),
            min(turn, task.limits.max_turn_rate),
            planner.period if at_once else planner.sim_time,
            speeds,
            planner.vtheta_samples,
        ]
    )
    bounds.setflags(write=False)
    return Dynamics(bounds, p)


def choose(
    planner: "DwbPlanner",
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
    planner: "DwbPlanner",
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
    weighed = _weigh(planner, task, view, local, costmap, memory or DwbMemory())
    best, vs, ws, scores, _ = weighed
    if best == -2:
        raise ValueError(f"there is nothing to weigh: {_FAULTS[best]}")
    velocities = np.column_stack([np.repeat(vs, len(ws)), np.tile(ws, len(vs))])
    state, p = robot_state(view), _dynamics(planner, task).p
    paths = [scoring.roll_out(state, v, w, p) for v, w in velocities]
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


def _dynamics(planner: "DwbPlanner", task: PlanningTask) -> Dynamics:
    return planner.once(task, "dwb", lambda: dynamics(planner, task))


def _weigh(
    planner: "DwbPlanner",
    task: PlanningTask,
    view: View,
    local: LocalPlan,
    costmap: Costmap,
    memory: DwbMemory,
) -> Weighed:
    """Returns what is weighed in one cycle."""
    if local.is_new:
        memory = DwbMemory()
    bounds = _dynamics(planner, task)
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
        bounds.bounds,
        np.array(
            [
                float(in_window) + float(rotating),
                float(memory.x.only),
                float(memory.theta.only),
            ]
        ),
        *(planner.setup(task).footprint, bounds.p),
    )
    return Weighed(best, vs, ws, scores, memory)


def _first_velocity(
    planner: "DwbPlanner", task: PlanningTask, view: View, v: float, w: float
) -> tuple[float, float]:
    """Returns the velocity of the first step of a prediction."""
    p = _dynamics(planner, task).p
    if p[scoring.AT_ONCE]:
        return v, w
    now = robot_state(view)
    dt = p[scoring.SIM_TIME] / scoring.steps_of(v, w, p)
    return (
        scoring.toward(now[3], p[scoring.ACC_X], p[scoring.DECEL_X], dt, v),
        scoring.toward(
            now[4], p[scoring.ACC_THETA], p[scoring.DECEL_THETA], dt, w
        ),
    )
