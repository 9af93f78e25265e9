"""SFW: a dynamic window planner that predicts people by the social force."""

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

# The weights of lightsfm in 2023, the time of the paper, except for the social
# force; without its later angle that breaks symmetry.
_FORCES = SocialForceParameters(social_factor=2.1, epsilon=0.0)

# The fractions of the maximum speed and turn rate to sample.
_PARTS = (0.0, 0.25, 0.5, 0.75, 1.0)

# The distance from a spot at which the robot has left it, in meters.
_SPOT = 0.5

_NO_POINTS: Array = np.zeros((0, 2))

Weight = Annotated[StrictFloat, within(0, 1e6)]


class Setup(NamedTuple):
    """Values derived from the parameters, computed once.

    Attributes:
        candidates: Shape (44, 2), rows (v, omega), in the order of preference
            at equal costs.
        p: The `prediction.Parameters` as an array for kernels.
        k: The parameters of the forces.
    """

    candidates: Array
    p: Array
    k: Array


class Rules(NamedTuple):
    """What counts in the costs of candidates.

    Attributes:
        walls: Whether the forces of obstacles count.
        odometry_yaw: The direction of the robot's velocity in the forces, in
            radians; NaN for its heading.
        every: Whether all costs are needed. Otherwise a candidate that costs
            more than the best has a part of its cost.
    """

    walls: bool = True
    odometry_yaw: float = math.nan
    every: bool = True


_ALL = Rules()


class Weighed(NamedTuple):
    """The candidates of SFW in a cycle.

    Attributes:
        velocities: Shape (44, 2), rows (v, omega).
        costs: Shape (44,); infinite where a candidate is not valid.
    """

    velocities: Array
    costs: Array


@register_planner("sfw")
@dataclass(kw_only=True, config=CONFIG)
class SfwPlanner(NavigationPlanner):
    """Takes the velocity with the lowest cost, which includes social work.

    In each cycle it predicts 44 pairs of a speed and a turn rate: the robot's
    velocity changes to the pair, and people move by the social force model, in
    which the robot is one of the agents. It takes the pair with the lowest sum
    of costs: unused speed, distance and bearing to a point ahead on the plan,
    costmap, and social work (social_force_window_planner). The parameters have
    the names used there; the defaults are those of its example.
    """

    initial_control: ClassVar[Any] = SfwMemory()

    local_costmap: LocalCostmap = field(
        default_factory=lambda: LocalCostmap(size=4.0)
    )
    """Local costmap; its size must be at least 4 m, or the robot is always near
    the end of its local plan."""

    max_trans_vel: PositiveSpeed = 0.8
    """Maximum speed, in m/s."""

    min_trans_vel: Speed = 0.08
    """Minimum speed near the end of the plan, in m/s."""

    max_rot_vel: TurnRate = 1.57
    """Maximum turn rate, in rad/s."""

    min_rot_vel: Annotated[StrictFloat, within(0, 100, "rad/s")] = 0.52
    """Minimum turn rate near the end of the plan, in rad/s."""

    max_trans_acc: Acceleration = 0.15
    """Maximum linear acceleration in the prediction, in m/s^2."""

    max_rot_acc: TurnAcceleration = 0.52
    """Maximum angular acceleration in the prediction, in rad/s^2."""

    min_in_place_rot_vel: TurnRate = 0.7
    """Rate of the turn in place to the goal's heading, in rad/s."""

    xy_goal_tolerance: PositiveLength = 0.2
    """Distance from the end of the plan below which it turns in place, in
    meters."""

    yaw_goal_tolerance: Annotated[
        StrictFloat, within(0, math.pi, "rad", low_open=True)
    ] = 0.2
    """Tolerance of the heading at the goal, in radians."""

    wp_tolerance: PositiveLength = 1.0
    """Distance of the target point ahead on the plan, in meters."""

    slow_distance: PositiveLength = 1.5
    """Distance from the end of the plan below which it slows down and ignores
    people, in meters."""

    sim_time: Period = 1.5
    """Time horizon of the prediction, in seconds."""

    sim_granularity: Annotated[StrictFloat, within(0.01, 60, "s")] = 0.25
    """Time step of the prediction, in seconds."""

    sfm_robot_radius: BodyRadius = 0.4
    """Radius of the robot in the prediction, in meters."""

    person_radius: BodyRadius = 0.35
    """Radius of people in the prediction, in meters."""

    social_weight: Weight = 2.0
    """Weight of the social work."""

    costmap_weight: Weight = 2.0
    """Weight of the costmap."""

    velocity_weight: Weight = 0.8
    """Weight of the unused speed."""

    angle_weight: Weight = 0.6
    """Weight of the bearing to the target point."""

    distance_weight: Weight = 1.0
    """Weight of the squared distance to the target point."""

    max_obstacle_dist: PositiveLength = 3.0
    """Range within which obstacles exert a force, in meters."""

    obstacle_points: Annotated[Integer, Field(ge=3, le=10_000)] = 120
    """Number of directions in which the nearest obstacle counts as a point."""

    naive_goal_time: Period = 1.0
    """Time for which people are assumed to keep their velocity, in seconds; it
    gives their goals."""

    people_velocity: PositiveSpeed = 1.7
    """Maximum walking speed of people in the prediction, in m/s."""

    patience: Period = 3.0
    """Time on one spot after which obstacle forces are ignored until the robot
    has left it, in seconds. Otherwise they may hold it between walls forever.
    """

    legacy_body_frame_velocity: StrictBool = False
    """Whether the robot's velocity in the forces is expressed in its body frame
    but used as if in its odometry frame, which has the robot's start pose: a
    bug of the original. It has no effect on a robot that has not turned."""

    def control(
        self,
        task: PlanningTask,
        view: View,
        local: LocalPlan,
        costmap: Costmap,
        memory: Any,
    ) -> Control:
        """Decides the command: see `NavigationPlanner.control`."""
        # Imported here, so that reading a scenario does not load numba.
        from hunav_drake.systems.planning.social.following import (
            INSIDE,
            carrot_at,
        )

        x, y, yaw = view.robot[: YAW + 1].tolist()
        odometry_yaw = math.nan
        if self.legacy_body_frame_velocity:
            if memory.odometry_yaw is None:
                memory = memory._replace(odometry_yaw=yaw)
            odometry_yaw = memory.odometry_yaw or 0.0
        end = local.poses[-1]
        left = math.hypot(end[X] - x, end[Y] - y)
        # A tighter goal tolerance of the task holds here, too.
        if left < min(self.xy_goal_tolerance, INSIDE * task.goal_tolerance):
            error = wrap_angle(float(end[YAW]) - yaw)
            if abs(error) < min(
                self.yaw_goal_tolerance, INSIDE * task.goal_yaw_tolerance
            ):
                return Control(0.0, 0.0, memory.anew())
            turn = min(
                self.min_in_place_rot_vel,
                self.max_rot_vel,
                abs(error) / self.reaction_time(task),
            )
            return Control(0.0, math.copysign(turn, error), memory.anew())
        if not memory.cycles or math.hypot(memory.x - x, memory.y - y) > _SPOT:
            memory = memory.anew(x, y)
        memory = memory._replace(cycles=memory.cycles + 1)
        carrot = carrot_at(view, local, self.wp_tolerance)
        if left < self.slow_distance:
            pair = _towards(self, task, view, carrot, left)
            costs = weigh(
                *(self, task, view, carrot, costmap),
                *(np.array([pair]), Rules(odometry_yaw=odometry_yaw)),
            ).costs
            if math.isfinite(costs[0]):
                return Control(*pair, memory)
        held = memory.cycles * self.period > self.patience
        weighed = weigh(
            *(self, task, view, carrot, costmap, None),
            Rules(walls=not held, odometry_yaw=odometry_yaw, every=False),
        )
        best = int(np.argmin(weighed.costs))
        if not math.isfinite(weighed.costs[best]):
            fault = "no velocity is free of collision"
            return Control(0.0, 0.0, memory, fault)
        v, omega = weighed.velocities[best].tolist()
        return Control(v, omega, memory)


def set_up(planner: SfwPlanner, task: PlanningTask) -> Setup:
    """Returns the values derived from the parameters and the task."""
    # Imported here, so that reading a scenario does not load numba.
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


def _towards(
    planner: SfwPlanner,
    task: PlanningTask,
    view: View,
    carrot: tuple[float, float],
    left: float,
) -> tuple[float, float]:
    """Returns the reduced velocity near the end of the plan.

    It is a turn in place where the tightest curve would circle the end.
    """
    x, y, yaw = view.robot[: YAW + 1].tolist()
    low, high = planner.min_trans_vel, planner.max_trans_vel
    v = min(low + (high - low) * left / planner.slow_distance, high)
    bearing = wrap_angle(math.atan2(carrot[1] - y, carrot[0] - x) - yaw)
    slow, fast = planner.min_rot_vel, planner.max_rot_vel
    rate = min(slow + (fast - slow) * abs(bearing) / math.pi, fast)
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
    rules: Rules = _ALL,
) -> Weighed:
    """Returns candidates and their costs, for inspection, too.

    `carrot` is the target point (x, y) on the plan; `velocities`, shape (m, 2),
    rows (v, omega), are the 44 candidates by default.
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
        _points(planner, task, view) if rules.walls else _NO_POINTS,
        *(costmap.costs, *costmap.origin, costmap.resolution),
        *(planner.setup(task).footprint, rules.odometry_yaw),
        *(setup.p, setup.k, rules.every),
    )
    return Weighed(velocities, costs)


def _points(planner: SfwPlanner, task: PlanningTask, view: View) -> Array:
    """Returns the points of obstacles other than people, shape (m, 2)."""
    from hunav_drake.systems.planning.costmap.obstacle_layer import scan_ends
    from hunav_drake.systems.planning.social.prediction import wall_points

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
        # (The forces need fewer points than there are rays.)
        every = max(1, len(ends) // planner.obstacle_points)
        points = np.ascontiguousarray(ends[::every, :2])
    if not len(view.humans) or not len(points):
        return points
    offsets = points[:, None] - view.humans[None, :, [X, Y]]
    away = np.hypot(offsets[..., 0], offsets[..., 1]).min(axis=1)
    return np.ascontiguousarray(points[away > planner.person_radius])
