"""The parts of a parsed tree: node types and nodes, and the status of a node.

A node type defines how its nodes are written in XML, and how they are built
into functions that tick them. A node is one use of a type in a tree.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, Literal, NamedTuple

from hunav_drake.systems.behavior.nodes.errors import BehaviorTreeError, Place
from hunav_drake.systems.behavior.nodes.port import (
    UNSET,
    Constant,
    Port,
    Variable,
)
from hunav_drake.systems.behavior.nodes.tick_context import TickContext
from hunav_drake.systems.common.field_docs import explain


@explain
class NodeStatus(IntEnum):
    """The status that a node returns when it is ticked.

    The values are those of BehaviorTree.CPP. Compare with `is`: it is faster
    than `==`, and each status is one object.
    """

    IDLE = 0
    """Not ticked."""

    RUNNING = 1
    """Needs more ticks."""

    SUCCESS = 2
    """Completed with success."""

    FAILURE = 3
    """Completed without success, or could not be done."""

    SKIPPED = 4
    """Skipped: its parent goes on as if the node were not there."""


RUNNING = NodeStatus.RUNNING
SUCCESS = NodeStatus.SUCCESS
FAILURE = NodeStatus.FAILURE
SKIPPED = NodeStatus.SKIPPED

Category = Literal["Action", "Condition", "Control", "Decorator"]
Memory = list[float]
TickFunction = Callable[[Memory, TickContext], NodeStatus]
HaltFunction = Callable[[Memory], None]


@dataclass(frozen=True, slots=True)
class Fixed:
    """The function that evaluates an expression without variables.

    Attributes:
        number: Its value.
    """

    number: float

    def __call__(self, memory: Memory) -> float:
        """Returns the number, whatever the memory."""
        return self.number


@dataclass(frozen=True)
class Conditions:
    """The pre- and post-conditions of a node: see `pre_post_conditions`.

    Attributes:
        before: For each pre-condition, the function that evaluates it.
        after: For each post-condition, the functions that set entries.
        slot: The index in the memory of the flag that the node runs; None if
            no condition needs it.
        source: The attributes as in the file.
    """

    before: Mapping[str, Callable[[Memory], float]]
    after: Mapping[str, tuple[Callable[[Memory], None], ...]]
    slot: int | None
    source: Mapping[str, str]


@dataclass(frozen=True)
class Node:
    """A node of a tree.

    Attributes:
        type: Its node type.
        name: Its name: the attribute `name`, or the type's name.
        place: Its place in the file.
        ports: The value of each port.
        children: The nodes under it.
        first: The index of its first slot in the memory.
        slots: The names of its slots.
        conditions: Its conditions, if it has any.
    """

    type: "NodeType"
    name: str
    place: Place
    ports: Mapping[str, Constant | Variable]
    children: tuple["Node", ...]
    first: int
    slots: tuple[str, ...]
    conditions: Conditions | None = None

    def error(self, message: str) -> BehaviorTreeError:
        """Returns an error at this node."""
        return BehaviorTreeError(message, self.place, node=self.name)

    def slot(self, name: str) -> int:
        """Returns the index in the memory of one of the node's slots."""
        return self.first + self.slots.index(name)

    def constant(self, port: str) -> Any:
        """Returns the value of a port, or None if it is a variable."""
        value = self.ports[port]
        return value.value if isinstance(value, Constant) else None

    def reader(self, port: str) -> Callable[[Memory], Any]:
        """Returns the function that reads the value of a port in a tick."""
        value = self.ports[port]
        if isinstance(value, Constant):
            constant = value.value
            return lambda memory: constant
        slot, key, texts = value.slot, value.key, value.texts
        check = self.type.ports[port].check

        def read(memory: Memory) -> Any:
            number = memory[slot]
            if number == UNSET:
                raise self.error(f"port {port}: nothing has set {{{key}}} yet")
            try:
                return check(number if texts is None else texts[int(number)])
            except ValueError as error:
                raise self.error(f"{error}, from {{{key}}}") from error

        return read

    def number_reader(self, port: str) -> Callable[[Memory], float]:
        """Returns the function that reads a port's value as a number.

        It is for ports that take any value of a blackboard entry; UNSET
        stands for an entry that is not set.
        """
        value = self.ports[port]
        if isinstance(value, Constant):
            number = value.number
            return lambda memory: number
        slot = value.slot
        return lambda memory: memory[slot]


class Built(NamedTuple):
    """The functions that a node is built into.

    Attributes:
        tick: Ticks the node: changes the memory and the tick context.
        halt: Halts the node if it is running; None if that changes nothing.
        may_skip: Whether it can return SKIPPED.
        work: The largest number of nodes that one tick of it ticks.
        clears: The slots that `halt` sets to 0.
        halts: The functions that `halt` calls after that; None if that is not
            known. One function that halts all nodes under it takes less time
            than one for each.
    """

    tick: TickFunction
    halt: HaltFunction | None = None
    may_skip: bool = False
    work: int = 1
    clears: tuple[int, ...] = ()
    halts: tuple[HaltFunction, ...] | None = None


def parts_of(
    children: tuple[Built, ...],
) -> tuple[tuple[int, ...], tuple[HaltFunction, ...]]:
    """Returns the slots and functions that halt nodes: see `Built`.

    The functions do not read the slots.
    """
    clears: list[int] = []
    halts: list[HaltFunction] = []
    for child in children:
        if child.halts is not None:
            clears += child.clears
            halts += child.halts
        elif child.halt:
            halts.append(child.halt)
    return tuple(clears), tuple(halts)


def halts_of(children: tuple[Built, ...]) -> tuple[HaltFunction, ...]:
    """Returns the functions that halt nodes, together."""
    clears, halts = parts_of(children)
    return (_clearing(clears), *halts) if clears else halts


def _clearing(slots: tuple[int, ...]) -> HaltFunction:
    def clear(memory: Memory) -> None:
        for slot in slots:
            memory[slot] = 0.0

    return clear


def halt_of(slots: Iterable[int], children: tuple[Built, ...]) -> HaltFunction:
    """Returns the function that sets slots to 0 and halts children."""
    clears, halts = parts_of(children)
    own = (*slots, *clears)

    def halt(memory: Memory) -> None:
        for slot in own:
            memory[slot] = 0.0
        for halt in halts:
            halt(memory)

    return halt


def leftovers_of(children: tuple[Built, ...]) -> tuple[HaltFunction, ...]:
    """Returns what to halt when a node completes and no child is running.

    Only a skipped child can still have something in memory.
    """
    return halts_of(tuple(child for child in children if child.may_skip))


def compose(
    tick: TickFunction,
    children: tuple[Built, ...],
    slots: Iterable[int] = (),
    *,
    skips: Callable[[Iterable[bool]], bool] = any,
) -> Built:
    """Returns a node that ticks each child once at most.

    The slots are 0 in the memory unless the node is running. It can skip if
    `any` of its children can, or `all`.
    """
    own = tuple(slots)
    clears, halts = parts_of(children)
    return Built(
        tick,
        halt_of(own, children) if own or clears or halts else None,
        skips(child.may_skip for child in children),
        1 + sum(child.work for child in children),
        clears=(*own, *clears),
        halts=halts,
    )


BuildFunction = Callable[[Node, tuple[Built, ...]], Built]

# The numbers of children of a control node that takes any number.
MANY = (1, 10**6)


@dataclass(frozen=True, eq=False)
class NodeType:
    """A type of node. Each registration makes one that equals no other.

    Attributes:
        name: The name of its XML element.
        category: Its category in Groot2.
        build: Builds a node from its children.
        doc: A description in one line.
        ports: Its ports by name.
        ignored: Attributes that are accepted and have no effect.
        slots: Its numbers in the memory: their names and initial values.
        slots_per_child: The names of those that it has for each child, which
            are 0 at first.
        children: The smallest and the largest number of children.
        source: The full name of the leaf's function; empty for built-in
            nodes.
        function: The function, object or class of the leaf; None for built-in
            nodes.
    """

    name: str
    category: Category
    build: BuildFunction
    doc: str
    ports: Mapping[str, Port] = field(default_factory=dict)
    ignored: frozenset[str] = frozenset()
    slots: Mapping[str, float] = field(default_factory=dict)
    slots_per_child: tuple[str, ...] = ()
    children: tuple[int, int] = (0, 0)
    source: str = ""
    function: Callable[..., Any] | None = field(
        default=None, repr=False, compare=False
    )

    @property
    def is_ours(self) -> bool:
        """Whether it comes with this package."""
        return not self.source or self.source.startswith("hunav_drake.systems.")
