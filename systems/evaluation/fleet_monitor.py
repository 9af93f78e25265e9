"""The LeafSystem that detects the end of a trial with several robots."""

from collections.abc import Sequence
import math

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    InputPort,
    OutputPort,
)

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.evaluation.trial_monitor import (
    StepMonitor,
    TrialStatus,
)

_RUNS = float(TrialStatus.RUNNING)


class FleetMonitor(StepMonitor):
    """Detects the end of each robot, and of the trial when all have ended.

    .. pydrake_system::

        name: FleetMonitor
        input_ports:
        - statuses
        - planner_statuses
        output_ports:
        - trial_status
        - robot_ends

    Port ``statuses`` takes the `TrialStatus` of each robot alone, from a
    `TrialMonitor`, and ``planner_statuses`` the status of each planner. The
    first status that is not RUNNING is the end of that robot, whatever happens
    to it later; robots without a goal do not count.

    Port ``trial_status`` gives RUNNING until all robots have ended, then the
    worst end: GOAL, STUCK, PLANNER_FAILED. Port ``robot_ends`` gives a row
    (status, time) for each robot, with the time of its end in seconds; -1 for
    none.

    The discrete state holds these rows; a second group holds the time of the
    last update.
    """

    def __init__(
        self,
        has_goal: Sequence[bool],
        *,
        planner_error: int,
        time_step: float = 0.05,
    ) -> None:
        """Constructs a FleetMonitor.

        Args:
            has_goal: Whether each robot has a goal.
            planner_error: The status of a planner that has failed.
            time_step: The period of the trial, in seconds.

        Raises:
            ValueError: If ``time_step`` is not positive.
        """
        super().__init__(time_step)
        self._planner_error = planner_error
        self._counts = np.array(has_goal, dtype=np.bool_)
        m = len(has_goal)
        self._statuses = self.DeclareVectorInputPort("statuses", m)
        self._planners = self.DeclareVectorInputPort("planner_statuses", m)
        nothing = np.tile([float(TrialStatus.RUNNING), -1.0], m)
        self._ends = self.DeclareDiscreteState(nothing)
        self._updated = self.DeclareDiscreteState([-math.inf])
        self._trial_status = self.DeclareVectorOutputPort(
            "trial_status", 1, self._CalcStatus
        )
        self._robot_ends = self.DeclareVectorOutputPort(
            "robot_ends", 2 * m, self._CalcEnds
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=time_step, offset_sec=0.0, update=self._Update
        )

    def get_statuses_input_port(self) -> InputPort:
        """Returns the port with the status of each robot."""
        return self._statuses

    def get_planner_statuses_input_port(self) -> InputPort:
        """Returns the port with the status of each planner."""
        return self._planners

    def get_trial_status_output_port(self) -> OutputPort:
        """Returns the port with the status of the trial."""
        return self._trial_status

    def get_robot_ends_output_port(self) -> OutputPort:
        """Returns the port with the ends of the robots."""
        return self._robot_ends

    def GetEnds(self, context: Context) -> Array:
        """Returns the ends before this step: rows as of ``robot_ends``."""
        self.ValidateContext(context)
        ends: Array = context.get_discrete_state(self._ends).CopyToVector()
        return ends.reshape(-1, 2)

    def _CalcStatus(self, context: Context, output: BasicVector) -> None:
        rows = self._robot_ends.Eval(context).reshape(-1, 2)
        statuses = rows[self._counts, 0]
        runs = not len(statuses) or (statuses == _RUNS).any()
        output.SetAtIndex(0, _RUNS if runs else statuses.max())

    def _CalcEnds(self, context: Context, output: BasicVector) -> None:
        rows = self.GetEnds(context)
        statuses = self._statuses.Eval(context)
        failed = self._planners.Eval(context) == self._planner_error
        statuses[failed] = TrialStatus.PLANNER_FAILED
        new = (rows[:, 0] == _RUNS) & (statuses != _RUNS)
        rows[new, 0] = statuses[new]
        rows[new, 1] = context.get_time()
        output.SetFromVector(rows.ravel())

    def _Update(self, context: Context, state: DiscreteValues) -> None:
        state.set_value(self._updated, [context.get_time()])
        state.set_value(self._ends, self._robot_ends.Eval(context))
