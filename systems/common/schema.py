"""The strict types, and ranges with units, of all configuration dataclasses.

A configuration is a pydantic dataclass, so that a value is checked where it
is given, in Python as in a scenario file, by the same rule and with the same
message.
"""

from collections.abc import Sequence
import dataclasses
import math
from numbers import Integral
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    StrictFloat,
    StrictInt,
    StrictStr,
)
from pydantic_core import PydanticCustomError, core_schema

from hunav_drake.systems.common.files import FILE_NAME_RULE, is_file_name

# Numbers, texts and flags are strict (pydantic's Strict... types): no "0.1" for
# a number, no 1 for a flag. Dataclasses may come as mappings.
CONFIG = ConfigDict(extra="forbid", allow_inf_nan=False)


@dataclasses.dataclass(frozen=True)
class Within:
    """The rule of `within`, which is also in the JSON schema."""

    low: float
    high: float
    unit: str
    low_open: bool

    def __get_pydantic_core_schema__(
        self, source: Any, handler: Any
    ) -> core_schema.CoreSchema:
        return core_schema.no_info_after_validator_function(
            self._check, handler(source)
        )

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: Any
    ) -> dict[str, Any]:
        result: dict[str, Any] = handler(schema)
        result["exclusiveMinimum" if self.low_open else "minimum"] = self.low
        if not math.isinf(self.high):
            result["maximum"] = self.high
        if self.unit:
            result["x-unit"] = self.unit
        return result

    def _check(self, value: float) -> float:
        low, high = self.low, self.high
        if value < low or value > high or (self.low_open and value == low):
            opening = "(" if self.low_open else "["
            closing = ")" if math.isinf(high) else "]"
            rule = f"must be in {opening}{low:g}, {high:g}{closing} {self.unit}"
            raise PydanticCustomError(
                "range",
                "{rule}, got {value}",
                {"rule": rule.rstrip(), "value": value},
            )
        return value


def within(
    low: float,
    high: float = math.inf,
    unit: str = "",
    *,
    low_open: bool = False,
) -> Any:
    """Returns the rule that a number lies in [low, high], or (low, high].

    Without an upper bound, the number must still be finite. The unit is for
    the message; the rule stands beside the type in an `Annotated`.
    """
    return Within(low, high, unit, low_open)


@dataclasses.dataclass(frozen=True)
class Labels:
    """The names of the numbers of a tuple, also in the JSON schema."""

    names: tuple[str, ...]

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: Any
    ) -> dict[str, Any]:
        result: dict[str, Any] = handler(schema)
        return {**result, "x-labels": list(self.names)}


def _as_list(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value


def as_tuple(value: Any) -> Any:
    """Makes a tuple of any sequence of numbers: lists, tuples, arrays."""
    value = _as_list(value)
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        return tuple(value)
    return value


def _as_int(value: Any) -> Any:
    """Makes integers of NumPy's integers, which generators draw."""
    if isinstance(value, Integral) and not isinstance(value, bool):
        return int(value)
    return value


def fault(rule: str) -> PydanticCustomError:
    """Returns the error of a value that breaks a rule."""
    return PydanticCustomError("rule", "{rule}", {"rule": rule})


def check_order(config: Any, low: str, high: str) -> None:
    """Checks that a number of a configuration is not below another one.

    Raises:
        PydanticCustomError: If it is.
    """
    least, most = getattr(config, low), getattr(config, high)
    if most < least:
        raise fault(f"{high} must be at least {low} ({least}), got {most}")


def one_line(value: str) -> str:
    """Returns a text, checked to fit in one line of a terminal.

    Raises:
        ValueError: If it has line breaks or control characters.
    """
    if not value.isprintable():
        raise PydanticCustomError(
            "one_line", "must be one line without control characters"
        )
    return value


def _file_name(value: str) -> str:
    if value and not is_file_name(value):
        raise PydanticCustomError("file_name", FILE_NAME_RULE)
    return value


FilePath = Annotated[
    StrictStr, Field(min_length=1, max_length=4096), AfterValidator(one_line)
]
Integer = Annotated[StrictInt, BeforeValidator(_as_int)]
Name = Annotated[StrictStr, Field(max_length=64), AfterValidator(one_line)]
# The name of a file or folder of results.
FileName = Annotated[Name, AfterValidator(_file_name)]

# Coordinates of a point in W, in meters: beyond, the forces, which depend on
# differences of positions, would lose digits.
MAX_COORDINATE = 1e5
Coordinate = Annotated[
    StrictFloat, within(-MAX_COORDINATE, MAX_COORDINATE, "m")
]
Point = Annotated[
    tuple[Coordinate, Coordinate], BeforeValidator(as_tuple), Labels(("x", "y"))
]
Points = Annotated[list[Point], BeforeValidator(_as_list)]
Angle = Annotated[StrictFloat, within(-1e3, 1e3, "rad")]
Pose = Annotated[
    tuple[Coordinate, Coordinate, Angle],
    BeforeValidator(as_tuple),
    Labels(("x", "y", "yaw")),
]
Speed = Annotated[StrictFloat, within(0, 10, "m/s")]
PositiveSpeed = Annotated[StrictFloat, within(0, 10, "m/s", low_open=True)]
Length = Annotated[StrictFloat, within(0, 1e5, "m")]
PositiveLength = Annotated[StrictFloat, within(0, 1e5, "m", low_open=True)]
# Bodies of less than a millimeter can be neither drawn nor met.
BodyRadius = Annotated[StrictFloat, within(0.001, 5, "m")]
BodyRadii = Annotated[
    tuple[BodyRadius, BodyRadius],
    BeforeValidator(as_tuple),
    Labels(("least", "most")),
]
Rectangle = Annotated[
    tuple[Coordinate, Coordinate, Coordinate, Coordinate],
    BeforeValidator(as_tuple),
    Labels(("x0", "y0", "x1", "y1")),
]
Size = Annotated[
    tuple[PositiveLength, PositiveLength],
    BeforeValidator(as_tuple),
    Labels(("along x", "along y")),
]
