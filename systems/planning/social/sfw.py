"""SFW: the dynamic window with people predicted by the social force."""

from dataclasses import field
import math
from typing import Annotated, Any, ClassVar

from pydantic import Field, StrictBool, StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.schema import (
    CONFIG,
    BodyRadius,
    Integer,
    PositiveLength,
    PositiveSpeed,
    Speed,
    within,
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

Weight = Annotated[StrictFloat, within(0, 1e6)]


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
        # Reading a scenario does without numba.
        from hunav_drake.systems.planning.social.sfw_cycle import choose

        return choose(self, task, view, local, costmap, memory)
