"""A parsed behavior tree, and how it ticks."""

from collections.abc import Iterator, Sequence
import functools
import hashlib
import math
from typing import NamedTuple

import numpy as np

from hunav_drake.systems.behavior.describe import describe_tree
from hunav_drake.systems.behavior.language.blackboard import GIVEN
from hunav_drake.systems.behavior.language.parser import ParsedTree
from hunav_drake.systems.behavior.nodes.control_flow import MAX_CYCLES_PER_TICK
from hunav_drake.systems.behavior.nodes.language_nodes import (
    check_needs,
    check_thresholds,
)
from hunav_drake.systems.behavior.nodes.node import Node
from hunav_drake.systems.behavior.nodes.operations import AGAIN, SWITCH
from hunav_drake.systems.behavior.nodes.program import Program
from hunav_drake.systems.behavior.nodes.status import NodeStatus
from hunav_drake.systems.behavior.nodes.tick_context import (
    GOAL_INDEX,
    Person,
    need_slots,
)
from hunav_drake.systems.behavior.society import Society
from hunav_drake.systems.behavior.walk import Walk
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import SILENT, STATE_SIZE

# The number of nodes that one tick may tick. Repeat in Repeat in Repeat ...
# would otherwise let a small tree stop the simulation.
MAX_WORK = 100_000

# The leaves that draw at random; user-defined ones may, if they are social.
_DRAWING = ("RandomChanceCondition", "SetRandomGoal")


class Outcome(NamedTuple):
    """The result of one tick.

    Attributes:
        node_status: The status of the topmost node.
        command: The command of the person: see `layout.Command`.
        behavior_status: 0 while no reaction is active, else the state that
            it is in: see `TickContext`.
        memory: The memory for the next tick.
    """

    node_status: NodeStatus
    command: list[float]
    behavior_status: int
    memory: list[float]


def _work(node: Node) -> int:
    """Returns the largest number of nodes that one tick of a node ticks."""
    below = [_work(child) for child in node.children]
    most = sum(below)
    operation = node.type.operation.code
    if operation == SWITCH:
        most = max(below)
    if operation == AGAIN:
        (port,) = node.ports
        limit = node.constant(port)
        cycles = MAX_CYCLES_PER_TICK
        if limit is not None:
            cycles = 1 if limit == -1 else min(limit, cycles)
        most *= cycles
    if most >= MAX_WORK:
        raise node.error(
            f"one tick could tick {most + 1} nodes, at most {MAX_WORK} are"
            " accepted; repeat less"
        )
    return most + 1


def _preorder(node: Node) -> Iterator[Node]:
    yield node
    for child in node.children:
        yield from _preorder(child)


class Tree:
    """An immutable behavior tree. One tree can serve any number of people.

    All that changes is in a list of numbers, the memory, whose layout is
    fixed when the tree is parsed: that of the person, then the numbers of each
    node, from the top down, then the blackboard entries.

    Attributes:
        name: The ID of the tree.
        file: The file that it was read from, or its name in messages.
        root: The topmost node.
        nodes: All nodes, each before its children.
        slots: The name of each number of the memory.
        texts: The texts that blackboard entries can hold; the memory holds
            their indices.
        documents: The XML documents that it was made from.
        values: The values of its ports, as in XML.
        is_social: Whether a leaf of it takes notice of what people show each
            other.
        draws: Whether a leaf of it may draw at random.
    """

    def __init__(self, parsed: ParsedTree) -> None:
        """Constructs a Tree from the parser's result.

        Raises:
            BehaviorTreeError: If a node cannot work as it is written.
        """
        self.documents = parsed.documents
        self.name = self.documents.main
        self.file = self.documents.file
        self.values = parsed.values
        self.root = parsed.assembled.root
        self.nodes = tuple(_preorder(self.root))
        self.slots = parsed.assembled.slots
        self.texts = parsed.assembled.texts
        self.is_social = parsed.assembled.is_social
        self.draws = any(
            it.type.is_social
            and (it.type.name in _DRAWING or not it.type.is_ours)
            for it in self.nodes
        )
        for node in self.nodes:
            check_thresholds(
                node, {name: node.constant(name) for name in node.ports}
            )
            check_needs(node)
        _work(self.root)
        self._initial = parsed.assembled.initial
        self._given = {
            key: parsed.entries[key] for key in GIVEN if key in parsed.entries
        }

    def initial_memory(self, person: Person) -> list[float]:
        """Returns the memory before a person's first tick."""
        memory = list(self._initial)
        values = {"id": float(person.id), "dt": person.time_step}
        for key, slot in self._given.items():
            memory[slot] = values[key]
        for need, numbers in person.needs.items():
            for name, value in zip(need_slots(need), numbers, strict=True):
                if name in self.slots:
                    memory[self.slots.index(name)] = value
        return memory

    def describe_memory(self, person: Person, num_robots: int) -> str:
        """Returns a description of all that a memory's meaning depends on."""
        slots = hashlib.sha256("\n".join(self.slots).encode()).hexdigest()
        return (
            f"of tree {self.name} ({len(self.slots)} numbers, {slots[:8]}) for"
            f" person {person.id} with {len(person.goals)} goals,"
            f" {num_robots} robots and a time step of {person.time_step} s"
        )

    def check_memory(self, person: Person, memory: Sequence[float]) -> None:
        """Checks that numbers can be a person's memory.

        Raises:
            ValueError: If they are too few or too many, one is NaN, or the
                person has no such goal.
        """
        if len(memory) != len(self.slots):
            raise ValueError(
                f"the memory of tree {self.name} has {len(self.slots)} numbers,"
                f" got {len(memory)}"
            )
        # (Infinity may mean "nothing yet" to a leaf, and does to the
        # blackboard.)
        for slot, value in zip(self.slots, memory, strict=True):
            if math.isnan(value):
                raise ValueError(f"memory {slot!r} must be a number, got NaN")
        goal, count = memory[GOAL_INDEX], len(person.goals)
        if not 0 <= goal <= count or goal % 1:
            raise ValueError(
                f"the goal index of person {person.id} must be a whole number"
                f" in [0, {count}], got {goal}"
            )

    def tick(
        self,
        person: Person,
        memory: Sequence[float],
        human_states: Array,
        robot_states: Array,
        social_signals: Array | None = None,
    ) -> Outcome:
        """Ticks the tree once. The result depends on the arguments only.

        Args:
            person: The person whose tree is ticked.
            memory: The memory after the previous tick, or `initial_memory`.
            human_states: Shape (7n,): see `common.layout`.
            robot_states: Shape (7m,): see `common.layout`.
            social_signals: Shape (22 (n + m),), rows of `layout.Signal` of all
                people and robots, for trees with social leaves; by default,
                nobody shows anything.

        Raises:
            BehaviorTreeError: If a node meets a blackboard entry that is not
                set, or not of its port's type; if a leaf raises an error,
                which is then the cause; or if a leaf writes an invalid
                number: a speed below 0, or one that is not finite.
            TypeError: If a leaf returns no valid status.
            ValueError: If there are too few numbers.
        """
        return self.trace(
            person, memory, human_states, robot_states, social_signals
        )[0]

    def trace(
        self,
        person: Person,
        memory: Sequence[float],
        human_states: Array,
        robot_states: Array,
        social_signals: Array | None = None,
    ) -> tuple[Outcome, tuple[NodeStatus, ...]]:
        """Ticks the tree once, and returns the status of each node.

        The arguments are those of `tick`.

        Returns:
            The outcome of `tick`, and the last status of each of `nodes` in
            this tick; IDLE if it was not ticked.

        Raises:
            BehaviorTreeError: As `tick`.
        """
        sizes = (len(memory), len(human_states) // STATE_SIZE)
        if sizes[0] != len(self.slots) or sizes[1] <= person.index:
            raise ValueError(
                f"there must be {len(self.slots)} numbers of memory and more"
                f" than {person.index} people, got {sizes[0]} and {sizes[1]}"
            )
        society = None
        if self.is_social:
            n, m = sizes[1], len(robot_states) // STATE_SIZE
            society = Society.of([self], [person], range(1, n + 1), ())
            if social_signals is None:
                social_signals = np.tile(SILENT, n + m)
        walk = Walk([self.program], [person], society=society)
        numbers, humans, robots, signals = (
            np.array(it, float)
            for it in (
                *(memory, human_states, robot_states),
                () if social_signals is None else social_signals,
            )
        )
        result = walk.tick(numbers, humans, robots, signals)
        statuses = tuple(map(NodeStatus, result[walk.node_status].astype(int)))
        outcome = Outcome(
            statuses[0],
            result[walk.commands].tolist(),
            int(result[walk.behavior_status][0]),
            result[walk.memory].tolist(),
        )
        return outcome, statuses

    @functools.cached_property
    def program(self) -> Program:
        """The tree as compiled code walks over it."""
        return Program(self.name, self.nodes, self.slots, self._initial)

    def Describe(self) -> str:
        """Returns the nodes of the tree and the layout of its memory.

        The indices of the nodes are those of `nodes` and `trace`, those of the
        memory are those of the discrete state of a `BehaviorTree`.
        """
        return describe_tree(
            f"{self.name} ({self.file})", self.nodes, self.slots, self.texts
        )
