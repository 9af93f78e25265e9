"""One cycle of SFW: near the end of the plan, or by prediction."""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import OMEGA, VX, VY, YAW, X, Y
from hunav_drake.systems.common.poses import wrap_angle
from hunav_drake.systems.people.parameters import (
    PARAMETERS,
    SocialForceParameters,
)
from hunav_drake.systems.planning.costmap.obstacle_layer import scan_ends
from hunav_drake.systems.planning.navigation.memory import Control, LocalPlan
from hunav_drake.systems.planning.planner import PlanningTask, View
from hunav_drake.systems.planning.social import prediction
from hunav_drake.systems.planning.social.following import INSIDE, carrot_at
from hunav_drake.systems.planning.social.obstacle_points import wall_points
from hunav_drake.systems.planning.social.sfw_memory import SfwMemory
from hunav_drake.systems.world.maps.costs import Costmap

if TYPE_CHECKING:
    from hunav_drake.systems.planning.social.sfw import SfwPlanner

# The weights of the force model of the paper's time (lightsfm, 2023), but for
# the one of the social force; without its later turn that breaks ties.
_FORCES = SocialForceParameters(social_factor=2.1, epsilon=0.0)

# Parts of the largest speed and turn rate that are tried.
_PARTS = (0.0, 0.25, 0.5, 0.75, 1.0)

# How far it must come to have left a spot, in meters.
_SPOT = 0.5

_NO_POINTS: Array = np.zeros((0, 2))


class Setup(NamedTuple):
    """What follows from the parameters, made once.

    Attributes:
        candidates: Shape (44, 2), rows (v, omega), in the order in which they
            are preferred where costs are equal.
        p: The parameters of `prediction.predict`.
        k: Those of the forces.
    """

    candidates: Array
    p: Array
    k: Array


def set_up(planner: "SfwPlanner", task: PlanningTask) -> Setup:
    """Returns what follows from the parameters and the task."""
    fastest = min(planner.max_trans_vel, task.limits.max_speed)
    turn = min(planner.max_rot_vel, task.limits.max_turn_rate)
    turns = sorted({s * part for part in _PARTS for s in (1, -1)})
    pairs = [
        (part * fastest, share * turn)
        for part in _PARTS
        for share in turns
        if part or share
    ]
    pairs.sort(key=lambda pair: (-pair[0], abs(pair[1])))
    steps = max(1, round(planner.sim_time / planner.sim_granularity))
    p = np.zeros(prediction.NUM_PARAMETERS)
    for place, value in {
        prediction.STEPS: steps,
        prediction.DT: planner.sim_time / steps,
        prediction.MAX_TRANS_ACC: planner.max_trans_acc,
        prediction.MAX_ROT_ACC: planner.max_rot_acc,
        prediction.MAX_TRANS_VEL: fastest,
        prediction.PEOPLE_VELOCITY: planner.people_velocity,
        prediction.ROBOT_RADIUS: planner.sfm_robot_radius,
        prediction.PERSON_RADIUS: planner.person_radius,
        prediction.NAIVE_GOAL_TIME: planner.naive_goal_time,
        prediction.SOCIAL_WEIGHT: planner.social_weight,
        prediction.COSTMAP_WEIGHT: planner.costmap_weight,
        prediction.VELOCITY_WEIGHT: planner.velocity_weight,
        prediction.ANGLE_WEIGHT: planner.angle_weight,
        prediction.DISTANCE_WEIGHT: planner.distance_weight,
        prediction.ODOMETRY_YAW: math.nan,
    }.items():
        p[place] = value
    k = np.array([getattr(_FORCES, name) for name in PARAMETERS])
    candidates = np.array(pairs)
    for array in (p, k, candidates):
        array.setflags(write=False)
    return Setup(candidates, p, k)


class Weighed(NamedTuple):
    """What SFW weighs in a cycle.

    Attributes:
        velocities: Shape (44, 2), rows (v, omega).
        costs: Shape (44,); infinite where a candidate is not valid.
    """

    velocities: Array
    costs: Array


def choose(
    planner: "SfwPlanner",
    task: PlanningTask,
    view: View,
    local: LocalPlan,
    costmap: Costmap,
    memory: SfwMemory,
) -> Control:
    """Returns the command of one cycle: see `SfwPlanner`."""
    x, y, yaw = view.robot[: YAW + 1].tolist()
    odometry_yaw = math.nan
    if planner.legacy_body_frame_velocity:
        if memory.odometry_yaw is None:
            memory = memory._replace(odometry_yaw=yaw)
        odometry_yaw = memory.odometry_yaw or 0.0
    end = local.poses[-1]
    left = math.hypot(end[X] - x, end[Y] - y)
    # Where the robot counts as at its goal only nearer, it is to come nearer.
    if left < min(planner.xy_goal_tolerance, INSIDE * task.goal_tolerance):
        error = wrap_angle(float(end[YAW]) - yaw)
        if abs(error) < min(
            planner.yaw_goal_tolerance, INSIDE * task.goal_yaw_tolerance
        ):
            return Control(0.0, 0.0, memory.anew())
        turn = min(
            planner.min_in_place_rot_vel,
            abs(error) / planner.reaction_time(task),
        )
        return Control(0.0, math.copysign(turn, error), memory.anew())
    if not memory.cycles or math.hypot(memory.x - x, memory.y - y) > _SPOT:
        memory = memory.anew(x, y)
    memory = memory._replace(cycles=memory.cycles + 1)
    carrot = carrot_at(view, local, planner.wp_tolerance)
    if left < planner.slow_distance:
        pair = _towards(planner, task, view, carrot, left)
        costs = weigh(
            *(planner, task, view, carrot, costmap),
            np.array([pair]),
            odometry_yaw=odometry_yaw,
        ).costs
        if math.isfinite(costs[0]):
            return Control(*pair, memory)
    held = memory.cycles * planner.period > planner.patience
    weighed = weigh(
        *(planner, task, view, carrot, costmap),
        walls=not held,
        odometry_yaw=odometry_yaw,
    )
    best = int(np.argmin(weighed.costs))
    if not math.isfinite(weighed.costs[best]):
        fault = "each way ahead leads into something"
        return Control(0.0, 0.0, memory, fault)
    v, omega = weighed.velocities[best].tolist()
    return Control(v, omega, memory)


def _towards(
    planner: "SfwPlanner",
    task: PlanningTask,
    view: View,
    carrot: tuple[float, float],
    left: float,
) -> tuple[float, float]:
    """Returns the slower velocity near the end of the plan.

    It is a turn on the spot where the tightest curve goes around the end.
    """
    x, y, yaw = view.robot[: YAW + 1].tolist()
    low, high = planner.min_trans_vel, planner.max_trans_vel
    v = low + (high - low) * left / planner.slow_distance
    bearing = wrap_angle(math.atan2(carrot[1] - y, carrot[0] - x) - yaw)
    slow, fast = planner.min_rot_vel, planner.max_rot_vel
    rate = slow + (fast - slow) * abs(bearing) / math.pi
    most = task.limits.max_turn_rate
    if 2 * v * math.sin(abs(bearing)) > left * most:
        turn = abs(bearing) / planner.reaction_time(task)
        v, rate = 0.0, min(planner.max_rot_vel, most, turn)
    return v, math.copysign(rate, bearing) if bearing else 0.0


def weigh(
    planner: "SfwPlanner",
    task: PlanningTask,
    view: View,
    carrot: tuple[float, float],
    costmap: Costmap,
    velocities: Array | None = None,
    *,
    walls: bool = True,
    odometry_yaw: float = math.nan,
) -> Weighed:
    """Returns candidates and their costs, also for those who look at them.

    Args:
        planner: The parameters.
        task: What does not change.
        view: What the planner sees.
        carrot: The point (x, y) on the plan that it steers to.
        costmap: The local map.
        velocities: What to weigh, shape (m, 2), rows (v, omega); by default
            the 44 candidates.
        walls: Whether the forces of obstacles count.
        odometry_yaw: The direction that the robot's velocity is taken along
            in the forces, in radians; NaN for its heading.
    """
    setup = planner.once(task, "sfw", lambda: set_up(planner, task))
    velocities = setup.candidates if velocities is None else velocities
    x, y, yaw = view.robot[: YAW + 1].tolist()
    speed = math.cos(yaw) * view.robot[VX] + math.sin(yaw) * view.robot[VY]
    robot = np.array([x, y, yaw, speed, view.robot[OMEGA]])
    humans = np.ascontiguousarray(view.humans)
    ahead = planner.naive_goal_time * humans[:, [VX, VY]]
    goals = np.ascontiguousarray(
        np.vstack([[carrot], humans[:, [X, Y]] + ahead])
    )
    p = setup.p
    if not math.isnan(odometry_yaw):
        p = p.copy()
        p[prediction.ODOMETRY_YAW] = odometry_yaw
    costs = prediction.candidate_costs(
        *(robot, velocities, humans, goals),
        _points(planner, task, view) if walls else _NO_POINTS,
        *(costmap.costs, *costmap.origin, costmap.resolution),
        *(planner.setup(task).footprint, p, setup.k),
    )
    return Weighed(velocities, costs)


def _points(planner: "SfwPlanner", task: PlanningTask, view: View) -> Array:
    """Returns where obstacles are that are not people, shape (m, 2)."""
    x, y = view.robot[[X, Y]].tolist()
    reach = planner.max_obstacle_dist
    if view.scan is None:
        points: Array = wall_points(
            x, y, reach, planner.obstacle_points, task.obstacles.table
        )
    else:
        assert task.lidar is not None
        ends = scan_ends(task.lidar, view.scan, view.robot)
        ends = ends[ends[:, 2] < min(reach, task.lidar.range_max)]
        # (Rays are finer than what the forces need.)
        every = max(1, len(ends) // planner.obstacle_points)
        points = np.ascontiguousarray(ends[::every, :2])
    if not len(view.humans) or not len(points):
        return points
    offsets = points[:, None] - view.humans[None, :, [X, Y]]
    away = np.hypot(offsets[..., 0], offsets[..., 1]).min(axis=1)
    return np.ascontiguousarray(points[away > planner.person_radius])
