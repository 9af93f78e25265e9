"""The LeafSystem that runs a pure planner."""

import dataclasses
import inspect

from numpy.typing import ArrayLike
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteStateIndex,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
    State,
)

from hunav_drake.systems.common.checks import (
    check_command,
    check_count,
    count_steps,
)
from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.common.ports import CopyOf, GoalOf, weakly
from hunav_drake.systems.common.registry import known_name
from hunav_drake.systems.planning.cycles import (
    CycleTimeout,
    call_cycle,
    time_cycles,
)
from hunav_drake.systems.planning.decision import (
    Decision,
    idle,
    memory_fault,
    plan_fault,
)
from hunav_drake.systems.planning.planner import (
    NO_PATH,
    Plan,
    PlannerStatus,
    PlanningTask,
    PurePlanner,
    View,
    asked_scan_size,
)
from hunav_drake.systems.planning.planner_error import PlannerError, told

__all__ = ["LocalPlanner", "time_cycles"]


class LocalPlanner(LeafSystem):
    """Drives a robot to a goal with one of the planners.

    .. pydrake_system::

        name: LocalPlanner
        input_ports:
        - robot_state
        - human_states
        - goal
        - scan
        output_ports:
        - velocity_command
        - status
        - path

    Every ``planner.period`` the planner decides a command from its observation
    at that instant. The robot gets it one ``task.time_step`` later, until the
    next one. Before the first command, the ports give zeros.

    Port ``robot_state`` takes the row (x, y, yaw, vx, vy, omega, radius) of the
    robot, ``human_states`` n such rows of the people, in W, in SI units. Port
    ``goal`` takes (x, y, yaw), in meters and radians; while it is not connected
    or not finite, there is no goal, and the robot does not move. Only a planner
    with a ``scan_size`` or with lidar perception has port ``scan``: distances,
    in meters. Port ``velocity_command`` gives (v, omega) in m/s and rad/s,
    ``status`` a `PlannerStatus`, and ``path`` the planned path of the last
    decision: a read-only array of shape (k, 2) or (k, 3), rows (x, y) or (x, y,
    yaw).

    The discrete state holds (v, omega, status). For a planner with memory, or
    that stops on an error, the abstract state holds its last plan.
    """

    def __init__(self, planner: PurePlanner, task: PlanningTask) -> None:
        """Constructs a LocalPlanner.

        The system is updated every ``task.time_step``, for any period, so that
        all parts of a trial move at the same instants.

        Raises:
            TypeError: If the planner's ``initial_memory`` is mutable, or its
                ``scan_size`` is not an integer.
            ValueError: If ``task.time_step`` is not positive or the period is
                not a multiple of it, if ``task.num_humans`` is negative, or if
                the planner needs a lidar and ``task.lidar`` is None.
        """
        super().__init__()
        self._ticks_per_cycle = count_steps(planner.period, task.time_step)
        self._planner = planner
        self._name = _name_of(planner)
        _check_planner(planner, self._name)
        self._task = task

        self._robot_state = self.DeclareVectorInputPort(
            "robot_state", STATE_SIZE
        )
        num_humans = check_count("num_humans", task.num_humans)
        self._human_states = self.DeclareVectorInputPort(
            "human_states", num_humans * STATE_SIZE
        )
        self._goal = self.DeclareVectorInputPort("goal", 3)
        scan_size = _scan_size(planner, task)
        self._scan = (
            self.DeclareVectorInputPort("scan", scan_size)
            if scan_size
            else None
        )
        # (Numbers are found faster by an integer than by a typed index.)
        self._state = int(self.DeclareDiscreteState(3))
        ticket = self.discrete_state_ticket(DiscreteStateIndex(self._state))
        self._velocity_command = self.DeclareVectorOutputPort(
            "velocity_command",
            2,
            self._CalcVelocityCommand,
            prerequisites_of_calc={ticket},
        )
        self._status = self.DeclareVectorOutputPort(
            "status", 1, self._CalcStatus, prerequisites_of_calc={ticket}
        )
        self._idle = idle(planner.initial_memory)
        self._decision = None
        # (A failure is stored with its reason.)
        if planner.initial_memory is not None or task.on_error == "stop":
            self._decision = self.DeclareAbstractState(
                AbstractValue.Make(self._idle)
            )
            # At an instant, Drake runs this update first. Systems that are
            # updated with the one below still see the old command.
            self.DeclarePeriodicUnrestrictedUpdateEvent(
                period_sec=task.time_step, offset_sec=0.0, update=self._Decide
            )
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=task.time_step, offset_sec=0.0, update=self._Command
        )
        self._path = self.DeclareAbstractOutputPort(
            "path",
            alloc=lambda: AbstractValue.Make(NO_PATH),
            calc=weakly(self._CalcPath),
            prerequisites_of_calc={self.xa_ticket()},
        )

    def get_robot_state_input_port(self) -> InputPort:
        """Returns the port with the state of the robot."""
        return self._robot_state

    def get_human_states_input_port(self) -> InputPort:
        """Returns the port with the states of the people."""
        return self._human_states

    def get_goal_input_port(self) -> InputPort:
        """Returns the port with the goal pose."""
        return self._goal

    def get_velocity_command_output_port(self) -> OutputPort:
        """Returns the port with the commanded speed and turn rate."""
        return self._velocity_command

    def get_status_output_port(self) -> OutputPort:
        """Returns the port with the planner's status."""
        return self._status

    def get_path_output_port(self) -> OutputPort:
        """Returns the port with the planned path."""
        return self._path

    def GetReason(self, context: Context) -> str:
        """Returns why the planner is not simply driving, as text.

        Empty while it drives, and for a planner without an `initial_memory`.
        """
        self.ValidateContext(context)
        return self._Decided(context).reason

    def SetCommand(self, context: Context, command: ArrayLike) -> None:
        """Sets the command (v, omega), in m/s and rad/s, until the next one.

        Raises:
            ValueError: If these are not two finite numbers.
        """
        self.ValidateContext(context)
        state = context.get_mutable_discrete_state(self._state)
        state.get_mutable_value()[:2] = check_command(command)

    def DescribeMemory(self) -> list[str]:
        """Returns what the state depends on: the planner and its parameters."""
        planner = self._planner
        parameters = ", ".join(
            f"{field.name}={getattr(planner, field.name)!r}"
            for field in dataclasses.fields(planner)
            if field.name not in ("cycle_limit", "localization")
        )
        return [f"of planner {self._name}({parameters})"]

    def _CalcVelocityCommand(
        self, context: Context, output: BasicVector
    ) -> None:
        state = context.get_discrete_state(self._state)
        output.SetAtIndex(0, state.GetAtIndex(0))
        output.SetAtIndex(1, state.GetAtIndex(1))

    def _CalcStatus(self, context: Context, output: BasicVector) -> None:
        state = context.get_discrete_state(self._state).value()
        output.SetFromVector(state[2:3])

    def _CalcPath(self, context: Context, output: AbstractValue) -> None:
        output.set_value(self._Decided(context).path)

    def _Decided(self, context: Context) -> Plan:
        """Returns the last plan; an idle one for a planner without memory."""
        if self._decision is None:
            return self._idle.plan
        value = context.get_abstract_state(self._decision).get_value()
        assert isinstance(value, Decision)
        return value.plan

    def _IsDue(self, context: Context) -> bool:
        tick: int = round(context.get_time() / self._task.time_step)
        return tick % self._ticks_per_cycle == 0

    def _Plan(self, context: Context) -> Plan:
        """Returns the planner's decision now.

        Raises:
            PlannerError: If the planner fails or its plan is not valid.
        """
        if self._task.on_error == "raise":
            return self._MakePlan(context)
        last = self._Decided(context)
        if last.status == PlannerStatus.ERROR:
            return last
        try:
            return self._MakePlan(context)
        except PlannerError as error:
            return Plan(
                *(0.0, 0.0, PlannerStatus.ERROR, last.memory), reason=str(error)
            )

    def _MakePlan(self, context: Context) -> Plan:
        if GoalOf(self._goal, context) is None:
            return self._idle.plan
        planner, limit = self._planner, self._planner.cycle_limit
        arguments = (
            *(self._task, self._Look(context)),
            self._Decided(context).memory,
        )
        try:
            plan = call_cycle(planner.plan, arguments, limit)
        except CycleTimeout:
            reason = f"a cycle took longer than cycle_limit = {limit:g} s"
            raise self._Error(context, reason) from None
        except PlannerError as error:
            raise self._Error(context, error.reason) from error
        except Exception as error:
            method = getattr(type(planner), planner.decides_by)
            function = inspect.unwrap(method)
            code = getattr(function, "__code__", None)
            raise self._Error(context, told(error, code)) from error
        if fault := plan_fault(plan, keeps=self._decision is not None):
            reason = f"{type(planner).__name__}.plan() {fault}"
            raise self._Error(context, reason)
        assert isinstance(plan, Plan)
        return plan

    def _Error(self, context: Context, reason: str) -> PlannerError:
        return PlannerError(self._name, context.get_time(), reason)

    def _Decide(self, context: Context, state: State) -> None:
        if self._IsDue(context):
            plan = self._Plan(context)
            plan.path.setflags(write=False)
            decided = state.get_mutable_abstract_state(self._decision)
            decided.set_value(Decision(plan))

    def _Look(self, context: Context) -> View:
        humans = CopyOf(self._human_states, context).reshape(-1, STATE_SIZE)
        robot = CopyOf(self._robot_state, context)
        goal = CopyOf(self._goal, context)
        scan = None if self._scan is None else CopyOf(self._scan, context)
        for array in (robot, humans, goal, scan):
            if array is not None:
                array.setflags(write=False)
        return View(robot, humans, goal, scan, context.get_time())

    def _Command(
        self, context: Context, discrete_state: DiscreteValues
    ) -> None:
        if self._IsDue(context):
            keeps = self._decision is not None
            plan = self._Decided(context) if keeps else self._Plan(context)
            # (Drake converts a number in less time than an array.)
            row = discrete_state.get_mutable_vector(self._state)
            for i, number in enumerate((plan.v, plan.omega, plan.status)):
                row.SetAtIndex(i, number)


def _scan_size(planner: PurePlanner, task: PlanningTask) -> int:
    """Returns the number of lidar distances that a planner gets."""
    size = asked_scan_size(planner)
    if size is not None:
        return size
    if task.lidar is None:
        raise ValueError(
            f"{type(planner).__name__} needs a lidar: give its PlanningTask a"
            " LidarConfig"
        )
    return task.lidar.num_rays


def _name_of(planner: PurePlanner) -> str:
    return known_name(planner) or type(planner).__name__


def _check_planner(planner: PurePlanner, name: str) -> None:
    """Raises TypeError if a class variable of a planner is not valid."""
    if fault := memory_fault(planner.initial_memory):
        raise TypeError(f"planner {name!r}: initial_memory: it {fault}")
    size = planner.scan_size
    if size is None:
        return
    if not isinstance(size, int) or isinstance(size, bool) or size < 0:
        raise TypeError(
            f"planner {name!r}: scan_size must be a whole number of distances,"
            f" got {size!r:.80}"
        )
