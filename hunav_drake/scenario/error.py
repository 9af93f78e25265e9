"""The exception for faulty scenarios, and the faults that it lists."""

from collections.abc import Iterable
from dataclasses import dataclass
import re
from typing import Any

from hunav_drake.systems.common.suggest import (
    shown as shown,
    suggestion as suggestion,
)

# The path of a part of a scenario: field names, and indices of lists.
Loc = tuple[str | int, ...]

# How many faults a message spells out; all are in `ScenarioError.faults`.
_MAX_SPELLED_OUT = 50


@dataclass(frozen=True)
class Finding:
    """A fault without its file and line.

    Attributes:
        loc: The faulty part.
        message: The rule, the value found, and a remedy.
        uses: The other parts that the finding depends on. If one of them is
            faulty, the finding is dropped.
    """

    loc: Loc
    message: str
    uses: tuple[Loc, ...] = ()


@dataclass(frozen=True)
class Fault:
    """One fault of a scenario.

    Attributes:
        source: Its source: the name of a file, "--set robot.radius=x", or
            "scenario" for a scenario made in Python.
        line: The line of the file, from 1; 0 for the whole file.
        path: The faulty part, as in "humans[1] ('ana').max_speed"; empty for
            the whole scenario.
        message: The rule, the value found, and a remedy.
    """

    source: str
    line: int
    path: str
    message: str

    @property
    def place(self) -> str:
        """Source and line, as in "passing.yaml:14"."""
        return f"{self.source}:{self.line}" if self.line else self.source

    def __str__(self) -> str:
        parts = (self.place, self.path, self.message)
        return ": ".join(part for part in parts if part)


class ScenarioError(ValueError):
    """A scenario cannot be read or simulated.

    Attributes:
        source: The name of the file, "data" for text, or "scenario".
        faults: All faults, at least one, by line; those of other sources come
            last.
    """

    def __init__(self, source: str, faults: Iterable[Fault]) -> None:
        """Constructs the error from the name of the source and the faults."""
        self.source = source
        self.faults = tuple(
            sorted(faults, key=lambda it: (it.source != source, it.line))
        )
        # Both are arguments of ValueError, so that the error can be pickled.
        super().__init__(source, self.faults)

    def __str__(self) -> str:
        count = len(self.faults)
        lines = [f"{self.source}: {count} fault{'s' if count != 1 else ''}"]
        lines += [str(fault) for fault in self.faults[:_MAX_SPELLED_OUT]]
        if count > _MAX_SPELLED_OUT:
            lines.append(f"... and {count - _MAX_SPELLED_OUT} more")
        return "\n".join(lines)


def child(data: Any, step: str | int) -> Any:
    """Returns a part of plain data or of a dataclass; None if missing."""
    if isinstance(step, int):
        is_list = isinstance(data, list | tuple)
        return data[step] if is_list and 0 <= step < len(data) else None
    if isinstance(data, dict):
        return data.get(step)
    return getattr(data, step, None)


def path_text(data: Any, loc: Loc) -> str:
    """Returns a path in data as text: "humans[1] ('ana').max_speed"."""
    text = ""
    for step in loc:
        data = child(data, step)
        if isinstance(step, int):
            name = child(data, "name")
            named = isinstance(name, str) and name
            text += f"[{step}]" + (f" ({shown(name)})" if named else "")
        else:
            plain = re.fullmatch(r"[\w-]{1,60}", step)
            key = step if plain else shown(step)
            text += f".{key}" if text else key
    return text
