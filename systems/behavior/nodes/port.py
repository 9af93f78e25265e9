"""Ports: how a node gets values from its XML attributes.

A port's value is either a constant, known when the tree is parsed, or a
variable: a blackboard entry in the tree's memory.
"""

from dataclasses import dataclass, field
from enum import Enum
import math
import sys
from typing import Any, Literal, get_args, get_origin

from pydantic import ConfigDict, TypeAdapter, ValidationError

from hunav_drake.systems.behavior.nodes.errors import Spot
from hunav_drake.systems.behavior.nodes.texts import (
    people_code,
    place_code,
    text_code,
)
from hunav_drake.systems.common.schema import Within

# The number of a blackboard entry that is not set. No literal is infinite, and
# unlike NaN it is equal to itself, so that states compare.
UNSET = float("-inf")


class Meaning(Enum):
    """What the value of a port names, for its annotation in `Annotated`."""

    PERSON = "a person's number"
    """The number of a person. An entry that nothing has set is nobody."""

    PEOPLE = "numbers of people"
    """A text with numbers of people, as "2, 3"; or such an entry."""

    PLACE = "a place"
    """The name or the number of a place."""

    DOOR = "a door"
    """The name or the number of a place of that type."""

    NEED = "a need"
    """The name of a need of the person: it gets the number of its slot."""

    RESULT = "a result"
    """An entry that the leaf sets: it gets the number of its slot."""


def _message(error: ValidationError, value: Any) -> str:
    """Returns the message for a value that breaks a rule."""
    text = error.errors()[0]["msg"]
    text = text.removeprefix("Input ").removeprefix("Value error, ")
    # Rules of this package name the value; those of pydantic do not.
    return text if ", got " in text else f"{text}, got {value!r}"


@dataclass(frozen=True)
class Port:
    """A value that a node takes from its XML attribute.

    Attributes:
        name: The name of the attribute.
        annotation: The Python type: float, int, bool, str or a Literal of
            texts, or one of these Annotated with rules of pydantic. Any takes
            each value of a blackboard entry, a number or a text; all such
            ports of a node have the same type.
        default: The value without the attribute; `...` if it is required.
        output: Whether the node sets the blackboard entry that the attribute
            names, rather than taking a value.
        adapter: The validator of its values.
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
        """The Python type without constraints; str for a Literal."""
        origin = getattr(self.annotation, "__origin__", self.annotation)
        return origin if isinstance(origin, type) else str

    @property
    def takes_any(self) -> bool:
        """Whether it takes any value that a blackboard entry can hold."""
        return self.annotation is Any

    @property
    def meaning(self) -> Meaning | None:
        """What its value names, if its annotation says so."""
        rules = getattr(self.annotation, "__metadata__", ())
        return next((it for it in rules if isinstance(it, Meaning)), None)

    @property
    def choices(self) -> tuple[str, ...]:
        """The texts that it takes, if it is one of several."""
        annotation = getattr(self.annotation, "__origin__", self.annotation)
        literal = self.annotation if annotation is Literal else annotation
        return get_args(literal) if get_origin(literal) is Literal else ()

    def number(self, value: Any) -> float:
        """Returns the number of a value for compiled code."""
        if self.meaning in (Meaning.PLACE, Meaning.DOOR):
            return place_code(value)
        if self.meaning is Meaning.PEOPLE:
            return people_code(value)
        if self.base is str and not self.choices:
            return text_code(value)
        return float(self.choices.index(value) if self.choices else value)

    def bounds(self) -> tuple[float, float, bool]:
        """Returns numbers that surely fit: the least and the largest.

        After them comes whether they must be whole. Of texts none surely fits.
        """
        if self.meaning in (Meaning.PERSON, Meaning.PEOPLE):
            return UNSET, sys.float_info.max, False
        if self.base is str:
            return 1.0, 0.0, False
        if self.base is bool:
            return 0.0, 1.0, True
        low, high = -sys.float_info.max, sys.float_info.max
        for rule in getattr(self.annotation, "__metadata__", ()):
            if isinstance(rule, Meaning):
                continue
            if not isinstance(rule, Within):
                return 1.0, 0.0, False
            low = (
                math.nextafter(rule.low, math.inf)
                if rule.low_open
                else rule.low
            )
            high = min(rule.high, high)
        return low, high, self.base is int

    def parse(self, text: str, spot: Spot) -> Any:
        """Returns the value of an attribute's text."""
        try:
            return self.adapter.validate_strings(text)
        except ValidationError as error:
            raise spot.fault(
                f"port {self.name}: {_message(error, text)}"
            ) from error

    def check(self, value: Any) -> Any:
        """Returns a Python value converted to the port's type.

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
        number: Its number in the memory, if the port takes any value of a
            blackboard entry.
    """

    value: Any
    number: float = 0.0


@dataclass(frozen=True)
class Variable:
    """A port's value that is in the memory: a blackboard entry.

    Attributes:
        key: The name of the entry.
        slot: Its index in the memory.
        texts: The texts that its numbers mean, if it holds texts.
    """

    key: str
    slot: int
    texts: tuple[str, ...] | None = None
