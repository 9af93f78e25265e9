"""A scenario as text and as data."""

from collections.abc import Iterator, Sequence
import dataclasses as dc
from typing import Any

from hunav_drake.editor.document.plain_data import (
    OperationError,
    apply,
    check_plain,
    shared,
)
from hunav_drake.editor.document.yaml_patch import YamlPatch, patch_yaml
from hunav_drake.scenario.error import Loc, shown
from hunav_drake.scenario.yaml_document import YamlDocument
from hunav_drake.scenario.yaml_source import MAX_BYTES, parse_yaml

# Lists with selectable members.
_SELECTABLE: tuple[Loc, ...] = (
    ("humans",),
    ("world", "walls"),
    ("world", "furniture"),
    ("world", "models"),
)


@dc.dataclass(frozen=True)
class Document:
    """A text and its data, both immutable.

    Attributes:
        text: The YAML text.
        data: The scenario in it, as plain data; the previous data if the text
            cannot be read.
        yaml: The parsed document.
        prefix: The path of the scenario in the text.
        problem: Why the text cannot be read; empty if it can.
    """

    text: str
    data: dict[str, Any]
    yaml: YamlDocument
    prefix: Loc = ()
    problem: str = ""

    @classmethod
    def read(
        cls, text: str, prefix: Loc = (), like: "Document | None" = None
    ) -> "Document":
        """Returns the document of a text.

        Args:
            text: The text.
            prefix: The path of the scenario in it.
            like: The previous document, to share equal parts with.
        """
        yaml = parse_yaml(text, name="scenario")
        old = like.data if like is not None else {}
        if yaml.root is None:
            is_empty = not _without_comments(text)
            if is_empty and not prefix:
                return cls(text, {}, yaml, prefix)
            return cls(text, old, yaml, prefix, "the text is not YAML")
        data = yaml.plain(prefix)
        if not isinstance(data, dict):
            problem = f"a scenario is a mapping, but the text is {shown(data)}"
            if prefix:
                problem = f"there is no scenario {shown(prefix[0])} in the text"
            return cls(text, old, yaml, prefix, problem)
        return cls(text, shared(old, data), yaml, prefix)

    @property
    def is_empty(self) -> bool:
        """Whether the text is empty, apart from comments."""
        return self.yaml.root is None and not self.problem

    def after(self, operations: Sequence[Sequence[Any]]) -> dict[str, Any]:
        """Returns the data after some operations.

        Raises:
            OperationError: If they do not fit, or the text is not readable.
        """
        if self.problem:
            raise OperationError(f"{self.problem}; fix it first")
        for operation in operations:
            for value in operation[2:]:
                check_plain(value)
        data = apply(self.data, operations)
        if not isinstance(data, dict):
            raise OperationError("a scenario must be a mapping")
        return data

    def patched(self, data: dict[str, Any]) -> tuple["Document", YamlPatch]:
        """Returns a document with other data, and the patch of its text.

        Raises:
            OperationError: If the data cannot be written as YAML.
        """
        try:
            patch = patch_yaml(
                self.text, self.yaml, self.data, data, self.prefix
            )
        except ValueError as error:
            raise OperationError(str(error)) from error
        if len(patch.text) > MAX_BYTES:
            raise OperationError(f"a scenario has at most {MAX_BYTES} bytes")
        new = dc.replace(
            self, text=patch.text, data=data, yaml=patch.document, problem=""
        )
        return new, patch

    def line(self, loc: Sequence[str | int]) -> int | None:
        """Returns the line of a part, or of the smallest part around it."""
        return self.yaml.line((*self.prefix, *loc)) or None

    def places(self) -> Iterator[tuple[Loc, int, int]]:
        """Yields the selectable parts, with their first and last lines."""
        if self.problem or self.is_empty:
            return
        root = _node(self.yaml.composed, self.prefix)
        for loc in _SELECTABLE:
            items = _node(root, loc)
            if isinstance(getattr(items, "value", None), list):
                for i, item in enumerate(items.value):
                    if not isinstance(item, tuple):
                        yield (*loc, i), *_lines(item)
                        yield from _goals(item, (*loc, i))
        for loc in (("robot",), ("robot", "start"), ("robot", "goal")):
            node = _node(root, loc)
            if node is not None:
                yield loc, *_lines(node)
        # Of several robots, the start stands for all of a robot.
        members = getattr(_node(root, ("robots",)), "value", None) or ()
        for i in range(len(members) if isinstance(members, list) else 0):
            for loc, part in ((), "start"), (("robot", "goal"), "goal"):
                node = _node(root, ("robots", i, *loc))
                if node is not None:
                    yield ("robots", i, "robot", part), *_lines(node)


def _goals(item: Any, loc: Loc) -> Iterator[tuple[Loc, int, int]]:
    goals = _node(item, ("goals",))
    if loc[0] == "humans" and isinstance(getattr(goals, "value", None), list):
        for k, goal in enumerate(goals.value):
            if not isinstance(goal, tuple):
                yield (*loc, "goals", k), *_lines(goal)


def _node(node: Any, loc: Sequence[str | int]) -> Any:
    """Returns the node of PyYAML at a path; None if there is none."""
    for step in loc:
        value = getattr(node, "value", None)
        if not isinstance(value, list):
            return None
        pairs = [it for it in value if isinstance(it, tuple)]
        if isinstance(step, str):
            found = (v for k, v in pairs if k.value == step)
            node = next(found, None)
        else:
            node = value[step] if not pairs and step < len(value) else None
    return node


def _lines(node: Any) -> tuple[int, int]:
    """Returns the first and the last line of a node, from 1."""
    first, last = node.start_mark.line + 1, node.end_mark.line + 1
    inner = node
    # PyYAML's end of a block includes the lines after its last scalar.
    while not getattr(inner, "flow_style", True) and inner.value:
        item = inner.value[-1]
        inner = item[1] if isinstance(item, tuple) else item
        last = inner.end_mark.line + 1
    if getattr(inner, "style", None) in ("|", ">"):
        last -= 1
    return first, max(first, last)


def _without_comments(text: str) -> str:
    lines = (line.strip() for line in text.lstrip("\ufeff").splitlines())
    return "".join(line for line in lines if not line.startswith("#"))
