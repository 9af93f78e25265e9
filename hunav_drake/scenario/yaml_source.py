"""Reads YAML text as plain data with the line number of every part.

The text need not be trusted: its size, its nesting, and the number of nodes
after expansion of aliases are limited, and each fault becomes a finding.

Scalars are read as in the core schema of YAML 1.2: `true` and `false` are
Booleans, `null` and `~` are None, decimal numbers (also `1e3`, `.inf`, `.nan`)
are numbers. All else is text: `yes`, `1:30`, `2026-01-31`, `0x1F`, `1_000`.
"""

from dataclasses import replace
import os
from pathlib import Path
import re
import stat
from typing import Any

import yaml
from yaml.composer import Composer
from yaml.resolver import BaseResolver

from hunav_drake.scenario.error import Finding, Loc, shown
from hunav_drake.scenario.yaml_document import YamlDocument, YamlNode

# Limits: the size of a file, in bytes; the number of nodes with aliases
# expanded; the depth of nested lists and mappings.
MAX_BYTES = 16 * 2**20
MAX_NODES = 200_000
MAX_DEPTH = 50

_TOO_DEEP = f"nests deeper than {MAX_DEPTH} levels"

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
_TAGS = {
    kind: frozenset(_CORE_TAG + name for name in names.split())
    for kind, names in (
        (yaml.ScalarNode, "str int float bool null"),
        (yaml.SequenceNode, "seq"),
        (yaml.MappingNode, "map"),
    )
}
# Internal tags, which no document can contain: of unquoted scalars and of
# aliases.
_PLAIN: Any = object()
_ALIAS: Any = object()


def read_yaml(path: str | Path, *, number_keys: bool = False) -> YamlDocument:
    """Reads a YAML file; all faults are findings, also a missing file.

    With `number_keys`, whole numbers as keys are read as text.
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
            # The file may have grown since.
            content = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        return _broken(name, 0, f"cannot be read: {reason}")
    return parse_yaml(content, name=name, number_keys=number_keys)


def parse_yaml(
    text: str | bytes, *, name: str, number_keys: bool = False
) -> YamlDocument:
    """Reads a document, called `name` in messages: see `read_yaml`."""
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
    # The parser compares each directive with all before: many are slow.
    if len(re.findall(r"(?m)^%", text)) > 10:
        return _broken(name, 1, "has more than 10 YAML directives (%)")
    return _read(text, name, number_keys)


def resolve(text: str) -> Any:
    """Returns the value of an unquoted scalar."""
    if text in _CONSTANTS:
        return _CONSTANTS[text]
    if len(text) > 5000:
        return text
    if _INT.fullmatch(text):
        # No range holds a longer one, and Python refuses to parse it.
        return int(text) if len(text) <= 100 else float(text)
    return float(text) if _FLOAT.fullmatch(text) else text


def _too_large(size: int) -> str:
    return f"is too large: at most {MAX_BYTES} bytes, got {size}"


def _broken(name: str, line: int, message: str) -> YamlDocument:
    return YamlDocument(name, None, [(line, Finding((), message))])


class _LimitError(Exception):
    """The document is too deep or too large: (line, message)."""


class _Composer(Composer, BaseResolver):
    """Composes nodes as PyYAML does, within the limits, and keeps aliases.

    An alias becomes a separate scalar node, whose value is the name of the
    anchor; every other node has its anchor as an attribute.
    """

    def __init__(self, parser: Any) -> None:
        Composer.__init__(self)
        BaseResolver.__init__(self)
        self.check_event = parser.check_event
        self.peek_event = parser.peek_event
        self.get_event = parser.get_event
        self.count = 0
        self._depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        event = self.peek_event()
        line = event.start_mark.line + 1
        self.count = _limited(self.count + 1, line)
        if isinstance(event, yaml.AliasEvent):
            self.get_event()
            marks = event.start_mark, event.end_mark
            return yaml.ScalarNode(_ALIAS, event.anchor, *marks)
        if event.tag == "!":
            # This tag marks a scalar as text, as quotes do.
            event.implicit = (False, True)
        # YAML allows to define an anchor again; PyYAML does not.
        self.anchors.clear()
        nests = isinstance(event, yaml.CollectionStartEvent)
        if nests and self._depth == MAX_DEPTH:
            raise _LimitError(line, _TOO_DEEP)
        self._depth += nests
        node = super().compose_node(parent, index)
        self._depth -= nests
        node.anchor = event.anchor
        return node

    def resolve(self, kind: Any, value: Any, implicit: Any) -> Any:
        is_plain = kind is yaml.ScalarNode and implicit[0]
        return _PLAIN if is_plain else super().resolve(kind, value, implicit)


class _Reader:
    """Converts the nodes of PyYAML, with a finding for each fault."""

    def __init__(
        self, document: YamlDocument, count: int, number_keys: bool
    ) -> None:
        self._document = document
        self._number_keys = number_keys
        self._anchors: dict[str, YamlNode | None] = {}
        # The number of nodes, with aliases expanded.
        self._count = count

    def read(self, node: Any, loc: Loc) -> YamlNode:
        """Returns the node of a part of the document, in document order."""
        line = node.start_mark.line + 1
        if node.tag is _ALIAS:
            return self._alias(node.value, line, loc)
        if node.anchor is not None:
            self._anchors[node.anchor] = None
        if node.tag is not _PLAIN:
            self._check_tag(node, line, loc)
        value: Any = node.value
        if isinstance(node, yaml.SequenceNode):
            value = [self.read(part, (*loc, i)) for i, part in enumerate(value)]
            result = _collection(line, value, value)
        elif isinstance(node, yaml.MappingNode):
            value = self._mapping(value, loc)
            result = _collection(line, value, [n for _, n in value.values()])
        else:
            is_text = node.tag == _CORE_TAG + "str"
            result = YamlNode(line, value if is_text else resolve(value))
        if node.anchor is not None:
            self._anchors[node.anchor] = result
        return result

    def _mapping(self, pairs: Any, loc: Loc) -> dict[str, tuple[int, YamlNode]]:
        entries: dict[str, tuple[int, YamlNode]] = {}
        merged: list[YamlNode] = []
        for key_node, value_node in pairs:
            if key_node.tag is _PLAIN and key_node.value == "<<":
                merged += self._merged(value_node, loc)
                continue
            key_part = self.read(key_node, loc)
            key, line = key_part.value, key_part.line
            if self._number_keys and type(key) is int:
                key = str(key)
            if not isinstance(key, str):
                problem = f"a key must be text, got {shown(key)}"
                self._report(line, problem, loc)
                self.read(value_node, (*loc, ""))
                continue
            value = self.read(value_node, (*loc, key))
            if key in entries:
                first = entries[key][0]
                problem = f"is given twice, first in line {first}"
                self._report(line, problem, (*loc, key))
            else:
                entries[key] = (line, value)
        for part in merged:
            for key, entry in part.value.items():
                entries.setdefault(key, entry)
        return entries

    def _merged(self, node: Any, loc: Loc) -> list[YamlNode]:
        """Returns the mappings of a merge key, `<<`."""
        part = self.read(node, loc)
        parts = part.value if isinstance(part.value, list) else [part]
        if all(isinstance(inner.value, dict) for inner in parts):
            return parts
        self._report(part.line, "'<<' must be followed by a mapping", loc)
        return []

    def _alias(self, anchor: str, line: int, loc: Loc) -> YamlNode:
        node = self._anchors.get(anchor)
        if node is not None:
            if len(loc) + node.height > MAX_DEPTH:
                raise _LimitError(line, _TOO_DEEP)
            self._count = _limited(self._count + node.size, line)
            return replace(node, line=line)
        if anchor in self._anchors:
            problem = f"the anchor {shown(anchor)} contains itself"
        else:
            problem = f"there is no anchor {shown(anchor)} before this line"
        self._report(line, problem, loc)
        self._document.unread.append(loc)
        return YamlNode(line, None)

    def _check_tag(self, node: Any, line: int, loc: Loc) -> None:
        if node.tag not in _TAGS[type(node)]:
            tag = node.tag.replace(_CORE_TAG, "!!")
            self._report(line, f"unknown tag {shown(tag)}", loc)
            self._document.unread.append(loc)

    def _report(self, line: int, message: str, loc: Loc) -> None:
        self._document.findings.append((line, Finding(loc, message)))


def _read(text: str, name: str, number_keys: bool) -> YamlDocument:
    composer = _Composer(_Loader(text))
    document = YamlDocument(name)
    try:
        if not composer.check_node():
            return _broken(name, 0, "is empty")
        node = composer.get_node()
        if composer.check_node():
            line = composer.peek_event().start_mark.line + 1
            return _broken(name, line, "holds a second document; one is read")
        reader = _Reader(document, composer.count, number_keys)
        document.root = reader.read(node, ())
        document.composed = node
    except _LimitError as error:
        return _broken(name, *error.args)
    except yaml.YAMLError as error:
        return YamlDocument(name, None, [_syntax_finding(error, text)])
    return document


def _collection(line: int, value: Any, inner: list[YamlNode]) -> YamlNode:
    size = 1 + sum(part.size for part in inner)
    height = 1 + max((part.height for part in inner), default=0)
    return YamlNode(line, value, size, height)


def _limited(count: int, line: int) -> int:
    """Returns the number of nodes so far, or raises if it is too large."""
    if count > MAX_NODES:
        raise _LimitError(line, f"unfolds to more than {MAX_NODES} parts")
    return count


def _syntax_finding(error: Any, text: str) -> tuple[int, Finding]:
    """Returns the error of the parser as a finding, with its line."""
    mark = getattr(error, "problem_mark", None) or getattr(
        error, "context_mark", None
    )
    if mark is None:
        return 1, Finding((), f"is not YAML: {shown(str(error))}")
    problem = getattr(error, "problem", None) or "cannot be read"
    if "nesting depth" in problem:
        # Newer builds of LibYAML limit it themselves, at 1000 levels.
        return mark.line + 1, Finding((), _TOO_DEEP)
    context = getattr(error, "context", None)
    message = f"is not YAML: {problem}" + (f" {context}" if context else "")
    lines = text.splitlines()
    line = lines[mark.line] if mark.line < len(lines) else ""
    if "\t" in line[: len(line) - len(line.lstrip())]:
        message += " (a tab; indent with spaces)"
    where = f"column {mark.column + 1}"
    return mark.line + 1, Finding((), f"{message}, {where}")
