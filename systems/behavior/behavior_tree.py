"""The LeafSystem that decides what people do."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteStateIndex,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
    ValueProducer,
)

from hunav_drake.systems.behavior.nodes.tick_context import (
    GOAL_INDEX,
    PERSON_MEMORY,
    SEED,
    Person,
)
from hunav_drake.systems.behavior.society import SocialOptions, Society
from hunav_drake.systems.behavior.tree import Tree
from hunav_drake.systems.behavior.walk import Walk
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import check_count, check_time_step
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    SIGNAL_SIZE,
    SILENT,
    STATE_SIZE,
    WHO,
    Signal,
)
from hunav_drake.systems.common.ports import (
    DeclareRobotStates,
    RequirePort,
    RobotStatesOf,
    weakly,
)
from hunav_drake.systems.common.random_streams import check_seed, seed_to_halves
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.names import people_ids
from hunav_drake.systems.people.places import complete_places
from hunav_drake.systems.world.obstacles import Obstacles

# The seed in the memory of a tree with social leaves.
_SEED = slice(len(PERSON_MEMORY) + SEED, len(PERSON_MEMORY) + SEED + 2)


class BehaviorTree(LeafSystem):
    """Ticks the behavior trees of people, once in each step.

    .. pydrake_system::

        name: BehaviorTree
        input_ports:
        - human_states
        - robot_states
        - social_signals (only with social leaves)
        - robot_signals (only with social leaves)
        output_ports:
        - commands
        - behavior_status
        - node_status
        - signals (only with social leaves)

    It ticks the trees of all people, or of the k people in ``indices``. One
    system per person shows each tree in the diagram; one system for all people
    gives the same numbers, in a quarter of the time for a thousand people.

    Port ``human_states`` takes n rows (x, y, yaw, vx, vy, omega, radius) of
    all people, and ``robot_states`` m such rows of the robots, in W, in SI
    units: see `common.layout`. Without robots there is no port
    ``robot_states``.

    Each output lists the k people one after the other. Port ``commands`` gives
    k rows, the command of each person, laid out as `layout.Command`. Port
    ``behavior_status`` gives k numbers: 0 while no reaction is active, else
    the state that it is in, most often 1: see `TickContext`. Port
    ``node_status`` gives a number for each of `Tree.nodes` of each person: its
    `NodeStatus` in the tick, 1 for running, 2 for success, 3 for failure, 4
    for skipped, or 0 if it is not ticked; `EvalNodeStatus` gives those of one
    person. All belong to the present instant: they follow from the state and
    the inputs without delay.

    If people take notice of what they show each other, port ``signals`` gives
    k rows, laid out as `layout.Signal`: what each has shown in the last tick,
    without feedthrough from any input. Port ``social_signals`` takes the n rows
    of all people, joined from these ports, and ``robot_signals`` the m rows of
    robots; if it is not connected, robots show nothing. What one says in a
    tick, others hear in the next.

    The discrete state holds the memories of the k trees, one after the other:
    the index of the person's goal, what the nodes remember, and the
    blackboard. `Tree.Describe()` prints the layout of each. A second group
    holds the signals, if there are any. Both are updated every ``time_step``.
    """

    # Whether people can be outside: see `OpenBehaviorTree`.
    _CAN_BE_OUTSIDE = False

    def __init__(
        self,
        trees: Sequence[Tree],
        humans: Sequence[HumanConfig],
        *,
        indices: Sequence[int] | None = None,
        num_robots: int = 1,
        time_step: float = 0.05,
        obstacles: Obstacles | None = None,
        sight_obstacles: Obstacles | None = None,
        social: SocialOptions | None = None,
    ) -> None:
        """Constructs a BehaviorTree.

        Args:
            trees: A tree for each person that is ticked; people can share one.
            humans: All people, in the order of ``human_states``. People
                without a number get that of `people_ids`.
            indices: The rows in ``human_states`` of the people that are
                ticked; by default, all.
            num_robots: The number of robots in ``robot_states``.
            time_step: The time between two ticks, in seconds.
            obstacles: The obstacles that people cannot walk through; none by
                default.
            sight_obstacles: The obstacles that people cannot see through; by
                default, ``obstacles``, however low.
            social: What trees with social leaves need to know.

        Raises:
            BehaviorTreeError: If a tree names a person or place that is not
                there.
            ValueError: If there are not as many trees as people that are
                ticked, an index is not in [0, n) or is there twice,
                ``num_robots`` is negative, or ``time_step`` is not positive.
        """
        super().__init__()
        n = len(humans)
        rows = range(n) if indices is None else indices
        _check_rows(rows, n)
        if len(trees) != len(rows):
            raise ValueError(
                f"there must be a tree for each of {len(rows)} people, got"
                f" {len(trees)}"
            )
        check_count("num_robots", num_robots)
        check_time_step(time_step)
        ids = people_ids(humans)
        self._trees = list(trees)
        self._people = [
            Person.from_config(
                humans[row],
                row,
                id=ids[row],
                time_step=time_step,
                obstacles=obstacles,
                sight_obstacles=sight_obstacles,
            )
            for row in rows
        ]
        memories = [
            np.array(tree.initial_memory(person))
            for tree, person in zip(trees, self._people, strict=True)
        ]
        social = social or SocialOptions()
        for tree, memory in zip(trees, memories, strict=True):
            if tree.is_social:
                memory[_SEED] = seed_to_halves(check_seed(social.seed))
        society = None
        if social.signals or any(it.is_social for it in trees):
            places = complete_places(social.places)
            society = Society.of(trees, self._people, ids, places)
        self._society = society
        self._walk = Walk(
            [tree.program for tree in trees],
            self._people,
            memories if self._CAN_BE_OUTSIDE else None,
            society,
        )
        # The place of each person among those that are ticked.
        self._places = {row: place for place, row in enumerate(rows)}
        self._num_robots, self._num_humans = num_robots, n
        self._no_robots = np.zeros(0)

        self._human_states = self.DeclareVectorInputPort(
            "human_states", n * STATE_SIZE
        )
        self._robot_states = DeclareRobotStates(self, num_robots)
        # (Numbers are found faster by an integer than by a typed index.)
        self._memory = int(
            self.DeclareDiscreteState(np.concatenate([np.zeros(0), *memories]))
        )
        self._signals: int | None = None
        if society is not None:
            self._DeclareSignals(n)
        self._DeclareOutputs()
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=time_step, offset_sec=0.0, update=self._Update
        )

    def _DeclareSignals(self, n: int) -> None:
        self._social_signals = self.DeclareVectorInputPort(
            "social_signals", n * SIGNAL_SIZE
        )
        self._robot_signals = None
        if self._num_robots:
            self._robot_signals = self.DeclareVectorInputPort(
                "robot_signals", self._num_robots * SIGNAL_SIZE
            )
        self._silent_robots = np.tile(SILENT, self._num_robots)
        signals = self.DeclareDiscreteState(np.tile(SILENT, len(self._trees)))
        self.DeclareStateOutputPort("signals", signals)
        self._signals = int(signals)

    def _DeclareOutputs(self) -> None:
        # The time is not among them: a held state gives held commands.
        prerequisites = {
            self.discrete_state_ticket(DiscreteStateIndex(self._memory)),
            self.all_input_ports_ticket(),
        }
        # The one tick of a step, which the ports and the update read.
        tick = self.DeclareCacheEntry(
            "tick",
            ValueProducer(
                allocate=lambda: Value(object()), calc=weakly(self._CalcTick)
            ),
            prerequisites_of_calc=prerequisites,
        )
        self._tick = tick.cache_index()
        self._commands = self.DeclareVectorOutputPort(
            "commands",
            len(self._trees) * COMMAND_SIZE,
            self._CalcCommands,
            prerequisites_of_calc={tick.ticket()},
        )
        self._behavior_status = self.DeclareVectorOutputPort(
            "behavior_status",
            len(self._trees),
            self._CalcBehaviorStatus,
            prerequisites_of_calc={tick.ticket()},
        )
        self._node_status = self.DeclareVectorOutputPort(
            "node_status",
            sum(len(tree.nodes) for tree in self._trees),
            self._CalcNodeStatus,
            prerequisites_of_calc={tick.ticket()},
        )

    def trees(self) -> list[Tree]:
        """Returns the trees, in the order of the people that are ticked."""
        return list(self._trees)

    def rows(self) -> list[int]:
        """Returns the rows in ``human_states`` of the people it ticks."""
        return list(self._places)

    def GetGoalIndices(self, context: Context) -> Array:
        """Returns the index of the present goal of each person of `rows`.

        It is the number of goals for who has none left.
        """
        self.ValidateContext(context)
        memory = context.get_discrete_state(self._memory).value()
        first = [own.start + GOAL_INDEX for own in self._walk.memories]
        indices: Array = memory[first]
        return indices

    def DescribeMemory(self) -> list[str]:
        """Returns what the meaning of the state depends on."""
        described = [
            tree.describe_memory(person, self._num_robots)
            for tree, person in zip(self._trees, self._people, strict=True)
        ]
        if self._society is not None:
            described.append(self._society.describe_places())
        return described

    def CheckMemory(self, memory: ArrayLike) -> None:
        """Checks that numbers can be the state of this system.

        Raises:
            ValueError: If they cannot: see `Tree.check_memory`.
        """
        numbers = np.asarray(memory, dtype=float).tolist()
        for tree, person, own in zip(
            self._trees, self._people, self._walk.memories, strict=True
        ):
            tree.check_memory(person, numbers[own])

    def CheckSignals(self, signals: ArrayLike) -> None:
        """Checks that numbers can be the signals of this system.

        Raises:
            ValueError: If one is not finite, or names nobody who is here.
        """
        rows = np.asarray(signals, dtype=float).reshape(-1, SIGNAL_SIZE)
        bodies = self._num_humans + self._num_robots
        for which in WHO:
            least = -2 if which == Signal.GAZE else -1
            codes = rows[:, which]
            bad = ~((codes >= least) & (codes < bodies) & (codes % 1 == 0))
            if bad.any():
                raise ValueError(
                    f"{which.name} must be a whole number in"
                    f" [{least}, {bodies}), got {codes[bad][0]}"
                )
        if not np.isfinite(rows).all():
            raise ValueError("signals must be finite numbers")

    def get_human_states_input_port(self) -> InputPort:
        """Returns the port with the states of the people."""
        return self._human_states

    def get_robot_states_input_port(self) -> InputPort:
        """Returns the port with the states of the robots.

        Raises:
            ValueError: If the system was made with no robots.
        """
        return RequirePort(
            self, self._robot_states, "robot_states", "num_robots=0"
        )

    def get_commands_output_port(self) -> OutputPort:
        """Returns the port with the commands of the people."""
        return self._commands

    def get_behavior_status_output_port(self) -> OutputPort:
        """Returns the port with the states of the people's reactions."""
        return self._behavior_status

    def get_node_status_output_port(self) -> OutputPort:
        """Returns the port with the status of each node of each tree."""
        return self._node_status

    def EvalNodeStatus(self, context: Context, index: int) -> Array:
        """Returns the status of each node of a person's tree.

        Args:
            context: Of this system.
            index: The row of the person in ``human_states``.

        Returns:
            The person's part of port ``node_status``, one number for each of
            `Tree.nodes`, which `RenderBehaviorTree` draws.

        Raises:
            IndexError: If this system does not tick that person.
        """
        self.ValidateContext(context)
        own = self._walk.node_statuses[self._Place(index)]
        status: Array = self._node_status.Eval(context)[own]
        return status

    def GetMemory(self, context: Context, index: int) -> Array:
        """Returns the memory of a person's tree.

        Args:
            context: Of this system.
            index: The row of the person in ``human_states``.

        Returns:
            A copy of the memory, whose layout `Tree.Describe()` prints.

        Raises:
            IndexError: If this system does not tick that person.
        """
        self.ValidateContext(context)
        own = self._walk.memories[self._Place(index)]
        memory = context.get_discrete_state(self._memory).value()
        copy: Array = memory[own].copy()
        return copy

    def SetMemory(
        self, context: Context, index: int, memory: ArrayLike
    ) -> None:
        """Sets the memory of a person's tree.

        Args:
            context: Of this system, changed.
            index: The row of the person in ``human_states``.
            memory: The result of `GetMemory`, perhaps of another context.

        Raises:
            IndexError: If this system does not tick that person.
            ValueError: If it is invalid: see `Tree.check_memory`.
        """
        self.ValidateContext(context)
        place = self._Place(index)
        own = self._walk.memories[place]
        values = np.asarray(memory, dtype=float)
        if values.shape != (own.stop - own.start,):
            raise ValueError(
                f"the memory of humans[{index}] has shape"
                f" ({own.stop - own.start},), got {values.shape}"
            )
        self._trees[place].check_memory(self._people[place], values.tolist())
        whole = context.get_discrete_state(self._memory).value().copy()
        whole[own] = values
        context.SetDiscreteState(self._memory, whole)

    def _Place(self, index: int) -> int:
        if index not in self._places:
            raise IndexError(
                f"{self.GetSystemPathname()} does not tick humans[{index}],"
                f" only {sorted(self._places)}"
            )
        return self._places[index]

    def SetSeed(self, context: Context, seed: int) -> None:
        """Sets the seed of what people do by chance from now on.

        Args:
            context: Of this system, changed.
            seed: In [0, 2^63).

        Raises:
            ValueError: If the seed is not such a number.
        """
        self.ValidateContext(context)
        halves = seed_to_halves(check_seed(seed))
        memory = context.get_discrete_state(self._memory).value().copy()
        for tree, own in zip(self._trees, self._walk.memories, strict=True):
            if tree.is_social:
                memory[own][_SEED] = halves
        context.SetDiscreteState(self._memory, memory)

    def _Signals(self, context: Context) -> Array:
        """Returns what all people and robots have shown in the last tick."""
        if self._signals is None:
            return self._no_robots
        people = self._social_signals.EvalBasicVector(context).value()
        port, robots = self._robot_signals, self._silent_robots
        if port is not None and port.HasValue(context):
            robots = port.EvalBasicVector(context).value()
        signals: Array = np.concatenate([people, robots])
        return signals

    def _CalcTick(self, context: Context, value: AbstractValue) -> None:
        # Views: Eval() would copy the states of everybody.
        robots = self._no_robots
        if self._robot_states is not None:
            robots = RobotStatesOf(self._robot_states, context)
        try:
            result = self._walk.tick(
                context.get_discrete_state(self._memory).value(),
                self._human_states.EvalBasicVector(context).value(),
                robots,
                self._Signals(context),
            )
        except Exception as error:
            error.add_note(f"at t = {context.get_time():.3f} s")
            raise
        value.set_value(result)

    def _EvalTick(self, context: Context, part: slice) -> Array:
        result: Array = self.get_cache_entry(self._tick).Eval(context)
        return result[part]

    def _CalcCommands(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._EvalTick(context, self._walk.commands))

    def _CalcBehaviorStatus(
        self, context: Context, output: BasicVector
    ) -> None:
        output.SetFromVector(
            self._EvalTick(context, self._walk.behavior_status)
        )

    def _CalcNodeStatus(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._EvalTick(context, self._walk.node_status))

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        discrete_state.set_value(
            self._memory, self._EvalTick(context, self._walk.memory)
        )
        if self._signals is not None:
            discrete_state.set_value(
                self._signals, self._EvalTick(context, self._walk.signals)
            )


def _check_rows(rows: Sequence[int], n: int) -> None:
    """Checks the rows of the people that are ticked."""
    for row in rows:
        if not 0 <= row < n:
            raise ValueError(
                f"indices must be in [0, {n}), the number of people, got {row}"
            )
    if len(set(rows)) < len(rows):
        raise ValueError(f"indices must all be different, got {list(rows)}")
