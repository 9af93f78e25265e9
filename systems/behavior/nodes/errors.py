"""The errors of faulty trees, with the place of the fault."""

from collections.abc import Iterable
from typing import NamedTuple

from hunav_drake.systems.common import suggest
from hunav_drake.systems.common.suggest import shown


class Place(NamedTuple):
    """A line of a file.

    Attributes:
        file: The path of the file, or its name in messages.
        line: The line, from 1; 0 for the file as a whole.
    """

    file: str
    line: int = 0

    def __str__(self) -> str:
        return f"{self.file}:{self.line}" if self.line else self.file


class BehaviorTreeError(ValueError):
    """A fault in a behavior tree.

    Attributes:
        message: The fault, without the place.
        place: Where it is.
        node: The name of the XML element or node; empty for a whole file.
        nearest: The known name that is nearest to an unknown one, or None.
    """

    def __init__(
        self,
        message: str,
        place: Place,
        *,
        node: str = "",
        nearest: str | None = None,
    ) -> None:
        subject = f"<{node}>: " if node else ""
        super().__init__(f"{place}: {subject}{message}")
        self.message = f"{subject}{message}"
        self.place = place
        self.node = node
        self.nearest = nearest


class Spot(NamedTuple):
    """A node or XML element, and where it is written.

    Attributes:
        place: The place.
        node: Its name; empty for a whole file.
    """

    place: Place
    node: str = ""

    def fault(self, message: str) -> BehaviorTreeError:
        """Returns the error for a fault here."""
        return BehaviorTreeError(message, self.place, node=self.node)

    def unknown(
        self, what: str, name: str, known: Iterable[str]
    ) -> BehaviorTreeError:
        """Returns the error for an unknown name, with the nearest known one."""
        names = sorted(known)
        near = suggest.nearest(name, names)
        if near:
            remedy = f"did you mean {near!r}?"
        elif names:
            remedy = f"there is {', '.join(names)}"
        else:
            remedy = "there is none here"
        error = self.fault(f"there is no {what} {shown(name)}; {remedy}")
        error.nearest = near
        return error
