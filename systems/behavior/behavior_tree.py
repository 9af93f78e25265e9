"""The LeafSystem that decides what a person does."""

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
    ValueProducer,
)

from hunav_drake.systems.behavior.nodes.tick_context import Person
from hunav_drake.systems.behavior.tree import Outcome, Tree
from hunav_drake.systems.common.callbacks import weakly
from hunav_drake.systems.common.checks import check_count, check_time_step
from hunav_drake.systems.common.layout import COMMAND_SIZE, STATE_SIZE
from hunav_drake.systems.common.ports import DeclareRobotState, RequirePort
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.world.obstacles import Obstacles


class BehaviorTree(LeafSystem):
    """Ticks the behavior tree of one person, once in each step.

    .. pydrake_system::

        name: BehaviorTree
        input_ports:
        - human_states
        - robot_state
        output_ports:
        - command
        - behavior_status
        - status

    Port ``human_states`` takes n rows (x, y, yaw, vx, vy, omega, radius) of
    all people, and ``robot_state`` m such rows of the robots, in W, in SI
    units: see `common.layout`. Without robots there is no port
    ``robot_state``. Port ``command`` gives what the person wants, laid out as
    `layout.Command`; ``behavior_status`` gives 0 while no reaction is active,
    else the state that it is in, most often 1: see `TickContext`. Port ``status``
    gives a number for each of `Tree.nodes`: what it says in the tick, 1 for
    running, 2 for success, 3 for failure, 4 for skipped, or 0 if it is not
    ticked; `RenderBehaviorTree` draws it. All belong to the present instant:
    they follow from the state and the inputs without delay. Where nobody looks
    at ``status``, it costs nothing.

    The discrete state holds the tree's memory: the index of the person's
    goal, what the nodes remember, and the blackboard. `Tree.Describe()`
    prints its layout. It is updated every ``time_step``.
    """

    def __init__(
        self,
        tree: Tree,
        human: HumanConfig,
        index: int,
        num_humans: int,
        *,
        num_robots: int = 1,
        time_step: float = 0.05,
        obstacles: Obstacles | None = None,
    ) -> None:
        """Constructs a BehaviorTree.

        Args:
            tree: The tree; it can be that of other people, too.
            human: The person; without a number, it has ``index + 1``.
            index: The row of the person in ``human_states``.
            num_humans: How many people ``human_states`` has.
            num_robots: How many robots ``robot_state`` has.
            time_step: The time between two ticks, in seconds.
            obstacles: The walls, all of which the person cannot see through,
                however low; none by default.

        Raises:
            ValueError: If ``index`` is not in [0, ``num_humans``),
                ``num_robots`` is negative, or ``time_step`` is not positive.
        """
        super().__init__()
        if not 0 <= index < num_humans:
            raise ValueError(
                f"index must be in [0, {num_humans}), the number of people,"
                f" got {index}"
            )
        check_count("num_robots", num_robots)
        check_time_step(time_step)
        self._tree = tree
        self._person = Person.from_config(
            human, index, time_step=time_step, obstacles=obstacles
        )
        self._no_robots = np.zeros(0)

        self._human_states = self.DeclareVectorInputPort(
            "human_states", num_humans * STATE_SIZE
        )
        self._robot_state = DeclareRobotState(self, num_robots)
        memory = tree.initial_memory(self._person)
        self._memory = self.DeclareDiscreteState(memory)
        # The time is not among them: a held state gives a held command.
        prerequisites = {
            self.discrete_state_ticket(self._memory),
            self.all_input_ports_ticket(),
        }
        # The one tick of a step, which both ports and the update read.
        tick = self.DeclareCacheEntry(
            "tick",
            ValueProducer(
                allocate=lambda: Value(object()), calc=weakly(self._CalcTick)
            ),
            prerequisites_of_calc=prerequisites,
        )
        self._tick = tick.cache_index()
        self._command = self.DeclareVectorOutputPort(
            "command",
            COMMAND_SIZE,
            self._CalcCommand,
            prerequisites_of_calc={tick.ticket()},
        )
        self._behavior_status = self.DeclareVectorOutputPort(
            "behavior_status",
            1,
            self._CalcBehaviorStatus,
            prerequisites_of_calc={tick.ticket()},
        )
        self._status = self.DeclareVectorOutputPort(
            "status",
            len(tree.nodes),
            self._CalcStatus,
            prerequisites_of_calc=prerequisites,
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=time_step, offset_sec=0.0, update=self._Update
        )

    def tree(self) -> Tree:
        """Returns the tree."""
        return self._tree

    def get_human_states_input_port(self) -> InputPort:
        """Returns the port with the states of the people."""
        return self._human_states

    def get_robot_state_input_port(self) -> InputPort:
        """Returns the port with the states of the robots.

        Raises:
            ValueError: If the system was made with no robots.
        """
        return RequirePort(
            self, self._robot_state, "robot_state", "num_robots=0"
        )

    def get_command_output_port(self) -> OutputPort:
        """Returns the port with what the person wants."""
        return self._command

    def get_behavior_status_output_port(self) -> OutputPort:
        """Returns the port with the state of the person's reaction."""
        return self._behavior_status

    def get_status_output_port(self) -> OutputPort:
        """Returns the port with what each node of the tree says."""
        return self._status

    def _CalcTick(self, context: Context, value: AbstractValue) -> None:
        value.set_value(self._tree.tick(*self._EvalTickArguments(context)))

    def _EvalTickArguments(
        self, context: Context
    ) -> tuple[Person, list[float], NDArray[np.float64], NDArray[np.float64]]:
        robots = self._robot_state
        # Views: Eval() would copy the states of everybody for everybody.
        return (
            self._person,
            context.get_discrete_state(self._memory).value().tolist(),
            self._human_states.EvalBasicVector(context).value(),
            self._no_robots
            if robots is None
            else robots.EvalBasicVector(context).value(),
        )

    def _EvalTick(self, context: Context) -> Outcome:
        outcome: Outcome = self.get_cache_entry(self._tick).Eval(context)
        return outcome

    def _CalcCommand(self, context: Context, output: BasicVector) -> None:
        # (Drake takes an array in half the time of a list.)
        output.SetFromVector(np.array(self._EvalTick(context).command))

    def _CalcBehaviorStatus(
        self, context: Context, output: BasicVector
    ) -> None:
        output.SetAtIndex(0, self._EvalTick(context).behavior_status)

    def _CalcStatus(self, context: Context, output: BasicVector) -> None:
        arguments = self._EvalTickArguments(context)
        _, statuses = self._tree.trace(*arguments)
        output.SetFromVector(np.array(statuses, dtype=float))

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        memory = np.array(self._EvalTick(context).memory)
        discrete_state.set_value(self._memory, memory)
