"""The parts of a parsed tree: node types, ports, nodes.

A node type says how a node of it is written in XML and how it is built into
a function that ticks it. A node is one use of a type in a tree.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

from pydantic import ConfigDict, TypeAdapter, ValidationError

from hunav_drake.systems.behavior.errors import BehaviorTreeError, Place
from hunav_drake.systems.behavior.nodes.status import Status
from hunav_drake.systems.behavior.tick_context import Moment

# What a blackboard entry holds until something sets it. No literal is
# infinite, and unlike NaN it is equal to itself, so that states compare.
UNSET = float("-inf")

Category = Literal["Action", "Condition", "Control", "Decorator"]
Memory = list[float]
TickFunction = Callable[[Memory, Moment], Status]
HaltFunction = Callable[[Memory], None]


def _message(error: ValidationError, value: Any) -> str:
    """Returns the rule that a value breaks, and the value."""
    text = error.errors()[0]["msg"]
    text = text.removeprefix("Input ").removeprefix("Value error, ")
    # Rules of our own tell what they got; those of pydantic do not.
    return text if ", got " in text else f"{text}, got {value!r}"


@dataclass(frozen=True)
class Port:
    """A value that a node takes from its XML attribute.

    Attributes:
        name: The name of the attribute.
        annotation: The Python type: float, int, bool, str or a Literal of
            texts, or one of these Annotated with rules of pydantic. Any is
            what a blackboard entry can hold, a number or a text; all such
            ports of a node hold the same.
        default: The value without the attribute; `...` if it is required.
        output: Whether the node sets the blackboard entry that the attribute
            names, rather than taking a value.
        adapter: What checks values of the annotation.
    """

    name: str
    annotation: Any
    default: Any = ...
    output: bool = False
    adapter: TypeAdapter[Any] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        adapter: TypeAdapter[Any] = TypeAdapter(
            self.annotation, config=ConfigDict(allow_inf_nan=False)
        )
        object.__setattr__(self, "adapter", adapter)

    @property
    def base(self) -> type:
        """The Python type without rules: a Literal is a str."""
        origin = getattr(self.annotation, "__origin__", self.annotation)
        return origin if isinstance(origin, type) else str

    @property
    def takes_any(self) -> bool:
        """Whether it takes what a blackboard entry holds, as it is."""
        return self.annotation is Any

    def parse(self, text: str, place: Place, node: str) -> Any:
        """Returns the value that an attribute says.

        Raises:
            BehaviorTreeError: If it is not of the port's type.
        """
        try:
            return self.adapter.validate_strings(text)
        except ValidationError as error:
            raise BehaviorTreeError(
                f"port {self.name}: {_message(error, text)}",
                place,
                node=node,
            ) from error

    def check(self, value: Any) -> Any:
        """Returns a Python value as the port's type.

        Raises:
            ValueError: If it is not of the port's type.
        """
        try:
            return self.adapter.validate_python(value)
        except ValidationError as error:
            raise ValueError(
                f"port {self.name}: {_message(error, value)}"
            ) from error


@dataclass(frozen=True)
class Constant:
    """A port's value that is known when the tree is parsed.

    Attributes:
        value: The value.
        number: What stands for it in the memory, if the port takes what
            blackboard entries hold.
    """

    value: Any
    number: float = 0.0


@dataclass(frozen=True)
class Variable:
    """A port's value that is in the memory: a blackboard entry.

    Attributes:
        key: The name of the entry.
        slot: Its index in the memory.
        texts: If the entry holds texts, the texts that its numbers mean.
    """

    key: str
    slot: int
    texts: tuple[str, ...] | None = None


@dataclass(frozen=True)
class Conditions:
    """The conditions of a node: see `nodes.conditions`.

    Attributes:
        before: For each attribute, the function that tells if it holds.
        after: For each attribute, the functions that set entries.
        slot: The index in the memory that tells if the node runs, if that
            must be known.
        source: The attributes as they are written.
    """

    before: Mapping[str, Callable[[Memory], float]]
    after: Mapping[str, tuple[Callable[[Memory], None], ...]]
    slot: int | None
    source: Mapping[str, str]


@dataclass(frozen=True)
class Node:
    """A node of a tree.

    Attributes:
        type: What it is.
        name: What it is called: the attribute `name`, or the type's name.
        place: Where it is written.
        ports: The value of each port.
        children: The nodes under it.
        first: The index of its first slot in the memory.
        slots: What each of its slots holds.
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
        """Returns the function that gives the value of a port in a tick."""
        value = self.ports[port]
        if isinstance(value, Constant):
            constant = value.value
            return lambda memory: constant
        slot, key, check = value.slot, value.key, self.type.ports[port].check
        if value.texts is not None:
            return self._text_reader(value, port)

        def read(memory: Memory) -> Any:
            number = memory[slot]
            if number == UNSET:
                raise self.error(f"port {port}: nothing has set {{{key}}} yet")
            try:
                return check(number)
            except ValueError as error:
                raise self.error(f"{error}, from {{{key}}}") from error

        return read

    def number_reader(self, port: str) -> Callable[[Memory], float]:
        """Returns the function that gives a port's value as the memory does.

        It is for ports that take what blackboard entries hold, and gives
        UNSET of an entry that is not set.
        """
        value = self.ports[port]
        if isinstance(value, Constant):
            number = value.number
            return lambda memory: number
        slot = value.slot
        return lambda memory: memory[slot]

    def _text_reader(
        self, value: Variable, port: str
    ) -> Callable[[Memory], Any]:
        check = self.type.ports[port].check
        faults = {}
        for text in value.texts or ():
            try:
                check(text)
            except ValueError as error:
                faults[text] = error

        def read(memory: Memory) -> str:
            number = memory[value.slot]
            if number == UNSET:
                raise self.error(
                    f"port {port}: nothing has set {{{value.key}}} yet"
                )
            text = (value.texts or ())[int(number)]
            if text in faults:
                raise self.error(f"{faults[text]}, from {{{value.key}}}")
            return text

        return read


class Built(NamedTuple):
    """A node as functions.

    Attributes:
        tick: Ticks the node: changes the memory and the moment.
        halt: Gives up what is running; None where that changes nothing.
        may_skip: Whether it can say SKIPPED.
        work: How many nodes one tick of it ticks at most.
    """

    tick: TickFunction
    halt: HaltFunction | None = None
    may_skip: bool = False
    work: int = 1


BuildFunction = Callable[[Node, tuple[Built, ...]], Built]


@dataclass(frozen=True)
class NodeType:
    """A kind of node.

    Attributes:
        name: The name of its XML element.
        category: What it is to Groot.
        build: Makes the functions of a node from those of its children.
        doc: What it does, in a line.
        ports: Its ports by name.
        ignored: Attributes that are accepted and mean nothing here.
        slots: What it remembers: a name for each number, and what it is at
            first.
        slots_per_child: Likewise for each child.
        children: The smallest and the largest number of children.
        source: The name of what it was made of; empty for the nodes of the
            language.
        function: What it was made of: a function, an object, a class; None
            for the nodes of the language.
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
