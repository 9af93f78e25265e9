"""A YAML document as nodes with their lines."""

from dataclasses import dataclass, field
from typing import Any

from hunav_drake.scenario.error import Finding, Loc


@dataclass(frozen=True)
class YamlNode:
    """A part of a document.

    Attributes:
        line: The line where it begins, from 1.
        value: A scalar, a list of nodes, or a mapping from each key to its
            line and node.
        size: How many nodes it unfolds to, itself included.
        height: How many levels of lists and mappings are inside.
    """

    line: int
    value: Any
    size: int = 1
    height: int = 0

    def plain(self) -> Any:
        """Returns it as lists, mappings and scalars of its caller's own."""
        if isinstance(self.value, list):
            return [node.plain() for node in self.value]
        if isinstance(self.value, dict):
            return {key: node.plain() for key, (_, node) in self.value.items()}
        return self.value


@dataclass
class YamlDocument:
    """What was read, and what is wrong with the YAML itself.

    Attributes:
        name: What messages call the document.
        root: The whole, or None if it could not be read at all.
        findings: What is wrong, each with its line (0 for the whole file).
        unread: The parts that have no meaning because of it.
        composed: The nodes of PyYAML, which know where in the text they begin
            and end; an alias is a scalar node of its own.
    """

    name: str
    root: YamlNode | None = None
    findings: list[tuple[int, Finding]] = field(default_factory=list)
    unread: list[Loc] = field(default_factory=list)
    composed: Any = field(default=None, repr=False, compare=False)

    def find(self, loc: Loc) -> YamlNode | None:
        """Returns a part; None if it is not there."""
        node = self.root
        for step in loc:
            node = None if node is None else _step(node, step)[1]
        return node

    def plain(self, loc: Loc = ()) -> Any:
        """Returns a part as plain data; None if it is not there."""
        node = self.find(loc)
        return None if node is None else node.plain()

    def line(self, loc: Loc) -> int:
        """Returns the line of a part, or of the nearest one around it."""
        node = self.root
        line = 0 if node is None else node.line
        for step in loc:
            if node is None:
                break
            found, node = _step(node, step)
            line = found or line
        return line


def _step(node: YamlNode, step: str | int) -> tuple[int, YamlNode | None]:
    """Returns the line and the node of a child, or (0, None)."""
    value = node.value
    if isinstance(step, str) and isinstance(value, dict) and step in value:
        line, inner = value[step]
        return line, inner
    if isinstance(step, int) and isinstance(value, list) and step < len(value):
        return value[step].line, value[step]
    return 0, None
