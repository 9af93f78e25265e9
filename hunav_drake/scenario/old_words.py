"""Old keys of scenario files: reading them with a warning, renaming them."""

from collections import Counter
from collections.abc import Iterator
from typing import Any
import warnings

from hunav_drake.scenario.building import (
    document_faults,
    hint_at,
    inner_hint,
    kind_of,
)
from hunav_drake.scenario.error import Fault, Loc, ScenarioError, path_text
from hunav_drake.scenario.schema import Scenario
from hunav_drake.scenario.yaml_document import YamlDocument
from hunav_drake.scenario.yaml_source import parse_yaml
from hunav_drake.systems.common.old_words import OLD_TAGS, TAG, old_tag


def find_old_words(data: Any, hint: Any = Scenario) -> Iterator[Loc]:
    """Yields the paths of old words in plain data.

    The data should be of the type `hint`, but need not fit it.
    """
    if kind := kind_of(hint):
        if old := old_tag(kind, data):
            yield (old,)
        return
    steps = range(len(data)) if isinstance(data, list) else data
    for step in steps if isinstance(data, list | dict) else ():
        inner = inner_hint(hint, step)
        if inner is not None and isinstance(data[step], list | dict):
            for loc in find_old_words(data[step], inner):
                yield (step, *loc)


def renew(
    document: YamlDocument, prefix: Loc = (), hint: Any = Scenario
) -> None:
    """Replaces old words by new ones, with a warning.

    Args:
        document: The document, changed except for `composed`.
        prefix: The path of the part to change.
        hint: The type that this part should have.
    """
    data = document.plain(prefix)
    locs = [(*prefix, *loc) for loc in find_old_words(data, hint)]
    if not locs:
        return
    first, others = locs[0], len(locs) - 1
    path = path_text(document.plain(), first)
    message = f"is now {TAG!r}"
    if others:
        message += f", and so are {others} other old words"
    message += "; `hunav check --fix FILE` writes the new ones"
    _warn(Fault(document.name, document.line(first), path, message))
    for loc in locs:
        _rename(document, loc)


def renew_override(loc: Loc, value: Any, text: str) -> Loc:
    """Returns the path of an override, with a warning if it has old words.

    Args:
        loc: The given path.
        value: The given value as plain data, changed.
        text: The text of the override.
    """
    hint = hint_at(loc)
    old = [(*loc, *it) for it in find_old_words(value, hint)]
    for *outer, word in old:
        holder = value
        for step in outer[len(loc) :]:
            holder = holder[step]
        _put_tag(holder, str(word))
    if OLD_TAGS.get(kind_of(hint_at(loc[:-1])), "") == loc[-1]:
        old.append(loc)
        loc = (*loc[:-1], TAG)
    for it in old[:1]:
        message = f"is now {TAG!r}; write {path_text(None, (*it[:-1], TAG))}"
        _warn(Fault(f"--set {text:.60}", 0, path_text(None, it), message))
    return loc


def renewed_text(content: bytes, name: str) -> tuple[bytes, Counter[str]]:
    """Returns the text of one or several scenarios with the new words.

    Args:
        content: The text in UTF-8.
        name: The name of the text in messages.

    Returns:
        The text, otherwise unchanged; and the number of each old word in it.

    Raises:
        ScenarioError: If the text is not YAML, or if an anchor keeps a word
            from being replaced.
    """
    document = parse_yaml(content, name=name)
    if document.findings:
        raise ScenarioError(name, document_faults(document))
    text = content.decode("utf-8-sig")
    mark = content[: len(content) - len(text.encode())]
    data = document.plain()
    locs = list(find_old_words(data))
    if isinstance(data, dict):
        for key in data:
            if hint_at((key,)) is None:
                locs += ((key, *loc) for loc in find_old_words(data[key]))
    nodes = {id(it): it for loc in locs if (it := _key(document, loc))}
    for node in sorted(
        nodes.values(), key=lambda it: it.start_mark.index, reverse=True
    ):
        start, end = node.start_mark.index, node.end_mark.index
        text = text[:start] + TAG + text[end:]
    for loc in locs:
        _rename(document, loc)
    # (Compared as texts, because NaN is not equal to itself.)
    if repr(parse_yaml(text, name=name).plain()) != repr(document.plain()):
        first = locs[0]
        message = f"is now {TAG!r}; write it yourself, for there are anchors"
        place = name, document.line(first), path_text(data, first), message
        raise ScenarioError(name, [Fault(*place)])
    return mark + text.encode(), Counter(str(loc[-1]) for loc in locs)


def _warn(fault: Fault) -> None:
    warnings.warn(str(fault), FutureWarning, stacklevel=5)


def _rename(document: YamlDocument, loc: Loc) -> None:
    node = document.find(loc[:-1])
    if node is not None:
        _put_tag(node.value, str(loc[-1]))


def _put_tag(holder: dict[str, Any], old: str) -> None:
    """Renames a key, which keeps its position."""
    entries = {TAG if key == old else key: it for key, it in holder.items()}
    holder.clear()
    holder.update(entries)


def _key(document: YamlDocument, loc: Loc) -> Any:
    """Returns the node of a key in the text; None within an anchor."""
    node, key = document.composed, None
    for step in loc:
        value = getattr(node, "value", None)
        if not isinstance(value, list):
            return None
        if isinstance(step, int):
            node = value[step]
            continue
        pairs = (it for it in value if it[0].value == step)
        key, node = next(pairs, (None, None))
    return key
