"""One cycle of MPPI: draw, improve, remember."""

from dataclasses import astuple
import functools
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import count_steps
from hunav_drake.systems.common.layout import OMEGA
from hunav_drake.systems.planning.mppi import parameters
from hunav_drake.systems.planning.mppi.improving import improve
from hunav_drake.systems.planning.mppi.mppi_memory import MppiMemory
from hunav_drake.systems.planning.navigation.memory import Control, LocalPlan
from hunav_drake.systems.planning.planner import PlanningTask, View
from hunav_drake.systems.world.maps.costs import Costmap

if TYPE_CHECKING:
    from hunav_drake.systems.planning.mppi.mppi import MppiPlanner

FAULT = "each way ahead leads into something"

# Of a cycle, one after the other: draws of the improvements, and of the second
# try.
_TRIES = 2


# The distance within which the goal counts as reached that weights are meant
# for, in meters; and a turn that leaves any heading, in radians.
_USUAL_TOLERANCE = 0.25
_ANY_HEADING = 3.14


class Setting(NamedTuple):
    """What follows from the parameters of MPPI and the task.

    Attributes:
        p: The parameters of `improve`.
        forces: Those of the social force.
        steps: How many steps a rollout has.
        hold: For how many of them a command holds: the controls move on by
            as many in a cycle. 0 for steps longer than a cycle, in which they
            stay where they are.
    """

    p: Array
    forces: Array
    steps: int
    hold: int


class Rollouts(NamedTuple):
    """All that MPPI has weighed in one improvement.

    Attributes:
        alive: How many of them do not collide.
        controls: Shape (steps, 2): the average, rows (v, omega).
        scores: Shape (batch_size, 11): the total, the scaled scores of the
            critics, `CRITICS` in their order, and how far they leave the last
            controls.
        poses: Shape (batch_size, steps, 3), rows (x, y, yaw).
    """

    alive: int
    controls: Array
    scores: Array
    poses: Array


def setting(planner: "MppiPlanner", task: PlanningTask) -> Setting:
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
    p = np.zeros(parameters.NUM_PARAMETERS)
    for place, value in {
        parameters.DT: dt,
        parameters.MIN_V: -min(
            planner.max_reverse_vel_x, limits.max_reverse_speed
        ),
        parameters.MAX_V: min(planner.max_vel_x, limits.max_speed),
        parameters.MAX_TURN: min(planner.max_vel_theta, limits.max_turn_rate),
        parameters.ACC_V: min(planner.max_acc_x, limits.max_acceleration),
        parameters.ACC_TURN: min(
            planner.max_acc_theta, limits.max_turn_acceleration
        ),
        parameters.STD_V: planner.vx_std,
        parameters.STD_TURN: planner.wz_std,
        parameters.TEMPERATURE: planner.temperature,
        parameters.GAMMA: planner.gamma,
        parameters.COLLISION_COST: critics.collision_cost,
        parameters.CRITICAL_COST: critics.critical_cost,
        parameters.USE_FOOTPRINT: float(critics.consider_footprint),
        parameters.COST_NEAR_GOAL: critics.near_goal_distance,
        parameters.GOAL_NEAR: critics.goal_threshold,
        parameters.GOAL_ANGLE_NEAR: critics.goal_angle_threshold,
        parameters.PATH_NEAR: critics.path_threshold,
        parameters.FOLLOW_NEAR: critics.path_follow_threshold,
        parameters.ALIGN_AHEAD: critics.path_align_offset,
        parameters.ALIGN_BLOCKED: critics.max_path_occupancy_ratio,
        parameters.FOLLOW_AHEAD: critics.path_follow_offset,
        parameters.ANGLE_AHEAD: critics.path_angle_offset,
        parameters.ANGLE_LEAST: critics.max_angle_to_furthest,
        parameters.COST_EVERY: critics.cost_step,
        parameters.ALIGN_EVERY: critics.path_align_step,
        parameters.SOCIAL_EVERY: critics.social_step,
        parameters.HOLD: hold,
    }.items():
        p[place] = value
    for place, name in enumerate(parameters.CRITICS, start=1):
        p[place] = getattr(planner.weights, name)
    # The critics of the goal must not balance each other before it is reached,
    # as where the robot stands beside it, with the right heading.
    if task.goal_tolerance < _USUAL_TOLERANCE:
        p[parameters.GOAL] *= _USUAL_TOLERANCE / task.goal_tolerance
        p[parameters.GOAL_ANGLE_NEAR] = min(
            task.goal_tolerance, critics.goal_angle_threshold
        )
    if task.goal_yaw_tolerance >= _ANY_HEADING:
        p[parameters.GOAL_ANGLE] = 0.0
    p.setflags(write=False)
    forces = np.array(astuple(planner.social_force))
    forces.setflags(write=False)
    return Setting(p, forces, steps, hold)


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
    planner: "MppiPlanner",
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
        *(planner.setup(task).footprint, view.humans, made.forces, made.p),
    )
    return Rollouts(*result)


def optimize(
    planner: "MppiPlanner",
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
    v = min(
        max(controls[place, 0], made.p[parameters.MIN_V]),
        made.p[parameters.MAX_V],
    )
    most = made.p[parameters.MAX_TURN]
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


def _setting(planner: "MppiPlanner", task: PlanningTask) -> Setting:
    return planner.once(task, "mppi", lambda: setting(planner, task))
