"""The parts of a parsed tree: node types and nodes.

A node type defines how its nodes are written in XML, and what they do. A node
is one use of a type in a tree.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from hunav_drake.systems.behavior.nodes.compiled_leaf import CompiledLeaf
from hunav_drake.systems.behavior.nodes.errors import BehaviorTreeError, Place
from hunav_drake.systems.behavior.nodes.operations import Operation, Script
from hunav_drake.systems.behavior.nodes.port import (
    UNSET,
    Constant,
    Meaning,
    Port,
    Variable,
)
from hunav_drake.systems.behavior.nodes.status import NodeStatus
from hunav_drake.systems.behavior.nodes.tick_context import TickContext

Category = Literal["Action", "Condition", "Control", "Decorator"]
Memory = list[float]
LeafFunction = Callable[[TickContext, Memory], NodeStatus]


@dataclass(frozen=True)
class Conditions:
    """The pre- and post-conditions of a node: see `pre_post_conditions`.

    Attributes:
        scripts: For each attribute, what evaluates it or sets entries.
        slot: The index in the memory of the flag that the node runs; None if
            no condition needs it.
        source: The attributes as in the file.
    """

    scripts: Mapping[str, Script]
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
        owner: The number given as that of the person that ticks it, if any.
    """

    type: "NodeType"
    name: str
    place: Place
    ports: Mapping[str, Constant | Variable]
    children: tuple["Node", ...]
    first: int
    slots: tuple[str, ...]
    conditions: Conditions | None = None
    owner: int | None = None

    def error(self, message: str) -> BehaviorTreeError:
        """Returns an error at this node."""
        return BehaviorTreeError(message, self.place, node=self.name)

    def constant(self, port: str) -> Any:
        """Returns the value of a port, or None if it is a variable."""
        value = self.ports[port]
        return value.value if isinstance(value, Constant) else None

    def read(self, port: str, memory: Memory) -> Any:
        """Returns the value of a port in a tick.

        Raises:
            BehaviorTreeError: If nothing has set its entry yet, or a value
                that does not fit.
        """
        value = self.ports[port]
        if isinstance(value, Constant):
            return value.value
        if self.type.ports[port].meaning is Meaning.RESULT:
            return value.slot
        number, texts = memory[value.slot], value.texts
        if number == UNSET:
            raise self.error(
                f"port {port}: nothing has set {{{value.key}}} yet"
            )
        try:
            return self.type.ports[port].check(
                number if texts is None else texts[int(number)]
            )
        except ValueError as error:
            raise self.error(f"{error}, from {{{value.key}}}") from error


# The numbers of children of a control node that takes any number.
MANY = (1, 10**6)


@dataclass(frozen=True, eq=False)
class NodeType:
    """A type of node. Each registration makes one that equals no other.

    Attributes:
        name: The name of its XML element.
        category: Its category in Groot2.
        operation: What its nodes do.
        doc: A description in one line.
        ports: Its ports by name.
        ignored: Attributes that are accepted and have no effect.
        slots: Its numbers in the memory: their names and initial values.
        slots_per_child: The names of those that it has for each child, which
            are 0 at first.
        kept: Those of its numbers that outlive a halt.
        children: The smallest and the largest number of children.
        source: The full name of the leaf's function; empty for built-in
            nodes.
        function: The function, object or class of the leaf; None for built-in
            nodes.
        leaf: The function of a compiled leaf, or None.
        build: For leaves in Python, returns what ticks a node.
        is_social: Whether it takes notice of what people show each other, or
            of the numbers that every person with such a tree has.
    """

    name: str
    category: Category
    operation: Operation
    doc: str
    ports: Mapping[str, Port] = field(default_factory=dict)
    ignored: frozenset[str] = frozenset()
    slots: Mapping[str, float] = field(default_factory=dict)
    slots_per_child: tuple[str, ...] = ()
    kept: tuple[str, ...] = ()
    children: tuple[int, int] = (0, 0)
    source: str = ""
    function: Any = field(default=None, repr=False, compare=False)
    leaf: CompiledLeaf | None = field(default=None, repr=False)
    build: Callable[[Node], LeafFunction] | None = field(
        default=None, repr=False
    )
    is_social: bool = False

    @property
    def is_ours(self) -> bool:
        """Whether it comes with this package."""
        return not self.source or self.source.startswith("hunav_drake.systems.")
