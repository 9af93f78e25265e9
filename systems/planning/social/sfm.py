"""A robot that moves by the social force, as people do."""

from dataclasses import field
import math
from typing import Any

import numpy as np
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.layout import VX, VY, YAW, X, Y
from hunav_drake.systems.common.poses import wrap_angle
from hunav_drake.systems.common.schema import (
    CONFIG,
    PositiveLength,
    PositiveSpeed,
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
from hunav_drake.systems.planning.scanned_bodies import bodies
from hunav_drake.systems.world.maps.costs import Costmap


@register_planner("sfm")
@dataclass(kw_only=True, config=CONFIG)
class SfmPlanner(NavigationPlanner):
    """Follows the social force of its goal, people and walls, as people do.

    The force is that of Helbing and Molnar 1995 with the interaction of
    Moussaid et al. 2009, towards a point ahead on the global plan. It changes
    the velocity of the robot, which steers into it.
    """

    local_costmap: LocalCostmap = field(
        default_factory=lambda: LocalCostmap(
            resolution=0.05, layers=["obstacle"]
        )
    )
    """Local costmap of the obstacles before which it stops, without inflation.
    """

    desired_speed: PositiveSpeed = 0.6
    """Desired speed, in m/s."""

    carrot_distance: PositiveLength = 1.0
    """Distance of the attracting point ahead on the plan, in meters."""

    horizon: Period = 0.25
    """Time over which the force acts on the velocity, in seconds. In 0.25 s the
    goal's force gives the desired velocity; a longer time would overshoot."""

    turn_time: Period = 0.4
    """Time in which the robot turns to the desired direction, in seconds."""

    slow_distance: PositiveLength = 0.8
    """Distance from the goal below which it slows down, in meters."""

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
        from hunav_drake.systems.planning.social.differential import steer
        from hunav_drake.systems.planning.social.following import (
            at_end,
            carrot_at,
            is_free,
        )
        from hunav_drake.systems.planning.social.forces import robot_force

        reaction = self.reaction_time(task)
        if (stop := at_end(task, view, local, reaction)) is not None:
            return stop
        setup = self.setup(task)
        x, y = carrot_at(view, local, self.carrot_distance)
        left = math.hypot(
            local.goal[0] - view.robot[X], local.goal[1] - view.robot[Y]
        )
        fastest = min(self.desired_speed, task.limits.max_speed)
        speed = self.desired_speed * min(1.0, left / self.slow_distance)
        speed = min(max(speed, 0.1), fastest, left / reaction)
        force = robot_force(
            *(np.ascontiguousarray(view.robot), np.array([x, y, speed])),
            *(bodies(task, view), task.obstacles.table),
            *(setup.robot_radius, _PARAMETERS),
        )
        vx = view.robot[VX] + force[0] * self.horizon
        vy = view.robot[VY] + force[1] * self.horizon
        fast = math.hypot(vx, vy)
        if fast > speed:
            vx, vy = vx * speed / fast, vy * speed / fast
        yaw = float(view.robot[YAW])
        how = self.turn_time, task.limits, reaction
        v, omega = steer(vx, vy, yaw, *how)
        free = is_free(setup.footprint, costmap, view, v, omega)
        if free and v > 0:
            return Control(v, omega)
        # It faces its target point. (Facing the direction of the force, it
        # would sway with each person who steps in front of it.)
        dx, dy = x - float(view.robot[X]), y - float(view.robot[Y])
        _, omega = steer(dx, dy, yaw, *how)
        if free or abs(wrap_angle(math.atan2(dy, dx) - yaw)) > 0.1:
            return Control(0.0, omega)
        return Control(0.0, 0.0, fault="something is in the way")


# The parameters of people.
_PARAMETERS = np.array(
    [getattr(SocialForceParameters(), name) for name in PARAMETERS]
)
_PARAMETERS.setflags(write=False)
