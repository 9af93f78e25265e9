"""The messages from a page or a widget to a session."""

from typing import Annotated, Any, Literal, get_args

from pydantic import (
    ConfigDict,
    Field,
    StrictBool,
    StrictInt,
    StrictStr,
    TypeAdapter,
    ValidationError,
)
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.suggest import shown, suggestion

# The maximum lengths of a text and of a name in a message.
_MAX_TEXT = 16 * 2**20
_MAX_NAME = 4096

_CONFIG = ConfigDict(extra="ignore", allow_inf_nan=False)
_message = dataclass(frozen=True, kw_only=True, config=_CONFIG)

Id = StrictInt | Annotated[StrictStr, Field(max_length=200)] | None
_Step = (
    Annotated[StrictInt, Field(ge=0)]
    | Annotated[StrictStr, Field(max_length=_MAX_NAME)]
)
Path = Annotated[list[_Step], Field(max_length=50)]
FileName = Annotated[StrictStr, Field(min_length=1, max_length=_MAX_NAME)]
Text = Annotated[StrictStr, Field(max_length=_MAX_TEXT)]
Operation = (
    tuple[Literal["set", "insert"], Path, Any] | tuple[Literal["remove"], Path]
)
Operations = Annotated[list[Operation], Field(max_length=10_000)]


@_message
class Message:
    """The base of all messages; the answers have the same id."""

    id: Id = None


@_message
class Request(Message):
    """Requests the whole state, or a step of the history, or a stop of runs."""

    do: Literal["hello", "undo", "redo", "cancel"]


@_message
class Edit(Message):
    """Changes the data by operations, as one step."""

    do: Literal["edit"]
    base: StrictInt
    label: Annotated[StrictStr, Field(max_length=200)] = "Edit"
    ops: Operations


@_message
class Preview(Message):
    """Checks operations without applying them."""

    do: Literal["preview"]
    base: StrictInt
    ops: Operations


@_message
class TypedText(Message):
    """Replaces the text by the text that the user typed."""

    do: Literal["text"]
    base: StrictInt
    text: Text


@_message
class Save(Message):
    """Writes the file, perhaps with another name."""

    do: Literal["save"]
    filename: FileName | None = None
    confirm: StrictBool = False


@_message
class Reload(Message):
    """Reads the file again."""

    do: Literal["reload"]
    confirm: StrictBool = False


@_message
class Open(Message):
    """Opens another file, or a shipped scenario."""

    do: Literal["open"]
    filename: FileName
    confirm: StrictBool = False


@_message
class UseTemplate(Message):
    """Starts from a template of `hunav new`."""

    do: Literal["template"]
    name: StrictStr
    confirm: StrictBool = False


@_message
class Import(Message):
    """Imports a file of HuNavSim or a scenario."""

    do: Literal["import"]
    kind: Literal["agents", "metrics", "scenario"]
    mode: Literal["replace", "add"] = "replace"
    name: FileName
    text: Text


@_message
class UseBackground(Message):
    """Sets or removes a map or a picture as background; files are in base64.

    Width and origin, in meters and radians, are for pictures without a map.
    """

    do: Literal["background"]
    name: Annotated[StrictStr, Field(max_length=_MAX_NAME)] = ""
    files: Annotated[dict[FileName, Text], Field(max_length=8)]
    width_m: float | None = None
    origin: list[float] | None = None
    remove: StrictBool = False


@_message
class Trace(Message):
    """Converts the background to walls."""

    do: Literal["trace"]
    base: StrictInt
    width_m: float | None = None
    origin: list[float] | None = None


@_message
class Door(Message):
    """Cuts a door into the walls at a place; lengths are in meters."""

    do: Literal["door"]
    base: StrictInt
    at: tuple[float, float]
    reach: Annotated[float, Field(gt=0, le=10)] = 0.2


@_message
class Run(Message):
    """Runs the scenario with some seeds and planners."""

    do: Literal["run"]
    seeds: Annotated[
        list[Annotated[StrictInt, Field(ge=0, le=2**63 - 1)]],
        Field(max_length=10_000),
    ] = Field(default_factory=list)
    planners: Annotated[list[StrictStr], Field(max_length=100)] = Field(
        default_factory=list
    )
    speed: Annotated[float, Field(ge=0, le=1000)] | None = None
    workers: Annotated[StrictInt, Field(ge=1, le=256)] = 1


AnyMessage = (
    Request
    | Edit
    | Preview
    | TypedText
    | Save
    | Reload
    | Open
    | UseTemplate
    | Import
    | UseBackground
    | Trace
    | Door
    | Run
)
_ADAPTER: TypeAdapter[AnyMessage] = TypeAdapter(
    Annotated[AnyMessage, Field(discriminator="do")]
)
_KINDS = [
    kind
    for message in get_args(AnyMessage)
    for kind in get_args(message.__annotations__["do"])
]


class MessageError(ValueError):
    """A message does not follow the protocol; the text says why."""


def read_message(message: Any) -> AnyMessage:
    """Returns the message object of a received mapping.

    Raises:
        MessageError: If it does not follow the protocol.
    """
    if not isinstance(message, dict):
        raise MessageError(f"a message is a mapping, got {shown(message)}")
    kind = message.get("do")
    if kind not in _KINDS:
        word = kind if isinstance(kind, str) else ""
        raise MessageError(
            f"there is no message {shown(kind)}; {suggestion(word, _KINDS)}"
        )
    try:
        return _ADAPTER.validate_python(message)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        # Without the names of the types of operations.
        steps = [str(it) for it in first["loc"][1:] if "[" not in str(it)]
        place = ".".join(steps) or "whole"
        raise MessageError(
            f"the message {kind!r}: {place}: {first['msg']}, got"
            f" {shown(first['input'])}"
        ) from None
    except RecursionError:
        raise MessageError(f"the message {kind!r} is nested too deep") from None


def id_of(message: Any) -> Any:
    """Returns the id of a message; None if it has no valid one."""
    number = message.get("id") if isinstance(message, dict) else None
    is_text = isinstance(number, str) and len(number) <= 200
    return number if is_text or type(number) is int else None
