"""SFW: the dynamic window with people predicted by the social force."""

from dataclasses import field
import math
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import Field, StrictBool, StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import OMEGA, VX, VY, YAW, X, Y
from hunav_drake.systems.common.poses import wrap_angle
from hunav_drake.systems.common.schema import (
    CONFIG,
    BodyRadius,
    Integer,
    PositiveLength,
    PositiveSpeed,
    Speed,
    within,
)
from hunav_drake.systems.people.parameters import (
    PARAMETERS,
    SocialForceParameters,
)
from hunav_drake.systems.planning.costmap.costmap_config import (
    LocalCostmap,
    Period,
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
from hunav_drake.systems.planning.social.sfw_memory import SfwMemory
from hunav_drake.systems.robot.robot_config import (
    Acceleration,
    TurnAcceleration,
    TurnRate,
)
from hunav_drake.systems.world.maps.costs import Costmap

# The weights of the force model of the paper's time (lightsfm, 2023), but for
# the one of the social force; without its later turn that breaks ties.
_FORCES = SocialForceParameters(social_factor=2.1, epsilon=0.0)

# Parts of the largest speed and turn rate that are tried.
_PARTS = (0.0, 0.25, 0.5, 0.75, 1.0)

# How far it must come to have left a spot, in meters.
_SPOT = 0.5

_NO_POINTS: Array = np.zeros((0, 2))

Weight = Annotated[StrictFloat, within(0, 1e6)]


class Setup(NamedTuple):
    """What follows from the parameters, made once.

    Attributes:
        candidates: Shape (44, 2), rows (v, omega), in the order in which they
            are preferred where costs are equal.
        p: The parameters of `prediction.Parameters`, which kernels read.
        k: Those of the forces.
    """

    candidates: Array
    p: Array
    k: Array


class Weighed(NamedTuple):
    """What SFW weighs in a cycle.

    Attributes:
        velocities: Shape (44, 2), rows (v, omega).
        costs: Shape (44,); infinite where a candidate is not valid.
    """

    velocities: Array
    costs: Array


@register_planner("sfw")
@dataclass(kw_only=True, config=CONFIG)
class SfwPlanner(NavigationPlanner):
    """Weighs velocities by the social work that they lead to.

    In each cycle it predicts 44 pairs of a speed and a turn rate: the robot
    moves towards the pair, and people move by the social force model, in which
    the robot is one of them. It takes the pair with the lowest sum of speed
    left, distance and bearing to a point ahead on the plan, cost of the map,
    and social work (social_force_window_planner). The parameters are named as
    there; the defaults are those of its example.
    """

    initial_control: ClassVar[Any] = SfwMemory()

    local_costmap: LocalCostmap = field(
        default_factory=lambda: LocalCostmap(size=4.0)
    )
    """What is on the local map; it must be at least 4 m wide, or the robot is
    always near the end of its plan."""

    max_trans_vel: PositiveSpeed = 0.8
    """The largest speed, in m/s."""

    min_trans_vel: Speed = 0.08
    """The least speed near the end of the plan, in m/s."""

    max_rot_vel: TurnRate = 1.57
    """The largest turn rate, in rad/s."""

    min_rot_vel: Annotated[StrictFloat, within(0, 100, "rad/s")] = 0.52
    """The least turn rate near the end of the plan, in rad/s."""

    max_trans_acc: Acceleration = 0.15
    """How fast the speed changes in the prediction, in m/s^2."""

    max_rot_acc: TurnAcceleration = 0.52
    """How fast the turn rate changes in the prediction, in rad/s^2."""

    min_in_place_rot_vel: TurnRate = 0.7
    """The turn rate at the end, to the heading of the goal, in rad/s."""

    xy_goal_tolerance: PositiveLength = 0.2
    """How near to the end of the plan it turns on the spot, in meters."""

    yaw_goal_tolerance: Annotated[
        StrictFloat, within(0, math.pi, "rad", low_open=True)
    ] = 0.2
    """How near its heading must be to the goal's at the end, in radians."""

    wp_tolerance: PositiveLength = 1.0
    """How far ahead on the plan the point is that it steers to, in meters."""

    slow_distance: PositiveLength = 1.5
    """Nearer to the end of the plan than this it slows down, and people do not
    count any more, in meters."""

    sim_time: Period = 1.5
    """How far ahead it predicts, in seconds."""

    sim_granularity: Annotated[StrictFloat, within(0.01, 60, "s")] = 0.25
    """The step of the prediction, in seconds."""

    sfm_robot_radius: BodyRadius = 0.4
    """The radius of the robot in the prediction, in meters."""

    person_radius: BodyRadius = 0.35
    """The radius of people in the prediction, in meters."""

    social_weight: Weight = 2.0
    """How much the social work counts."""

    costmap_weight: Weight = 2.0
    """How much the cost of the map counts."""

    velocity_weight: Weight = 0.8
    """How much the speed that is left over counts."""

    angle_weight: Weight = 0.6
    """How much the bearing to the point ahead counts."""

    distance_weight: Weight = 1.0
    """How much the distance to the point ahead counts."""

    max_obstacle_dist: PositiveLength = 3.0
    """How far obstacles are felt, in meters."""

    obstacle_points: Annotated[Integer, Field(ge=3, le=10_000)] = 120
    """In how many directions the nearest obstacle is felt, as a point."""

    naive_goal_time: Period = 1.0
    """How long people are taken to go on as they walk, in seconds."""

    people_velocity: PositiveSpeed = 1.7
    """How fast people are taken to walk at most, in m/s."""

    patience: Period = 3.0
    """After so long on one spot, in seconds, the forces of obstacles do not
    count until it has left it: else they may hold it between walls forever."""

    legacy_body_frame_velocity: StrictBool = False
    """Whether the velocity of the robot in the forces is that along its own
    axes instead of those of its odometry, which begins where the robot does: an
    oversight of the original. A robot that has not turned notices nothing."""

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


def set_up(planner: SfwPlanner, task: PlanningTask) -> Setup:
    """Returns what follows from the parameters and the task."""
    # Reading a scenario does without numba.
    from hunav_drake.systems.planning.social.prediction import Parameters

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
    values = {
        **vars(planner),
        "max_trans_vel": fastest,
        "steps": steps,
        "dt": planner.sim_time / steps,
    }
    p = np.array([float(values[name]) for name in Parameters._fields])
    k = np.array([getattr(_FORCES, name) for name in PARAMETERS])
    candidates = np.array(pairs)
    for array in (p, k, candidates):
        array.setflags(write=False)
    return Setup(candidates, p, k)


def choose(
    planner: SfwPlanner,
    task: PlanningTask,
    view: View,
    local: LocalPlan,
    costmap: Costmap,
    memory: SfwMemory,
) -> Control:
    """Returns the command of one cycle: see `SfwPlanner`."""
    # Reading a scenario does without numba.
    from hunav_drake.systems.planning.social.following import INSIDE, carrot_at

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
    planner: SfwPlanner,
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
    planner: SfwPlanner,
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
    from hunav_drake.systems.planning.social.prediction import candidate_costs

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
    costs = candidate_costs(
        *(robot, velocities, humans, goals),
        _points(planner, task, view) if walls else _NO_POINTS,
        *(costmap.costs, *costmap.origin, costmap.resolution),
        *(planner.setup(task).footprint, odometry_yaw, setup.p, setup.k),
    )
    return Weighed(velocities, costs)


def _points(planner: SfwPlanner, task: PlanningTask, view: View) -> Array:
    """Returns where obstacles are that are not people, shape (m, 2)."""
    from hunav_drake.systems.planning.costmap.obstacle_layer import scan_ends
    from hunav_drake.systems.planning.social.obstacle_points import wall_points

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
