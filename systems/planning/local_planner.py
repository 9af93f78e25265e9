"""The LeafSystem that drives the robot."""

import dataclasses
import math

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
)

from hunav_drake.systems.common.checks import check_count, count_steps
from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.planning.planner import (
    PLANNERS,
    Plan,
    Planner,
    PlannerStatus,
    PlanningTask,
)


class LocalPlanner(LeafSystem):
    """Drives a robot to a goal with one of the planners.

    .. pydrake_system::

        name: LocalPlanner
        input_ports:
        - robot_state
        - human_states
        - goal
        output_ports:
        - velocity_command
        - status

    Every ``task.period`` the planner decides a command from what it sees at
    that instant; the robot gets it one ``time_step`` later, and until the
    next one. Before the first command, the ports give zeros.

    Port ``robot_state`` takes the row (x, y, yaw, vx, vy, omega, radius) of
    the robot, ``human_states`` n such rows of the people, in W, in SI units.
    Port ``goal`` takes (x, y, yaw), in meters and radians; while it is not
    connected, the robot stays where it is. Port ``velocity_command`` gives
    (v, omega) in m/s and rad/s, and ``status`` a `PlannerStatus`.

    The discrete state holds (v, omega, status) and the planner's memory.
    """

    def __init__(
        self,
        planner: Planner,
        task: PlanningTask,
        *,
        num_humans: int,
        time_step: float = 0.05,
    ) -> None:
        """Constructs a LocalPlanner.

        Args:
            planner: What decides.
            task: What it is to know of the robot and the world.
            num_humans: How many people port ``human_states`` has.
            time_step: The time between two updates, in seconds. The system
                is updated that often, whatever the period, so that all of a
                trial moves at the same instants.

        Raises:
            ValueError: If ``time_step`` is not positive or the period not a
                multiple of it, or ``num_humans`` is negative.
        """
        super().__init__()
        self._ticks_per_cycle = count_steps(task.period, time_step)
        self._planner = planner
        self._task = task
        self._time_step = time_step

        self._robot_state = self.DeclareVectorInputPort(
            "robot_state", STATE_SIZE
        )
        self._human_states = self.DeclareVectorInputPort(
            "human_states", check_count("num_humans", num_humans) * STATE_SIZE
        )
        self._goal = self.DeclareVectorInputPort("goal", 3)
        self._state = self.DeclareDiscreteState(3 + planner.memory_size)
        ticket = self.discrete_state_ticket(self._state)
        self._velocity_command = self.DeclareVectorOutputPort(
            "velocity_command",
            2,
            self._CalcVelocityCommand,
            prerequisites_of_calc={ticket},
        )
        self._status = self.DeclareVectorOutputPort(
            "status", 1, self._CalcStatus, prerequisites_of_calc={ticket}
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=time_step, offset_sec=0.0, update=self._Update
        )

    def get_robot_state_input_port(self) -> InputPort:
        """Returns the port with the state of the robot."""
        return self._robot_state

    def get_human_states_input_port(self) -> InputPort:
        """Returns the port with the states of the people."""
        return self._human_states

    def get_goal_input_port(self) -> InputPort:
        """Returns the port with the pose to reach."""
        return self._goal

    def get_velocity_command_output_port(self) -> OutputPort:
        """Returns the port with the wanted speed and turn rate."""
        return self._velocity_command

    def get_status_output_port(self) -> OutputPort:
        """Returns the port that tells what the planner is doing."""
        return self._status

    def DescribeMemory(self) -> list[str]:
        """Returns what the state depends on: the planner and its parameters.

        A planner that is not a dataclass is told by its class alone.
        """
        planner = self._planner
        kind = type(planner)
        name = next(
            (name for name, part in PLANNERS.items() if part is kind), ""
        )
        parameters = ""
        if dataclasses.is_dataclass(planner):
            parameters = ", ".join(
                f"{field.name}={getattr(planner, field.name)!r}"
                for field in dataclasses.fields(planner)
            )
        return [f"of planner {name or kind.__qualname__}({parameters})"]

    def _CalcVelocityCommand(
        self, context: Context, output: BasicVector
    ) -> None:
        state = context.get_discrete_state(self._state).value()
        output.SetFromVector(state[:2])

    def _CalcStatus(self, context: Context, output: BasicVector) -> None:
        state = context.get_discrete_state(self._state).value()
        output.SetFromVector(state[2:3])

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        tick = round(context.get_time() / self._time_step)
        if tick % self._ticks_per_cycle:
            return
        if not self._goal.HasValue(context):
            state = np.zeros(3 + self._planner.memory_size)
            state[2] = PlannerStatus.IDLE
            discrete_state.set_value(self._state, state)
            return
        memory = context.get_discrete_state(self._state).value()[3:].copy()
        plan = self._planner.plan(
            self._task,
            self._robot_state.Eval(context),
            self._human_states.Eval(context).reshape(-1, STATE_SIZE),
            self._goal.Eval(context),
            memory,
        )
        if not isinstance(plan, Plan):
            raise RuntimeError(
                f"{self.GetSystemPathname()}, t = {context.get_time():.3f} s:"
                f" {type(self._planner).__name__}.plan() must give a Plan, got"
                f" {plan!r:.80}"
            )
        finite = math.isfinite(plan.v) and math.isfinite(plan.omega)
        if not finite or len(plan.memory) != len(memory):
            raise RuntimeError(
                f"{self.GetSystemPathname()}, t = {context.get_time():.3f} s:"
                f" {type(self._planner).__name__}.plan() must give finite v and"
                f" omega and a memory of {len(memory)} numbers, got {plan}"
            )
        discrete_state.set_value(
            self._state, [plan.v, plan.omega, plan.status, *plan.memory]
        )
