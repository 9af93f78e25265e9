"""A YAML document as nodes with their line numbers."""

from dataclasses import dataclass, field
from typing import Any

from hunav_drake.scenario.error import Finding, Loc


@dataclass(frozen=True)
class YamlNode:
    """A part of a document.

    Attributes:
        line: Its first line, from 1.
        value: A scalar, a list of nodes, or a mapping of keys to pairs (line,
            node).
        size: Its number of nodes with aliases expanded, itself included.
        height: The number of nested levels of lists and mappings in it.
    """

    line: int
    value: Any
    size: int = 1
    height: int = 0

    def plain(self) -> Any:
        """Returns a copy of it as lists, mappings and scalars."""
        if isinstance(self.value, list):
            return [node.plain() for node in self.value]
        if isinstance(self.value, dict):
            return {key: node.plain() for key, (_, node) in self.value.items()}
        return self.value


@dataclass
class YamlDocument:
    """The content of a document, and the faults of its YAML.

    Attributes:
        name: The name of the document in messages.
        root: The root node; None if the document cannot be read at all.
        findings: The faults, each with its line (0 for the whole file).
        unread: The parts that have no meaning because of faults.
        composed: The root node of PyYAML, whose nodes have their positions in
            the text; an alias is a separate scalar node.
    """

    name: str
    root: YamlNode | None = None
    findings: list[tuple[int, Finding]] = field(default_factory=list)
    unread: list[Loc] = field(default_factory=list)
    composed: Any = field(default=None, repr=False, compare=False)

    def find(self, loc: Loc) -> YamlNode | None:
        """Returns the node of a part; None if it does not exist."""
        node = self.root
        for step in loc:
            node = None if node is None else _step(node, step)[1]
        return node

    def plain(self, loc: Loc = ()) -> Any:
        """Returns a part as plain data; None if it does not exist."""
        node = self.find(loc)
        return None if node is None else node.plain()

    def line(self, loc: Loc) -> int:
        """Returns the line of a part, or of the part around it that exists."""
        node = self.root
        line = 0 if node is None else node.line
        for step in loc:
            if node is None:
                break
            found, node = _step(node, step)
            line = found or line
        return line


def _step(node: YamlNode, step: str | int) -> tuple[int, YamlNode | None]:
    """Returns the line and the node of a child; (0, None) if there is none."""
    value = node.value
    if isinstance(step, str) and isinstance(value, dict) and step in value:
        line, inner = value[step]
        return line, inner
    if isinstance(step, int) and isinstance(value, list) and step < len(value):
        return value[step].line, value[step]
    return 0, None
