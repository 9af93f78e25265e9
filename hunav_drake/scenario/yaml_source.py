"""Reads YAML text as plain data, and remembers the line of every part.

The text may come from anywhere: its size, its nesting, and what its anchors
unfold to are limited, and whatever is wrong with it becomes a finding.

Words are read as in the core schema of YAML 1.2: `true` and `false` are flags,
`null` and `~` are nothing, decimal numbers (also `1e3`, `.inf`, `.nan`) are
numbers. All else is text: `yes`, `1:30`, `2026-01-31`, `0x1F`, `1_000`.
"""

from dataclasses import dataclass, field, replace
import os
from pathlib import Path
import re
import stat
from typing import Any

import yaml

from hunav_drake.scenario.error import Finding, Loc, shown
from hunav_drake.scenario.yaml_document import YamlDocument, YamlNode

# The largest file, in bytes; the most parts it may unfold to; how deep lists
# and mappings may nest.
MAX_BYTES = 16 * 2**20
MAX_NODES = 200_000
MAX_DEPTH = 50

# LibYAML's parser is ten times faster; not every build of PyYAML has it.
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

_INT = re.compile(r"[-+]?(0|[1-9][0-9]*)")
_FLOAT = re.compile(
    r"[-+]?(\.[0-9]+|(0|[1-9][0-9]*)(\.[0-9]*)?)([eE][-+]?[0-9]+)?"
)
_CONSTANTS = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **{
        sign + word: float(sign + "inf")
        for sign in ("", "+", "-")
        for word in (".inf", ".Inf", ".INF")
    },
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}
_NOT_TEXT = re.compile(
    "[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]"
)
_CORE_TAG = "tag:yaml.org,2002:"
_MERGE: Any = object()


def read_yaml(path: str | Path) -> YamlDocument:
    """Reads a file of YAML; never raises for what is in it.

    Args:
        path: The file. A directory, a pipe or a missing file is a finding.
    """
    name = str(path)
    try:
        status = os.stat(path)
        if stat.S_ISDIR(status.st_mode):
            return _broken(name, 0, "is a directory, not a file")
        if not stat.S_ISREG(status.st_mode):
            return _broken(name, 0, "is not a regular file")
        if status.st_size > MAX_BYTES:
            return _broken(name, 0, _too_large(status.st_size))
        with open(path, "rb") as file:
            # It may have grown since.
            content = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        return _broken(name, 0, f"cannot be read: {reason}")
    return parse_yaml(content, name=name)


def parse_yaml(text: str | bytes, *, name: str) -> YamlDocument:
    """Reads YAML from text, or from bytes in UTF-8; never raises for it.

    Args:
        text: One document.
        name: What messages call it.
    """
    if len(text) > MAX_BYTES:
        return _broken(name, 0, _too_large(len(text)))
    if isinstance(text, bytes):
        try:
            text = text.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            content, start = error.object, error.start
            line = content.count(b"\n", 0, start) + 1
            what = f"byte 0x{content[start]:02x} at offset {start}"
            return _broken(name, line, f"is not UTF-8 text: {what}")
    if bad := _NOT_TEXT.search(text):
        line = text.count("\n", 0, bad.start()) + 1
        what = f"character U+{ord(bad.group()):04X} at offset {bad.start()}"
        return _broken(name, line, f"is not a text file: {what}")
    # Each directive is compared with all before it, so many of them are slow.
    if len(re.findall(r"(?m)^%", text)) > 10:
        return _broken(name, 1, "has more than 10 YAML directives (%)")
    return _Reader(name).read(text)


def resolve(text: str) -> Any:
    """Returns what an unquoted word stands for."""
    if text in _CONSTANTS:
        return _CONSTANTS[text]
    if len(text) > 5000:
        return text
    if _INT.fullmatch(text):
        # Beyond any range, and Python refuses to read very long integers.
        return int(text) if len(text) <= 100 else float(text)
    return float(text) if _FLOAT.fullmatch(text) else text


def _too_large(size: int) -> str:
    return f"is too large: at most {MAX_BYTES} bytes, got {size}"


def _broken(name: str, line: int, message: str) -> YamlDocument:
    return YamlDocument(name, None, [(line, Finding((), message))])


class _StopReadingError(Exception):
    """The rest of the document cannot be read, or must not be."""


@dataclass
class _Frame:
    """A list or mapping whose end has not come yet."""

    line: int
    anchor: str | None
    # A list of nodes, or a mapping from keys to (line, node).
    value: Any
    # The key whose value comes next, its line, and whether the value counts.
    key: Any = None
    key_line: int = 0
    wanted: bool = True
    merged: list[YamlNode] = field(default_factory=list)


class _Reader:
    """Builds the nodes of one document from the parser's events.

    A stack of our own, not recursion, so that the depth is looked at before
    anything is spent on it.
    """

    def __init__(self, name: str) -> None:
        self._document = YamlDocument(name)
        self._stack: list[_Frame] = []
        self._anchors: dict[str, YamlNode | None] = {}
        self._count = 0

    def read(self, text: str) -> YamlDocument:
        document = self._document
        try:
            for event in yaml.parse(text, Loader=_Loader):
                self._take(event)
            if document.root is None:
                document.findings.append((0, Finding((), "is empty")))
        except _StopReadingError:
            document.root = None
        except yaml.YAMLError as error:
            document.root = None
            document.findings.append(_syntax_finding(error, text))
        return document

    def _take(self, event: Any) -> None:
        line = event.start_mark.line + 1
        if isinstance(event, yaml.AliasEvent):
            node = self._alias(event.anchor, line)
            self._spend(line, node.size)
            self._add(node)
        elif isinstance(event, yaml.ScalarEvent):
            self._check_tag(event, line, ("str", "int", "float", "bool"))
            self._spend(line, 1)
            self._add(self._scalar(event, line))
        elif isinstance(event, yaml.CollectionStartEvent):
            is_list = isinstance(event, yaml.SequenceStartEvent)
            self._check_tag(event, line, ("seq",) if is_list else ("map",))
            if len(self._stack) >= MAX_DEPTH:
                self._stop(line, f"nests deeper than {MAX_DEPTH} levels")
            self._spend(line, 1)
            self._push(_Frame(line, event.anchor, [] if is_list else {}))
        elif isinstance(event, yaml.CollectionEndEvent):
            self._close()
        elif (
            isinstance(event, yaml.DocumentStartEvent)
            and self._document.root is not None
        ):
            self._stop(line, "holds a second document; one is read")

    def _push(self, frame: _Frame) -> None:
        self._stack.append(frame)
        if frame.anchor is not None:
            self._anchors[frame.anchor] = None

    def _close(self) -> None:
        frame = self._stack.pop()
        value = frame.value
        if isinstance(value, dict):
            for node in frame.merged:
                for key, entry in node.value.items():
                    value.setdefault(key, entry)
            inner = [node for _, node in value.values()]
        else:
            inner = value
        node = YamlNode(
            frame.line,
            value,
            size=1 + sum(node.size for node in inner),
            height=1 + max((node.height for node in inner), default=0),
        )
        if frame.anchor is not None:
            self._anchors[frame.anchor] = node
        self._add(node)

    def _scalar(self, event: Any, line: int) -> YamlNode:
        text, tag = event.value, event.tag
        bare = event.implicit[0] and tag is None
        is_text = tag in ("!", _CORE_TAG + "str")
        at_key = (
            self._stack
            and isinstance(self._stack[-1].value, dict)
            and self._stack[-1].key is None
        )
        value: Any = text
        if (bare or tag is not None) and not is_text:
            value = resolve(text)
        node = YamlNode(line, value)
        if event.anchor is not None:
            self._anchors[event.anchor] = node
        is_merge = bare and at_key and text == "<<"
        return YamlNode(line, _MERGE) if is_merge else node

    def _alias(self, anchor: str, line: int) -> YamlNode:
        node = self._anchors.get(anchor)
        if node is not None:
            if len(self._stack) + node.height > MAX_DEPTH:
                self._stop(line, f"nests deeper than {MAX_DEPTH} levels")
            return replace(node, line=line)
        if anchor in self._anchors:
            problem = f"the anchor {shown(anchor)} contains itself"
        else:
            problem = f"there is no anchor {shown(anchor)} before this line"
        self._document.unread.append(self._report(line, problem))
        return YamlNode(line, None)

    def _add(self, node: YamlNode) -> None:
        """Puts a complete node where it belongs."""
        if not self._stack:
            self._document.root = node
            return
        frame = self._stack[-1]
        if isinstance(frame.value, list):
            frame.value.append(node)
        elif frame.key is None:
            self._take_key(frame, node)
        else:
            self._take_value(frame, node)

    def _spend(self, line: int, size: int) -> None:
        """Counts the parts of the document, aliases unfolded."""
        self._count += size
        if self._count > MAX_NODES:
            self._stop(line, f"unfolds to more than {MAX_NODES} parts")

    def _take_key(self, frame: _Frame, node: YamlNode) -> None:
        key: Any = node.value
        line = node.line
        wanted = True
        if key is not _MERGE and not isinstance(key, str):
            self._report(line, f"a key must be text, got {shown(key)}")
            key, wanted = "", False
        elif key in frame.value:
            first = frame.value[key][0]
            self._report(line, f"is given twice, first in line {first}", key)
            wanted = False
        frame.key, frame.key_line, frame.wanted = key, line, wanted

    def _take_value(self, frame: _Frame, node: YamlNode) -> None:
        key, frame.key = frame.key, None
        if key is _MERGE:
            nodes = node.value if isinstance(node.value, list) else [node]
            if all(isinstance(inner.value, dict) for inner in nodes):
                frame.merged += nodes
            else:
                self._report(node.line, "'<<' must be followed by a mapping")
        elif frame.wanted:
            frame.value[key] = (frame.key_line, node)

    def _check_tag(self, event: Any, line: int, known: tuple[str, ...]) -> None:
        tag = event.tag
        if tag in (None, "!", _CORE_TAG + "null"):
            return
        if tag not in [_CORE_TAG + name for name in known]:
            tag = tag.replace(_CORE_TAG, "!!")
            problem = f"unknown tag {shown(tag)}"
            self._document.unread.append(self._report(line, problem))

    def _report(self, line: int, message: str, *more: str | int) -> Loc:
        loc: list[str | int] = []
        for frame in self._stack:
            if isinstance(frame.value, list):
                loc.append(len(frame.value))
            elif isinstance(frame.key, str):
                loc.append(frame.key)
        found = Finding((*loc, *more), message)
        self._document.findings.append((line, found))
        return found.loc

    def _stop(self, line: int, message: str) -> None:
        self._report(line, message)
        raise _StopReadingError


def _syntax_finding(error: Any, text: str) -> tuple[int, Finding]:
    """Returns what the parser complains about, with its line."""
    mark = getattr(error, "problem_mark", None) or getattr(
        error, "context_mark", None
    )
    if mark is None:
        return 1, Finding((), f"is not YAML: {shown(str(error))}")
    problem = getattr(error, "problem", None) or "cannot be read"
    context = getattr(error, "context", None)
    message = f"is not YAML: {problem}" + (f" {context}" if context else "")
    lines = text.splitlines()
    line = lines[mark.line] if mark.line < len(lines) else ""
    if "\t" in line[: len(line) - len(line.lstrip())]:
        message += " (a tab; indent with spaces)"
    where = f"column {mark.column + 1}"
    return mark.line + 1, Finding((), f"{message}, {where}")
