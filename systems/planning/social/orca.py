"""A robot that avoids people by ORCA."""

import math
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.layout import OMEGA, VX, VY, YAW, X, Y
from hunav_drake.systems.common.poses import wrap_angle
from hunav_drake.systems.common.schema import (
    CONFIG,
    Length,
    PositiveLength,
    PositiveSpeed,
    within,
)
from hunav_drake.systems.planning.costmap.costmap_config import Period
from hunav_drake.systems.planning.navigation.memory import Control, LocalPlan
from hunav_drake.systems.planning.navigation.navigation_planner import (
    NavigationPlanner,
)
from hunav_drake.systems.planning.planner import (
    PlanningTask,
    View,
    register_planner,
)
from hunav_drake.systems.planning.scanned_bodies import bodies
from hunav_drake.systems.world.maps.costs import Costmap


@register_planner("orca")
@dataclass(kw_only=True, config=CONFIG)
class OrcaPlanner(NavigationPlanner):
    """Takes the collision-free velocity nearest to the desired one (ORCA).

    The desired velocity leads to a point ahead on the global plan. A
    differential drive cannot move sideways, so a point ahead of its axle
    follows the velocity, with a disc enlarged by that offset.
    """

    uses_local_map: ClassVar[bool] = False

    desired_speed: PositiveSpeed = 0.6
    """Desired speed, in m/s."""

    carrot_distance: PositiveLength = 1.0
    """Distance of the target point ahead on the plan, in meters."""

    neighbor_distance: PositiveLength = 10.0
    """Distance up to which people are avoided, in meters."""

    time_horizon: Period = 3.0
    """Time horizon without contact with people, in seconds."""

    wall_horizon: Period = 1.0
    """Time horizon without contact with walls, in seconds."""

    share: Annotated[StrictFloat, within(0, 1, low_open=True)] = 1.0
    """Fraction of the avoiding change of velocity that the robot takes: 0.5
    where people take the other half, 1 where they may not."""

    offset: Annotated[StrictFloat, within(0, 1, "m", low_open=True)] = 0.15
    """Distance of the following point ahead of the axle, in meters."""

    margin: Length = 0.05
    """Margin added to the distance from people, in meters."""

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
        from hunav_drake.systems.planning.social.differential import brakable
        from hunav_drake.systems.planning.social.following import (
            at_end,
            carrot_at,
        )
        from hunav_drake.systems.planning.social.reciprocal import (
            Parameters,
            avoiding_velocity,
        )

        reaction = self.reaction_time(task)
        if (stop := at_end(task, view, local, reaction)) is not None:
            return stop
        p = Parameters(
            speed=min(self.desired_speed, task.limits.max_speed),
            radius_to_people=task.robot_radius + self.offset + self.margin,
            radius_to_walls=self.setup(task).robot_radius + self.offset,
            neighbor_distance=self.neighbor_distance,
            horizon=self.time_horizon,
            wall_horizon=self.wall_horizon,
            share=self.share,
            step=self.period,
        )
        robot = view.robot
        c, s = math.cos(robot[YAW]), math.sin(robot[YAW])
        x, y = robot[X] + self.offset * c, robot[Y] + self.offset * s
        swing = self.offset * robot[OMEGA]
        own = np.array([x, y, robot[VX] - swing * s, robot[VY] + swing * c])
        gx, gy = carrot_at(view, local, self.carrot_distance)
        left = math.hypot(local.goal[0] - robot[X], local.goal[1] - robot[Y])
        speed = min(p.speed, max(left, 0.15), left / reaction)
        # Near the goal, the axle itself must get there. The robot turns to
        # targets behind it: the point can move sideways while the axle stands
        # still.
        at = (x, y) if left > 2 * self.offset else robot[[X, Y]]
        error = math.atan2(gy - at[1], gx - at[0]) - robot[YAW]
        error = min(max(wrap_angle(error), -math.pi / 2), math.pi / 2)
        bearing = robot[YAW] + error
        velocity = avoiding_velocity(
            *(own, speed * math.cos(bearing), speed * math.sin(bearing)),
            *(bodies(task, view), task.obstacles.table, np.array(p)),
        )
        v = c * velocity[0] + s * velocity[1]
        aside = c * velocity[1] - s * velocity[0]
        most = task.limits.max_turn_rate
        omega = brakable(
            aside / self.offset,
            math.atan2(aside, v),
            task.limits.max_turn_acceleration,
            reaction,
        )
        low = -task.limits.max_reverse_speed
        return Control(
            float(min(max(v, low), p.speed)),
            float(min(max(omega, -most), most)),
        )
