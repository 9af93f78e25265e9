"""The LeafSystem that detects the end of a trial."""

from enum import IntEnum
import math
from typing import Any

from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteStateIndex,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
)

from hunav_drake.systems.common.checks import check_number, check_time_step
from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.layout import STATE_SIZE, YAW, X, Y
from hunav_drake.systems.common.ports import GoalOf
from hunav_drake.systems.common.poses import is_at_goal


@explain
class TrialStatus(IntEnum):
    """Status of a trial: running, or how it ended."""

    RUNNING = 0
    """The trial is running."""

    GOAL = 1
    """The robot has reached its goal."""

    STUCK = 2
    """The robot has a goal, but has not made progress for too long."""

    PLANNER_FAILED = 3
    """The planner of the robot has raised an error."""


class StepMonitor(LeafSystem):
    """Base class of monitors that tell the instants of a trial's steps.

    A subclass sets its state `_updated` to the time of each update.
    """

    def __init__(self, time_step: float) -> None:
        """Constructs a StepMonitor; `time_step` is in seconds.

        Raises:
            ValueError: If it is not positive.
        """
        super().__init__()
        self._time_step = check_time_step(time_step)
        self._updated: Any = None

    def HasUpdated(self, context: Context) -> bool:
        """Returns whether the updates of the current instant are done.

        Drake runs them at the start of the next step, or when
        `Simulator.AdvanceTo` is called with the current time. A simulator may
        begin just after them.
        """
        self.ValidateContext(context)
        time = context.get_discrete_state(self._updated).GetAtIndex(0)
        return bool(0 <= context.get_time() - time <= 1e-9 * self._time_step)

    def IsStep(self, context: Context) -> bool:
        """Returns whether the current instant is one of the updates.

        Between two updates, the state already belongs to the next one, so no
        trial ends there.
        """
        self.ValidateContext(context)
        time = context.get_time()
        return bool(time == round(time / self._time_step) * self._time_step)


class TrialMonitor(StepMonitor):
    """Detects the end of a trial: the goal is reached, or the robot is stuck.

    .. pydrake_system::

        name: TrialMonitor
        input_ports:
        - robot_state
        - goal
        output_ports:
        - trial_status

    The goal is reached while the robot is within both tolerances of it. The
    robot is stuck when it has stayed within ``stuck_distance`` of one place
    for ``stuck_time``, on its way to a goal: the time begins anew while there
    is no goal, or it is reached.

    Port ``robot_state`` takes the row (x, y, yaw, vx, vy, omega, radius) of the
    robot, in W, in SI units, and ``goal`` takes (x, y, yaw), in meters and
    radians; while it is not connected or not finite, there is no goal, and the
    trial is running. Port ``trial_status`` gives the current `TrialStatus`.

    The discrete state holds the place (x, y), the time since when the robot has
    been near it, and 1 once there is such a place. A second group holds the
    time of the last update.
    """

    def __init__(
        self,
        *,
        goal_tolerance: float,
        goal_yaw_tolerance: float,
        stuck_time: float = 30.0,
        stuck_distance: float = 0.5,
        time_step: float = 0.05,
    ) -> None:
        """Constructs a TrialMonitor; all in SI units and radians.

        Raises:
            ValueError: If a tolerance is negative, or another number is not
                positive.
        """
        super().__init__(time_step)
        self._goal_tolerance = check_number(
            "goal_tolerance", goal_tolerance, "m"
        )
        self._goal_yaw_tolerance = check_number(
            "goal_yaw_tolerance", goal_yaw_tolerance, "rad"
        )
        self._stuck_time = check_number(
            "stuck_time", stuck_time, "s", low_open=True
        )
        self._stuck_distance = check_number(
            "stuck_distance", stuck_distance, "m", low_open=True
        )
        self._robot_state = self.DeclareVectorInputPort(
            "robot_state", STATE_SIZE
        )
        self._goal = self.DeclareVectorInputPort("goal", 3)
        # (Numbers are found faster by an integer than by a typed index.)
        self._state = int(self.DeclareDiscreteState(4))
        self._updated = int(self.DeclareDiscreteState([-math.inf]))
        self._status = self.DeclareVectorOutputPort(
            "trial_status",
            1,
            self._CalcStatus,
            prerequisites_of_calc={
                self.time_ticket(),
                self.discrete_state_ticket(DiscreteStateIndex(self._state)),
                self.all_input_ports_ticket(),
            },
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=time_step, offset_sec=0.0, update=self._Update
        )

    def get_robot_state_input_port(self) -> InputPort:
        """Returns the port with the state of the robot."""
        return self._robot_state

    def get_goal_input_port(self) -> InputPort:
        """Returns the port with the goal pose."""
        return self._goal

    def get_trial_status_output_port(self) -> OutputPort:
        """Returns the port with the status of the trial."""
        return self._status

    def _CalcStatus(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, self._EvalStatus(context))

    def _EvalStatus(self, context: Context) -> TrialStatus:
        goal = GoalOf(self._goal, context)
        if goal is None:
            return TrialStatus.RUNNING
        x, y, yaw = self._EvalPose(context)
        if is_at_goal(
            (x, y, yaw),
            goal,
            tolerance=self._goal_tolerance,
            yaw_tolerance=self._goal_yaw_tolerance,
        ):
            return TrialStatus.GOAL
        near_x, near_y, since, known = self._GetPlace(context)
        if (
            known
            and math.hypot(near_x - x, near_y - y) <= self._stuck_distance
            and context.get_time() - since >= self._stuck_time
        ):
            return TrialStatus.STUCK
        return TrialStatus.RUNNING

    def _EvalPose(self, context: Context) -> tuple[float, float, float]:
        """Returns the (x, y, yaw) of the robot."""
        # (A view of the vector takes longer than a few numbers.)
        robot = self._robot_state.EvalBasicVector(context)
        return robot.GetAtIndex(X), robot.GetAtIndex(Y), robot.GetAtIndex(YAW)

    def _GetPlace(self, context: Context) -> tuple[float, float, float, float]:
        """Returns the place (x, y), since when, and whether there is one."""
        get = context.get_discrete_state(self._state).GetAtIndex
        return get(0), get(1), get(2), get(3)

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        now = context.get_time()
        discrete_state.get_mutable_vector(self._updated).SetAtIndex(0, now)
        x, y, _ = self._EvalPose(context)
        near_x, near_y, _, known = self._GetPlace(context)
        moved = math.hypot(near_x - x, near_y - y)
        waits = (
            GoalOf(self._goal, context) is None
            or self._status.EvalBasicVector(context).GetAtIndex(0)
            == TrialStatus.GOAL
        )
        if waits or not known or moved > self._stuck_distance:
            discrete_state.set_value(self._state, [x, y, now, 1.0])
