"""A parsed behavior tree, and how it ticks."""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.behavior.blackboard import GIVEN
from hunav_drake.systems.behavior.node import (
    UNSET,
    Built,
    Constant,
    Memory,
    Node,
    TickFunction,
)
from hunav_drake.systems.behavior.parser import ParsedTree
from hunav_drake.systems.behavior.person import (
    PERSON_MEMORY,
    Moment,
    Person,
)
from hunav_drake.systems.behavior.status import Status

# Nodes that one tick may tick. Repeat in Repeat in Repeat ... would otherwise
# let a small tree stop the simulation.
MAX_WORK = 100_000

Wrapper = Callable[[Node, TickFunction], TickFunction]


class Outcome(NamedTuple):
    """What a tick gives.

    Attributes:
        status: The status of the tree.
        command: What the person is going to do: see `layout.Command`.
        behavior_status: 1 while a reaction is active, else 0.
        memory: The memory for the next tick.
    """

    status: Status
    command: list[float]
    behavior_status: int
    memory: list[float]


def _build(node: Node, wrap: Wrapper | None) -> Built:
    children = tuple(_build(child, wrap) for child in node.children)
    built = node.type.build(node, children)
    if built.work > MAX_WORK:
        raise node.error(
            f"one tick could tick {built.work} nodes, at most {MAX_WORK} are"
            " accepted; repeat less"
        )
    if wrap:
        return built._replace(tick=wrap(node, built.tick))
    return built


def _preorder(node: Node) -> Iterator[Node]:
    yield node
    for child in node.children:
        yield from _preorder(child)


def _describe(node: Node, depth: int) -> Iterator[str]:
    title = node.type.name
    if node.name != title:
        title += f" {node.name!r}"
    ports = [
        f"{name}={value.value!r}"
        if isinstance(value, Constant)
        else f"{name}={{{value.key}}}"
        for name, value in node.ports.items()
    ]
    yield "  " * depth + " ".join([title, *ports])
    for child in node.children:
        yield from _describe(child, depth + 1)


class Tree:
    """An immutable behavior tree. One tree can serve any number of people.

    All that changes is in a list of numbers, the memory, whose layout is
    fixed when the tree is parsed: what belongs to the person, then what each
    node remembers, from the top down, then the blackboard entries.

    Attributes:
        name: The ID of the tree.
        file: The file that it was read from, or what stands for it.
        root: The topmost node.
        nodes: All nodes, each before its children.
        slots: What each number of the memory is.
    """

    def __init__(self, parsed: ParsedTree, file: str) -> None:
        """Constructs a Tree from what the parser gives.

        Args:
            parsed: The tree.
            file: The file that it was read from.

        Raises:
            BehaviorTreeError: If a node cannot work as it is written.
        """
        self.name = parsed.name
        self.file = file
        self.root = parsed.root
        self.nodes = tuple(_preorder(parsed.root))
        self.slots = parsed.slots
        self._tick = _build(parsed.root, None).tick
        initial = [0.0] * len(PERSON_MEMORY)
        for node in self.nodes:
            own = list(node.type.slots.values())
            initial += own + [0.0] * (len(node.slots) - len(own))
        initial += [UNSET] * (len(self.slots) - len(initial))
        for slot, number in parsed.literals.items():
            initial[slot] = number
        self._initial = tuple(initial)
        self._given = {
            key: parsed.entries[key] for key in GIVEN if key in parsed.entries
        }

    def initial_memory(self, person: Person) -> list[float]:
        """Returns the memory before a person's first tick."""
        memory = list(self._initial)
        values = {"id": float(person.id), "dt": person.time_step}
        for key, slot in self._given.items():
            memory[slot] = values[key]
        return memory

    def tick(
        self,
        person: Person,
        memory: Sequence[float],
        human_states: NDArray[np.float64],
        robot_states: NDArray[np.float64],
    ) -> Outcome:
        """Ticks the tree once. What it gives depends on nothing else.

        Args:
            person: Whose tick it is.
            memory: What the tick before gave, or `initial_memory`.
            human_states: Shape (7n,): see `hunav_drake.systems.layout`.
            robot_states: Shape (7m,), likewise.

        Raises:
            BehaviorTreeError: If a node meets a blackboard entry that is not
                set, or not of its port's type.
        """
        return _run(self._tick, person, memory, human_states, robot_states)

    def trace(
        self,
        person: Person,
        memory: Sequence[float],
        human_states: NDArray[np.float64],
        robot_states: NDArray[np.float64],
    ) -> tuple[Outcome, tuple[Status, ...]]:
        """Ticks the tree once, and tells what each node said.

        Args:
            person: Whose tick it is.
            memory: What the tick before gave, or `initial_memory`.
            human_states: Shape (7n,): see `hunav_drake.systems.layout`.
            robot_states: Shape (7m,), likewise.

        Returns:
            What `tick` gives, and the last status of each of `nodes` in this
            tick; IDLE if it was not ticked.

        Raises:
            BehaviorTreeError: As `tick`.
        """
        statuses = dict.fromkeys(map(id, self.nodes), Status.IDLE)

        def wrap(node: Node, tick: TickFunction) -> TickFunction:
            def noted(memory: Memory, moment: Moment) -> Status:
                status = tick(memory, moment)
                statuses[id(node)] = status
                return status

            return noted

        function = _build(self.root, wrap).tick
        outcome = _run(function, person, memory, human_states, robot_states)
        return outcome, tuple(statuses.values())

    def Describe(self) -> str:
        """Returns the nodes of the tree and the layout of its memory."""
        lines = [f"{self.name} ({self.file})", *_describe(self.root, 1)]
        lines.append("Memory:")
        lines += [f"  {i:3d}  {slot}" for i, slot in enumerate(self.slots)]
        return "\n".join(lines)


def _run(
    function: TickFunction,
    person: Person,
    memory: Sequence[float],
    human_states: NDArray[np.float64],
    robot_states: NDArray[np.float64],
) -> Outcome:
    after = list(memory)
    moment = Moment(person, after, human_states, robot_states)
    status = function(after, moment)
    return Outcome(status, moment.command, moment.behavior_status, after)
