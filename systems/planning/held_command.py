"""The LeafSystem that holds a command."""

from numpy.typing import ArrayLike
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from hunav_drake.systems.common.checks import check_command
from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.planning.planner import (
    NO_PATH,
    PlannerStatus,
    PlanningTask,
)


class HeldCommand(LeafSystem):
    """Gives the command that `SetCommand` has set last.

    .. pydrake_system::

        name: HeldCommand
        input_ports:
        - robot_state
        - human_states
        - goal
        - scan
        output_ports:
        - velocity_command
        - status
        - path

    The inputs are those of any planner, and are not read; there is a ``scan``
    only if it is given a size. Port
    ``velocity_command`` gives (v, omega), in m/s and rad/s, ``status`` the
    `PlannerStatus` DRIVING, and ``path`` no points.

    The discrete state holds (v, omega), at first zeros. It only changes by
    `SetCommand`.
    """

    def __init__(self, task: PlanningTask, scan_size: int = 0) -> None:
        """Constructs a HeldCommand."""
        super().__init__()
        size = STATE_SIZE * task.num_humans
        self.DeclareVectorInputPort("robot_state", STATE_SIZE)
        self.DeclareVectorInputPort("human_states", size)
        self.DeclareVectorInputPort("goal", 3)
        if scan_size:
            self.DeclareVectorInputPort("scan", scan_size)
        self._command = self.DeclareDiscreteState(2)
        self.DeclareStateOutputPort("velocity_command", self._command)
        self.DeclareVectorOutputPort(
            "status",
            1,
            self._CalcStatus,
            prerequisites_of_calc={self.nothing_ticket()},
        )
        self.DeclareAbstractOutputPort(
            "path",
            alloc=lambda: AbstractValue.Make(NO_PATH),
            calc=self._CalcPath,
            prerequisites_of_calc={self.nothing_ticket()},
        )

    def SetCommand(self, context: Context, command: ArrayLike) -> None:
        """Sets the command (v, omega), in m/s and rad/s.

        Raises:
            ValueError: If these are not two finite numbers.
        """
        self.ValidateContext(context)
        context.SetDiscreteState(self._command, check_command(command))

    def _CalcStatus(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, float(PlannerStatus.DRIVING))

    def _CalcPath(self, context: Context, output: AbstractValue) -> None:
        output.set_value(NO_PATH)
