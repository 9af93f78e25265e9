"""The positions of parts in a YAML text: ends, lines, comments, dashes."""

import re
from typing import Any

import yaml

from hunav_drake.scenario.writer import yaml_text
from hunav_drake.scenario.yaml_source import resolve

# Texts that never need quotes.
_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


class Layout:
    """A text, and the positions of its PyYAML nodes."""

    def __init__(self, text: str, root: Any) -> None:
        """Constructs it from a text and its root node."""
        self.text = text
        self.newline = "\r\n" if "\r\n" in text else "\n"
        self.indented = _is_indented(root)

    def start(self, node: Any) -> int:
        """Returns the start of a node."""
        return int(node.start_mark.index)

    def end(self, node: Any) -> int:
        """Returns the end of a node, without trailing comments and blanks."""
        if isinstance(node, yaml.CollectionNode) and not node.flow_style:
            last = node.value[-1] if node.value else None
            if isinstance(last, tuple):
                # The mark of an empty value is after the colon.
                return max(self.end(last[1]), self.end(last[0]))
            if last is not None:
                return self.end(last)
        end = int(node.end_mark.index)
        if getattr(node, "style", None) in ("|", ">"):
            start = self.start(node)
            head = self.text[start:end].split("\n", 1)[0]
            if "+" in head:
                end -= self.text[start:end].endswith("\n")
            else:
                end = start + len(self.text[start:end].rstrip(" \t\r\n"))
            end -= self.text[start:end].endswith("\r")
        return end

    def line_start(self, index: int) -> int:
        """Returns the start of the line of an index."""
        return self.text.rfind("\n", 0, index) + 1

    def line_end(self, index: int) -> int:
        """Returns the end of the line of an index, before its line break."""
        end = self.text.find("\n", index)
        end = len(self.text) if end < 0 else end
        return end - (end > index and self.text[end - 1] == "\r")

    def next_line(self, index: int) -> int:
        """Returns the start of the next line after an index."""
        end = self.text.find("\n", index)
        return len(self.text) if end < 0 else end + 1

    def is_first(self, index: int) -> bool:
        """Returns whether only spaces precede an index in its line."""
        return not self.text[self.line_start(index) : index].strip(" ")

    def has_rest(self, index: int) -> bool:
        """Returns whether more than a comment follows in the line."""
        rest = self.text[index : self.line_end(index)].strip()
        return bool(rest) and not rest.startswith("#")

    def above(self, index: int, column: int) -> int:
        """Returns the start of the comments above a line, in a column."""
        start = self.line_start(index)
        while start > 0:
            before = self.line_start(start - 1)
            line = self.text[before : start - 1]
            at = len(line) - len(line.lstrip(" "))
            if at != column or not line.lstrip().startswith("#"):
                break
            start = before
        return start

    def below(self, index: int, column: int) -> int:
        """Returns the end of the lines of a part that ends at an index.

        Comments in the next lines belong to it if they are indented more than
        the column.
        """
        end = self.next_line(index)
        while end < len(self.text):
            line = self.text[end : self.line_end(end)]
            at = len(line) - len(line.lstrip(" "))
            if at <= column or not line.lstrip().startswith("#"):
                break
            end = self.next_line(end)
        return end

    def dash(self, item: Any, column: int) -> int | None:
        """Returns the index of the dash of an item; None if not found."""
        start = self.line_start(self.start(item))
        limit = self.start(item)
        while True:
            place = start + column
            line = self.text[start : self.line_end(start)]
            if place < limit and line[column : column + 1] == "-":
                before, behind = line[:column], line[column + 1 : column + 2]
                if not before.strip(" -") and behind in ("", " ", "\t"):
                    return place
            rest = line.strip()
            is_passed = start >= self.line_start(limit) or not rest
            if start == 0 or not (is_passed or rest.startswith("#")):
                return None
            start = self.line_start(start - 1)

    def rendered(self, value: Any, column: int, *, flow: bool) -> str:
        """Returns the text of a value after a colon or a dash.

        Args:
            value: Plain data.
            column: The column of the key or of the dash.
            flow: Whether it is in braces or brackets.
        """
        is_block = not flow and isinstance(value, dict | list) and bool(value)
        if is_block and isinstance(value, list):
            is_block = any(isinstance(it, dict | list) for it in value)
        if not is_block:
            is_text = isinstance(value, str) and not flow
            if is_text and ("\n" in value or len(value) > 60):
                return self.shifted(value, column)
            return " " + scalar_text(value, flow=flow)
        return self.shifted(value, column)

    def shifted(self, value: Any, column: int) -> str:
        """Returns the lines of a value after a colon."""
        text = yaml_text(
            {"k": value}, indented=self.indented, width=max(80 - column, 20)
        )
        lines = text.removesuffix("\n").split("\n")
        pad = " " * column
        rest = [pad + line if line else line for line in lines[1:]]
        return self.newline.join([lines[0].removeprefix("k:"), *rest])

    def item(self, value: Any, column: int, *, flow: bool) -> str:
        """Returns an item of a list with its dash, without indentation."""
        if flow or not isinstance(value, dict) or not value:
            if isinstance(value, list) and not flow:
                inner = self.rendered(value, column, flow=False)
                return "-" + inner
            return "-" + self.rendered(value, column, flow=flow)
        text = yaml_text(
            [value], indented=self.indented, width=max(80 - column, 20)
        )
        lines = text.removesuffix("\n").split("\n")
        pad = " " * column
        rest = [pad + line if line else line for line in lines[1:]]
        return self.newline.join([lines[0], *rest])


def scalar_text(value: Any, *, flow: bool = True) -> str:
    """Returns the text of a value in one line.

    Args:
        value: Plain data.
        flow: Whether it may be in braces or brackets.
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, str):
        if _WORD.fullmatch(value) and isinstance(resolve(value), str):
            return value
        if flow:
            return yaml_text([value], flow=True)[1:-1]
    return yaml_text(value, flow=True)


def key_text(key: str) -> str:
    """Returns a key with its colon."""
    return yaml_text({key: 0}, flow=True)[1:-2].rstrip()


def _is_indented(root: Any) -> bool:
    """Returns whether lists are indented more than their keys."""
    todo = [root]
    while todo:
        node = todo.pop(0)
        if not isinstance(node, yaml.MappingNode):
            continue
        for key, value in node.value:
            if isinstance(value, yaml.SequenceNode) and not value.flow_style:
                return bool(value.start_mark.column > key.start_mark.column)
            todo.append(value)
    return True
