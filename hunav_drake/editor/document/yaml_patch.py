"""Changes the text of a scenario where its data changed, and nowhere else."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from hunav_drake.editor.document.plain_data import get, same
from hunav_drake.editor.document.text_patch import Patch, Patches, patched
from hunav_drake.editor.document.yaml_layout import Layout
from hunav_drake.editor.document.yaml_writer import (
    UnknownPlaceError,
    YamlWriter,
)
from hunav_drake.scenario.error import Loc
from hunav_drake.scenario.writer import yaml_text
from hunav_drake.scenario.yaml_document import YamlDocument
from hunav_drake.scenario.yaml_source import parse_yaml


class YamlPatch(NamedTuple):
    """What a change of data does to its text.

    Attributes:
        patches: The patches of the text.
        text: The text after them.
        document: What the text reads as.
        rewritten: The part that had to be written anew as a whole, for it has
            anchors, say; None if only what changed was written.
    """

    patches: Patches
    text: str
    document: YamlDocument
    rewritten: Loc | None


def patch_yaml(
    text: str, document: YamlDocument, before: Any, after: Any, prefix: Loc = ()
) -> YamlPatch:
    """Returns what makes a text say other data.

    What is as before stays, with its comments and spaces. The result is read
    again and compared; where it differs, the smallest part around is written
    anew, and at worst the whole.

    Args:
        text: The text.
        document: What it reads as.
        before: The part of that at the prefix, as plain data.
        after: The plain data that it shall read as; parts of them that are
            those of `before` are not looked at.
        prefix: Where in the document they are.

    Raises:
        ValueError: If no text can say them.
    """
    whole = before if not prefix else _put(document.plain(), prefix, before)
    wanted = after if not prefix else _put(whole, prefix, after)
    if document.root is not None:
        for depth, part in _attempts(whole, wanted):
            writer = YamlWriter(Layout(text, document.composed), depth)
            try:
                writer.write(document.composed, whole, wanted, ())
            except UnknownPlaceError:
                continue
            found = _read_back(text, writer.patches(), wanted)
            if found is not None:
                return YamlPatch(*found, part)
    new = yaml_text(wanted, indented=True)
    patches: Patches = (Patch(0, text, new),)
    if document.root is None and text.strip():
        new = text.rstrip("\n") + "\n" + new
        patches = (Patch(0, text, new),)
    found = _read_back(text, patches, wanted)
    if found is None:
        raise ValueError("these data cannot be written as YAML")
    return YamlPatch(*found, () if document.root is not None else None)


def _attempts(old: Any, new: Any) -> Iterator[tuple[int | None, Loc | None]]:
    """Yields how deep to look, and what is written anew as a whole then."""
    yield None, None
    changed = _changed_locs(old, new, ())
    deepest = max(changed, key=len, default=())
    for depth in range(len(deepest) - 1, -1, -1):
        yield depth, deepest[:depth]


def _put(whole: Any, prefix: Loc, part: Any) -> Any:
    step = prefix[0]
    inner = (
        _put(get(whole, prefix[:1]), prefix[1:], part) if prefix[1:] else part
    )
    return {**whole, step: inner}


def _read_back(
    text: str, patches: Patches, wanted: Any
) -> tuple[Patches, str, YamlDocument] | None:
    try:
        new = patched(text, patches)
    except ValueError:
        return None
    document = parse_yaml(new, name="data")
    if document.root is None or not same(document.plain(), wanted):
        return None
    return patches, new, document


def _changed_locs(old: Any, new: Any, loc: Loc) -> list[Loc]:
    """Returns the deepest parts that differ; lists of other lengths count."""
    if same(old, new):
        return []
    found: list[Loc] = []
    if isinstance(old, dict) and isinstance(new, dict):
        for key in old.keys() & new.keys():
            found += _changed_locs(old[key], new[key], (*loc, key))
        found += [(*loc, key) for key in old.keys() ^ new.keys()]
        return found
    if isinstance(old, list) and isinstance(new, list):
        if len(old) == len(new):
            for i, (one, other) in enumerate(zip(old, new, strict=True)):
                found += _changed_locs(one, other, (*loc, i))
            return found
        return [(*loc, 0)]
    return [loc]
