"""Regulated pursuit: straight to the goal, slower before obstacles."""

import math
from typing import Annotated, Any

from pydantic import StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.layout import YAW
from hunav_drake.systems.common.poses import wrap_angle
from hunav_drake.systems.common.schema import (
    CONFIG,
    Length,
    PositiveLength,
    PositiveSpeed,
    within,
)
from hunav_drake.systems.planning.clearance import clearance_ahead, people_ahead
from hunav_drake.systems.planning.planner import (
    Plan,
    PlannerStatus,
    PlanningTask,
    View,
    register_planner,
)
from hunav_drake.systems.planning.pure_planner import Planner
from hunav_drake.systems.planning.scanned_bodies import BODY_RADIUS, bodies


@register_planner("pursuit")
@dataclass(kw_only=True, config=CONFIG)
class PursuitPlanner(Planner):
    """Drives straight to the goal; slows and stops before obstacles.

    The robot turns in place towards a goal that lies off its heading, and
    otherwise steers towards it while driving. Its speed is lower in turns, near
    the goal, and before people and walls in its lane, so that it can always
    stop `stop_distance` short of them. It does not drive around obstacles.
    """

    cruise_speed: PositiveSpeed = 0.6
    """Speed on a free path, in m/s. The robot's own limit holds, too."""

    heading_gain: Annotated[
        StrictFloat, within(0, 100, "1/s", low_open=True)
    ] = 2.0
    """Turn rate per angle to the goal, in 1/s."""

    turn_in_place_angle: Annotated[
        StrictFloat, within(0, math.pi, "rad", low_open=True)
    ] = 0.8
    """Angle to the goal above which the robot turns in place first, in radians.
    """

    stop_distance: Length = 0.3
    """Distance kept from obstacles ahead, in meters."""

    side_margin: Length = 0.1
    """Margin on each side of the robot that must be free of people, in meters.
    """

    lookahead: PositiveLength = 3.0
    """Range of the obstacle check ahead, in meters."""

    deceleration: Annotated[
        StrictFloat, within(0, 100, "m/s^2", low_open=True)
    ] = 0.5
    """Deceleration before obstacles, in m/s^2. The robot's own limit holds,
    too."""

    def plan(self, task: PlanningTask, view: View, memory: Any) -> Plan:
        """Decides the command of one cycle: see `Planner.plan`."""
        x, y, yaw = view.robot[:3].tolist()
        goal_x, goal_y, goal_yaw = view.goal.tolist()
        distance = math.hypot(goal_x - x, goal_y - y)
        # Well within the tolerance, so that the trial counts the goal as
        # reached.
        if distance <= 0.5 * task.goal_tolerance:
            return self._turn_at_goal(task, wrap_angle(goal_yaw - yaw))

        bearing = wrap_angle(math.atan2(goal_y - y, goal_x - x) - yaw)
        omega = self._turn_rate(task, bearing)
        if abs(bearing) > self.turn_in_place_angle:
            return Plan(0.0, omega, PlannerStatus.DRIVING)

        braking = min(self.deceleration, task.limits.max_acceleration)
        wanted = min(self.cruise_speed, task.limits.max_speed)
        wanted *= math.cos(bearing)
        wanted = min(wanted, self._stoppable(task, distance, braking))
        wanted = min(wanted, distance / self.reaction_time(task))
        free = self._free_way(task, view) - self.stop_distance
        # The distance driven before the next command counts as used up.
        free = max(free - wanted * self.period, 0.0)
        v = min(wanted, math.sqrt(2 * braking * free))
        if v < 0.01:
            return Plan(0.0, omega, PlannerStatus.BLOCKED)
        slowed = v < wanted
        status = PlannerStatus.SLOWED if slowed else PlannerStatus.DRIVING
        return Plan(v, omega, status)

    def _turn_at_goal(self, task: PlanningTask, error: float) -> Plan:
        """Returns the turn to the heading of the goal, if it matters."""
        if abs(error) <= 0.5 * task.goal_yaw_tolerance:
            return Plan(0.0, 0.0, PlannerStatus.ARRIVED)
        omega = self._turn_rate(task, error)
        return Plan(0.0, omega, PlannerStatus.DRIVING)

    def _turn_rate(self, task: PlanningTask, error: float) -> float:
        """Returns the turn rate for a remaining angle, in rad/s."""
        gain = min(self.heading_gain, 1 / self.reaction_time(task))
        most = task.limits.max_turn_rate
        if self.period > task.time_step:
            braking = task.limits.max_turn_acceleration
            most = min(most, self._stoppable(task, abs(error), braking))
        return min(max(gain * error, -most), most)

    def _stoppable(
        self, task: PlanningTask, way: float, braking: float
    ) -> float:
        """Returns the rate from which it can stop within a distance.

        Between two commands, except for one time step, it cannot react.
        """
        blind = braking * (self.period - task.time_step)
        return math.sqrt(blind * blind + 2 * braking * way) - blind

    def _free_way(self, task: PlanningTask, view: View) -> float:
        """Returns the free distance straight ahead, in meters."""
        x, y, yaw = view.robot[: YAW + 1].tolist()
        free: float = clearance_ahead(
            *(x, y, yaw, task.robot_radius),
            *(self.lookahead, task.obstacles.table),
        )
        people: float = people_ahead(
            *(x, y, math.cos(yaw), math.sin(yaw)),
            *(task.robot_radius, self.side_margin),
            bodies(task, view, self.lookahead + BODY_RADIUS),
        )
        return min(free, people)
