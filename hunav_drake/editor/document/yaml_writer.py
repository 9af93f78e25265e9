"""Writes changed data into a text, each part in its place."""

from collections.abc import Sequence
import difflib
from typing import Any

import yaml

from hunav_drake.editor.document.plain_data import same
from hunav_drake.editor.document.text_patch import Patch, Patches
from hunav_drake.editor.document.yaml_layout import (
    Layout,
    key_text,
    scalar_text,
)
from hunav_drake.scenario.error import Loc
from hunav_drake.scenario.writer import yaml_text

# In lists with more changed items, moved ones are not searched.
_MAX_MATCHED = 200


class UnknownPlaceError(Exception):
    """The position of a part is unknown."""


class YamlWriter:
    """Collects the patches of one change."""

    def __init__(self, layout: Layout, depth: int | None) -> None:
        """Starts without patches.

        Args:
            layout: The text.
            depth: The depth at which different parts are rewritten as a whole;
                None for no limit.
        """
        self._layout = layout
        self._depth = depth
        self._patches: list[Patch] = []

    def patches(self) -> Patches:
        """Returns the patches, in order."""
        return tuple(sorted(self._patches))

    def write(
        self, node: Any, old: Any, new: Any, loc: Loc, key: Any = None
    ) -> None:
        """Changes the data of a node.

        Args:
            node: The node.
            old: Its data.
            new: Its new data.
            loc: Its path.
            key: The node of its key, if it is in a mapping.
        """
        if same(old, new):
            return
        is_inner = self._depth is None or len(loc) < self._depth
        # Empty lists and mappings have another syntax.
        kinds = (type(old), type(new)) if is_inner and old and new else ()
        if kinds == (dict, dict) and isinstance(node, yaml.MappingNode):
            self._write_mapping(node, old, new, loc)
        elif kinds == (list, list) and isinstance(node, yaml.SequenceNode):
            self._write_list(node, old, new, loc)
        else:
            self._replace(node, new, loc, key)

    def _add(self, start: int, end: int, new: str) -> None:
        old = self._layout.text[start:end]
        if old != new:
            self._patches.append(Patch(start, old, new))

    def _replace(self, node: Any, new: Any, loc: Loc, key: Any) -> None:
        """Rewrites a value."""
        layout = self._layout
        start, end = layout.start(node), layout.end(node)
        if getattr(node, "in_flow", False):
            gap = " " if start == end else ""
            self._add(start, end, gap + scalar_text(new))
        elif not loc:
            body = yaml_text(new, indented=layout.indented).rstrip("\n")
            self._add(start, end, body.replace("\n", layout.newline))
        elif key is None:
            self._replace_item(node, new)
        else:
            self._replace_value(node, new, key)

    def _replace_value(self, node: Any, new: Any, key: Any) -> None:
        """Rewrites the value after a key and its colon."""
        layout = self._layout
        start, end = layout.start(node), layout.end(node)
        body = layout.rendered(new, key.start_mark.column, flow=False)
        colon = layout.text.find(":", layout.end(key))
        if not 0 <= colon <= start:
            raise UnknownPlaceError
        is_inline = layout.line_end(colon) >= start
        if not is_inline and not layout.has_rest(end):
            # A comment after its last line is removed with it.
            end = layout.line_end(end)
        if is_inline and start < end and not body.startswith(layout.newline):
            self._add(start, end, body.removeprefix(" "))
        elif is_inline:
            self._add(min(colon + 1, start), end, body)
        elif body.startswith(layout.newline):
            # A comment after the colon stays.
            self._add(layout.line_end(colon), end, body)
        elif layout.newline in body:
            self._add(colon + 1, end, body)
        else:
            self._add(colon + 1, colon + 1, body)
            self._add(layout.line_end(colon), end, "")

    def _replace_item(self, node: Any, new: Any) -> None:
        layout = self._layout
        start, end = layout.start(node), layout.end(node)
        # The dash is the last one before it, in this line or above.
        place = layout.text.rfind("-", 0, start)
        while place >= 0:
            column = place - layout.line_start(place)
            if layout.dash(node, column) == place:
                body = layout.item(new, column, flow=False)
                self._add(place, end, body)
                return
            place = layout.text.rfind("-", 0, place)
            if place < start - 2000:
                break
        raise UnknownPlaceError

    def _write_mapping(self, node: Any, old: Any, new: Any, loc: Loc) -> None:
        pairs: dict[str, tuple[Any, Any]] = {}
        for key, value in node.value:
            pairs.setdefault(key.value, (key, value))
            _mark_flow(node, value)
        gone = [key for key in old if key not in new]
        added = {key: new[key] for key in new if key not in pairs}
        added = {
            key: value
            for key, value in added.items()
            if key not in old or not same(old[key], value)
        }
        if any(key not in pairs for key in gone):
            # It comes from a mapping that is merged in.
            raise UnknownPlaceError
        if (gone or added) and node.flow_style:
            self._write_flow(
                node,
                [(pairs[key], old[key]) for key in pairs if key in old],
                [(key, new[key]) for key in pairs if key in new]
                + list(added.items()),
                is_mapping=True,
            )
            return
        for key, (key_node, value) in pairs.items():
            if key in old and key in new:
                self.write(value, old[key], new[key], (*loc, key), key_node)
        if len(gone) == len(pairs):
            raise UnknownPlaceError
        for key in gone:
            self._remove_entry(node, list(pairs.values()), pairs[key])
        if added:
            kept = [it for it in node.value if it[0].value not in gone]
            self._add_entries(node, kept[-1], added)

    def _remove_entry(
        self, node: Any, pairs: Sequence[tuple[Any, Any]], pair: Any
    ) -> None:
        layout = self._layout
        start, end = layout.start(pair[0]), layout.end(pair[1])
        end = max(end, layout.end(pair[0]) + 1)
        column = pair[0].start_mark.column
        if layout.is_first(start):
            self._add(
                layout.above(start, column), layout.below(end, column), ""
            )
            return
        # It stands behind a dash; the next one comes there.
        following = pairs[pairs.index(pair) + 1 :]
        if not following or layout.has_rest(end):
            raise UnknownPlaceError
        self._add(start, layout.start(following[0][0]), "")

    def _add_entries(
        self, node: Any, last: tuple[Any, Any], added: dict[str, Any]
    ) -> None:
        """Adds entries to a mapping, after the last one that stays."""
        layout = self._layout
        column = node.value[0][0].start_mark.column
        end = max(layout.end(last[1]), layout.end(last[0]) + 1)
        if layout.has_rest(end):
            raise UnknownPlaceError
        place = layout.line_end(end)
        body = "".join(
            layout.newline
            + " " * column
            + key_text(key)
            + layout.rendered(value, column, flow=False)
            for key, value in added.items()
        )
        self._add(place, place, body)

    def _write_list(self, node: Any, old: Any, new: Any, loc: Loc) -> None:
        items = node.value
        for item in items:
            _mark_flow(node, item)
        moves = _matched(old, new)
        if all(tag == "same" for tag, *_ in moves):
            for _, i, j in moves:
                self.write(items[i], old[i], new[j], (*loc, i))
        elif node.flow_style:
            self._write_flow(
                node,
                [
                    ((None, it), value)
                    for it, value in zip(items, old, strict=True)
                ],
                [(None, value) for value in new],
                is_mapping=False,
            )
        else:
            self._write_items(node, old, new, loc, moves)

    def _write_items(
        self,
        node: Any,
        old: Any,
        new: Any,
        loc: Loc,
        moves: list[tuple[str, int, int]],
    ) -> None:
        """Writes items of a list with dashes; `moves` is of `_matched`."""
        layout = self._layout
        column = node.start_mark.column
        chunks = self._chunks(node.value, column)
        removed = [i for tag, i, _ in moves if tag == "remove"]
        place = chunks[0][0]
        flow = _is_flow(node.value[0])
        # Items that are inserted at one index keep their order.
        inserted: dict[int, str] = {}
        for tag, i, j in moves:
            if tag == "same":
                self.write(node.value[i], old[i], new[j], (*loc, i))
                place = chunks[i][1]
                flow = _is_flow(node.value[i])
            elif tag == "remove":
                self._add(*chunks[i], "")
                place = chunks[i][1]
            else:
                source = next((k for k in removed if same(old[k], new[j])), -1)
                if source >= 0:
                    removed.remove(source)
                    body = layout.text[slice(*chunks[source])]
                    body = body.removesuffix("\n").removesuffix("\r")
                else:
                    body = " " * column + layout.item(new[j], column, flow=flow)
                inserted[place] = (
                    inserted.get(place, "") + body + layout.newline
                )
        for place, body in inserted.items():
            if place > 0 and layout.text[place - 1] != "\n":
                body = layout.newline + body.removesuffix(layout.newline)
            self._add(place, place, body)

    def _chunks(
        self, items: Sequence[Any], column: int
    ) -> list[tuple[int, int]]:
        """Returns where the lines of each item begin and end."""
        layout = self._layout
        result = []
        for item in items:
            dash = layout.dash(item, column)
            if dash is None or not layout.is_first(dash):
                raise UnknownPlaceError
            end = max(layout.end(item), dash + 1)
            if layout.has_rest(end):
                raise UnknownPlaceError
            start = layout.above(dash, column)
            result.append((start, layout.below(end, column)))
        return result

    def _write_flow(
        self,
        node: Any,
        parts: list[tuple[tuple[Any, Any], Any]],
        wanted: list[tuple[str | None, Any]],
        *,
        is_mapping: bool,
    ) -> None:
        """Writes what is in braces or brackets; parts that stay keep theirs."""
        layout = self._layout
        text = layout.text
        places = []
        for (key, value), _ in parts:
            first = key if key is not None else value
            places.append((layout.start(first), layout.end(value)))
        opening = text[layout.start(node) : places[0][0]]
        closing = text[places[-1][1] : layout.end(node)]
        bodies, last, result = set(range(len(parts))), None, ""
        for name, value in wanted:
            source = next(
                (
                    i
                    for i in sorted(bodies)
                    if same(parts[i][1], value)
                    and (not is_mapping or parts[i][0][0].value == name)
                ),
                None,
            )
            if source is None:
                body = scalar_text(value)
                if is_mapping:
                    body = f"{key_text(str(name))} {body}"
            else:
                bodies.discard(source)
                body = text[slice(*places[source])]
            if result:
                gap = ", "
                if source is not None and last == source - 1:
                    gap = text[places[last][1] : places[source][0]]
                result += gap
            result += body
            last = source
        self._add(
            layout.start(node), layout.end(node), opening + result + closing
        )


def _is_flow(node: Any) -> bool:
    return isinstance(node, yaml.CollectionNode) and bool(node.flow_style)


def _mark_flow(parent: Any, node: Any) -> None:
    """Lets a node know whether it stands in braces or brackets."""
    node.in_flow = bool(parent.flow_style) or getattr(parent, "in_flow", False)


def _matched(old: list[Any], new: list[Any]) -> list[tuple[str, int, int]]:
    """Returns the moves from one list to another: (tag, from, to).

    Items with the tag "same" stay in place, and may differ inside.
    """
    count = len(old)
    head = 0
    while head < min(count, len(new)) and same(old[head], new[head]):
        head += 1
    tail = 0
    while tail < min(count, len(new)) - head and same(
        old[count - 1 - tail], new[len(new) - 1 - tail]
    ):
        tail += 1
    moves = [("same", i, i) for i in range(head)]
    i_end, j_end = count - tail, len(new) - tail
    moves += _matched_middle(old, new, range(head, i_end), range(head, j_end))
    moves += [("same", i_end + k, j_end + k) for k in range(tail)]
    return moves


def _matched_middle(
    old: list[Any], new: list[Any], these: range, those: range
) -> list[tuple[str, int, int]]:
    keys = [_key(old[i]) for i in these], [_key(new[j]) for j in those]
    blocks: list[tuple[str, int, int, int, int]]
    if max(len(these), len(those)) > _MAX_MATCHED or not (
        set(keys[0]) & set(keys[1])
    ):
        blocks = [("replace", 0, len(these), 0, len(those))]
    else:
        blocks = list(
            difflib.SequenceMatcher(
                None, keys[0], keys[1], autojunk=False
            ).get_opcodes()
        )
    moves = []
    for _, i0, i1, j0, j1 in blocks:
        both = min(i1 - i0, j1 - j0)
        moves += [("same", these[i0 + k], those[j0 + k]) for k in range(both)]
        moves += [("remove", these[i], -1) for i in range(i0 + both, i1)]
        moves += [("insert", -1, those[j]) for j in range(j0 + both, j1)]
    return moves


def _key(item: Any) -> Any:
    is_scalar = not isinstance(item, dict | list)
    return (type(item), repr(item)) if is_scalar else id(item)
