"""The LeafSystem that decides what many people do."""

from collections.abc import Sequence
import itertools

import numpy as np
from numpy.typing import ArrayLike, NDArray
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
from hunav_drake.systems.people.names import name_people
from hunav_drake.systems.world.obstacles import Obstacles


class BehaviorTreeBank(LeafSystem):
    """Ticks the behavior trees of many people, once in each step.

    .. pydrake_system::

        name: BehaviorTreeBank
        input_ports:
        - human_states
        - robot_state
        output_ports:
        - commands
        - behavior_status

    It does what a `BehaviorTree` for each person does, number for number, in
    a quarter of the time where there are a thousand people: what a system
    costs, whatever it does, comes once.

    Ports ``human_states`` and ``robot_state`` are those of `BehaviorTree`.
    Port ``commands`` gives the n commands, one after the other, laid out as
    `layout.Command`, and ``behavior_status`` the n numbers of that name.

    The discrete state holds the memories of the n trees, one after the other.
    It is updated every ``time_step``.
    """

    def __init__(
        self,
        trees: Sequence[Tree],
        humans: Sequence[HumanConfig],
        *,
        num_robots: int = 1,
        time_step: float = 0.05,
        obstacles: Obstacles | None = None,
    ) -> None:
        """Constructs a BehaviorTreeBank.

        Args:
            trees: One for each person; people may share a tree.
            humans: The people, in the order of ``human_states``. Those without
                a number have that of `people_ids`.
            num_robots: How many robots ``robot_state`` has.
            time_step: The time between two ticks, in seconds.
            obstacles: The walls that people cannot see through; none by
                default.

        Raises:
            ValueError: If there are not as many trees as people, or
                ``time_step`` is not positive, or ``num_robots`` negative.
        """
        super().__init__()
        if len(trees) != len(humans):
            raise ValueError(
                f"there must be a tree for each of {len(humans)} people, got"
                f" {len(trees)}"
            )
        check_time_step(time_step)
        check_count("num_robots", num_robots)
        n = len(humans)
        self._people = [
            (
                tree,
                Person.from_config(
                    human, i, time_step=time_step, obstacles=obstacles
                ),
            )
            for i, (tree, human) in enumerate(
                zip(trees, name_people(humans), strict=True)
            )
        ]
        memories = [tree.initial_memory(p) for tree, p in self._people]
        ends = np.cumsum([0, *map(len, memories)]).tolist()
        self._slices = [slice(a, b) for a, b in itertools.pairwise(ends)]
        self._no_robots = np.zeros(0)

        self._human_states = self.DeclareVectorInputPort(
            "human_states", n * STATE_SIZE
        )
        self._robot_state = DeclareRobotState(self, num_robots)
        self._memory = self.DeclareDiscreteState(
            np.array([number for memory in memories for number in memory])
        )
        tick = self.DeclareCacheEntry(
            "tick",
            ValueProducer(
                allocate=lambda: Value(object()), calc=weakly(self._CalcTick)
            ),
            prerequisites_of_calc={
                self.discrete_state_ticket(self._memory),
                self.all_input_ports_ticket(),
            },
        )
        self._tick = tick.cache_index()
        self._commands = self.DeclareVectorOutputPort(
            "commands",
            n * COMMAND_SIZE,
            self._CalcCommands,
            prerequisites_of_calc={tick.ticket()},
        )
        self._behavior_status = self.DeclareVectorOutputPort(
            "behavior_status",
            n,
            self._CalcBehaviorStatus,
            prerequisites_of_calc={tick.ticket()},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=time_step, offset_sec=0.0, update=self._Update
        )

    def trees(self) -> list[Tree]:
        """Returns the trees, in the order of the people."""
        return [tree for tree, _ in self._people]

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

    def get_commands_output_port(self) -> OutputPort:
        """Returns the port with what the people want."""
        return self._commands

    def get_behavior_status_output_port(self) -> OutputPort:
        """Returns the port with the states of the people's reactions."""
        return self._behavior_status

    def GetMemory(self, context: Context, index: int) -> NDArray[np.float64]:
        """Returns what a person has in mind.

        Args:
            context: Of this system.
            index: The row of the person in ``human_states``.

        Returns:
            The memory of the person's tree, whose layout `Tree.Describe()`
            prints; a copy.

        Raises:
            IndexError: If there is no such person.
        """
        memory = context.get_discrete_state(self._memory).value()
        own: NDArray[np.float64] = memory[self._slices[index]].copy()
        return own

    def SetMemory(
        self, context: Context, index: int, memory: ArrayLike
    ) -> None:
        """Makes a person have something else in mind.

        Args:
            context: Of this system, changed.
            index: The row of the person in ``human_states``.
            memory: What `GetMemory` gave, perhaps of another context.

        Raises:
            IndexError: If there is no such person.
            ValueError: If it is not as long as the memory of that tree.
        """
        own = self._slices[index]
        rows = np.asarray(memory, dtype=float)
        if rows.shape != (own.stop - own.start,):
            raise ValueError(
                f"the memory of humans[{index}] has shape"
                f" ({own.stop - own.start},), got {rows.shape}"
            )
        whole = context.get_discrete_state(self._memory).value().copy()
        whole[own] = rows
        context.SetDiscreteState(self._memory, whole)

    def _CalcTick(self, context: Context, value: AbstractValue) -> None:
        memory = context.get_discrete_state(self._memory).value().tolist()
        states = self._human_states.Eval(context)
        robots = (
            self._no_robots
            if self._robot_state is None
            else self._robot_state.Eval(context)
        )
        value.set_value(
            [
                tree.tick(person, memory[own], states, robots)
                for (tree, person), own in zip(
                    self._people, self._slices, strict=True
                )
            ]
        )

    def _EvalTick(self, context: Context) -> list[Outcome]:
        outcomes: list[Outcome] = self.get_cache_entry(self._tick).Eval(context)
        return outcomes

    def _CalcCommands(self, context: Context, output: BasicVector) -> None:
        commands = [outcome.command for outcome in self._EvalTick(context)]
        output.SetFromVector(np.array(commands, dtype=float).ravel())

    def _CalcBehaviorStatus(
        self, context: Context, output: BasicVector
    ) -> None:
        output.SetFromVector(
            [outcome.behavior_status for outcome in self._EvalTick(context)]
        )

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        memory = [
            number
            for outcome in self._EvalTick(context)
            for number in outcome.memory
        ]
        discrete_state.set_value(self._memory, memory)
