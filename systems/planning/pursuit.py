"""Regulated pursuit: straight to the goal, slower for what is in the way."""

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
    """Drives at the goal; slows and stops for what stands before it.

    The robot turns on the spot towards a goal that lies off to the side, and
    else steers at it while it drives. Its speed is regulated: down in turns,
    near the goal, and before people and walls in its lane, so that it can
    always stop `stop_distance` short of them. It does not drive around
    anything.
    """

    cruise_speed: PositiveSpeed = 0.6
    """The speed on a free way, in m/s; the robot's own limit holds too."""

    heading_gain: Annotated[
        StrictFloat, within(0, 100, "1/s", low_open=True)
    ] = 2.0
    """The turn rate per angle to the goal, in 1/s."""

    turn_in_place_angle: Annotated[
        StrictFloat, within(0, math.pi, "rad", low_open=True)
    ] = 0.8
    """A goal farther off the heading than this is first turned to, in radians.
    """

    stop_distance: Length = 0.3
    """The distance kept to what stands in the way, in meters."""

    side_margin: Length = 0.1
    """The room on each side of the robot that must be free of people, in
    meters."""

    lookahead: PositiveLength = 3.0
    """How far ahead it looks, in meters."""

    deceleration: Annotated[
        StrictFloat, within(0, 100, "m/s^2", low_open=True)
    ] = 0.5
    """How hard it brakes for what it sees, in m/s^2; the robot's own limit
    holds too."""

    def plan(self, task: PlanningTask, view: View, memory: Any) -> Plan:
        """Decides the command of one cycle: see `Planner.plan`."""
        x, y, yaw = view.robot[:3].tolist()
        goal_x, goal_y, goal_yaw = view.goal.tolist()
        distance = math.hypot(goal_x - x, goal_y - y)
        # Well inside, so that the trial sees the goal as reached.
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
        # What it drives on before the next command counts as used up.
        free = max(free - wanted * self.period, 0.0)
        v = min(wanted, math.sqrt(2 * braking * free))
        if v < 0.01:
            return Plan(0.0, omega, PlannerStatus.BLOCKED)
        slowed = v < wanted
        status = PlannerStatus.SLOWED if slowed else PlannerStatus.DRIVING
        return Plan(v, omega, status)

    def _turn_at_goal(self, task: PlanningTask, error: float) -> Plan:
        """Turns to the heading of the goal, if that matters."""
        if abs(error) <= 0.5 * task.goal_yaw_tolerance:
            return Plan(0.0, 0.0, PlannerStatus.ARRIVED)
        omega = self._turn_rate(task, error)
        return Plan(0.0, omega, PlannerStatus.DRIVING)

    def _turn_rate(self, task: PlanningTask, error: float) -> float:
        """Returns how fast it turns by what is left of an angle, in rad/s."""
        gain = min(self.heading_gain, 1 / self.reaction_time(task))
        most = task.limits.max_turn_rate
        if self.period > task.time_step:
            braking = task.limits.max_turn_acceleration
            most = min(most, self._stoppable(task, abs(error), braking))
        return min(max(gain * error, -most), most)

    def _stoppable(
        self, task: PlanningTask, way: float, braking: float
    ) -> float:
        """Returns the rate that can end on a way, though asked only so often.

        For the time between two commands, but for a step, it goes on blindly.
        """
        blind = braking * (self.period - task.time_step)
        return math.sqrt(blind * blind + 2 * braking * way) - blind

    def _free_way(self, task: PlanningTask, view: View) -> float:
        """Returns how far the robot can drive straight on, in meters."""
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
