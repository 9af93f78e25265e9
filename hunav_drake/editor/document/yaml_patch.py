"""Changes the text of a scenario only where its data changed."""

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
    """The change of a text.

    Attributes:
        patches: The patches of the text.
        text: The new text.
        document: The parsed new text.
        rewritten: The part that was rewritten as a whole, for example because
            it has anchors; None if only changed values were written.
    """

    patches: Patches
    text: str
    document: YamlDocument
    rewritten: Loc | None


def patch_yaml(
    text: str, document: YamlDocument, before: Any, after: Any, prefix: Loc = ()
) -> YamlPatch:
    """Returns the patch that changes the data of a text.

    Unchanged parts keep their comments and spaces. The new text is parsed and
    compared; if it differs, the smallest part around the change is rewritten,
    and in the worst case the whole text.

    Args:
        text: The text.
        document: The parsed text.
        before: The data at the prefix.
        after: The new data; parts that they share with `before` are unchanged.
        prefix: The path of the data in the document.

    Raises:
        ValueError: If the data cannot be written as YAML.
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
    """Yields depths to compare to, and the part that is then rewritten."""
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
    """Returns the deepest parts that differ."""
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
