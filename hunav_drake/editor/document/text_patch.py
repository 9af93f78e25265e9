"""Patches of text, and their inverses."""

from collections.abc import Iterable
from typing import NamedTuple


class Patch(NamedTuple):
    """A replacement of a part of a text.

    Attributes:
        start: The index of its first character in the old text.
        old: The old part.
        new: The new part.
    """

    start: int
    old: str
    new: str


# Patches of one text, in order, without overlaps.
Patches = tuple[Patch, ...]


def patched(text: str, patches: Iterable[Patch]) -> str:
    """Returns a text after some patches, which are in order.

    Raises:
        ValueError: If they do not fit the text.
    """
    parts, done = [], 0
    for start, old, new in patches:
        if start < done or text[start : start + len(old)] != old:
            raise ValueError("the patches are not those of this text")
        parts += [text[done:start], new]
        done = start + len(old)
    return "".join([*parts, text[done:]])


def inverse(patches: Patches) -> Patches:
    """Returns the patches that undo some."""
    result, shift = [], 0
    for start, old, new in patches:
        result.append(Patch(start + shift, new, old))
        shift += len(new) - len(old)
    return tuple(result)


def difference(old: str, new: str) -> Patches:
    """Returns the patch from an old to a new text; () if they are equal."""
    if old == new:
        return ()
    most = min(len(old), len(new))
    head = _common(old, new, most)
    tail = _common(old[::-1], new[::-1], most - head)
    end = len(old) - tail
    return (Patch(head, old[head:end], new[head : len(new) - tail]),)


def _common(one: str, other: str, most: int) -> int:
    """Returns the length of the common prefix of two texts."""
    low, high = 0, most
    while low < high:
        middle = (low + high + 1) // 2
        if one[low:middle] == other[low:middle]:
            low = middle
        else:
            high = middle - 1
    return low
