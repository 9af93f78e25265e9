"""Texts for messages: values, numbers of things, suggestions of words."""

from collections.abc import Iterable, Sequence
import difflib
import functools
from typing import Any

# A part of a valid word counts if it has more letters, and is this similar.
_LEAST_PART, _PART = 3, 0.8

# The largest number of valid words that are shown.
_MOST_SHOWN = 24


def nearest(word: str, valid: Iterable[str], cutoff: float = 0.6) -> str | None:
    """Returns the valid word nearest to a word, if one is near.

    Case is ignored. If no word is near, a word with a similar part is: `jerk`
    is near to `avg_robot_jerk`. The cutoff, from 0 to 1, is the least
    similarity of whole words.
    """
    # Valid words are short; comparing with a long one would take time.
    return _nearest(word[:64].lower(), tuple(valid), cutoff)


@functools.lru_cache(maxsize=1024)
def _nearest(word: str, valid: tuple[str, ...], cutoff: float) -> str | None:
    by_lower = {name.lower(): name for name in valid}
    near = difflib.get_close_matches(word, by_lower, n=1, cutoff=cutoff)
    if near:
        return by_lower[near[0]]
    by_part = {
        part: name
        for name in reversed(valid)
        for part in name.lower().split("_")
        if len(part) > _LEAST_PART
    }
    near = difflib.get_close_matches(word, by_part, n=1, cutoff=_PART)
    return by_part[near[0]] if near else None


def did_you_mean(word: str, valid: Iterable[str]) -> str:
    """Returns "; did you mean ...?", or nothing if no valid word is near."""
    near = nearest(word, valid)
    return f"; did you mean {near!r}?" if near else ""


def shown(value: Any) -> str:
    """Returns a value as a message shows it, in at most 60 characters."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}"
    if isinstance(value, str):
        return repr(value if len(value) <= 40 else value[:37] + "...")
    if isinstance(value, int) and abs(value) >= 10**40:
        return "a number of more than 40 digits"
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def counted(number: int, one: str, more: str = "") -> str:
    """Returns a number with its noun, as "1 run" or "2 runs"."""
    return f"{number} {one if number == 1 else more or one + 's'}"


def suggestion(word: str, valid: Sequence[str]) -> str:
    """Returns the nearest valid word, or all of them, for a message.

    If there are many, it lists the first ones.
    """
    if near := nearest(word, valid):
        return f"did you mean {shown(near)}?"
    if not valid:
        return "there are none"
    more = len(valid) - _MOST_SHOWN
    names = [*sorted(valid)[:_MOST_SHOWN], *([f"and {more} more"] * (more > 0))]
    return "valid: " + ", ".join(names)


def listed(words: Sequence[str], most: int = 8) -> str:
    """Returns words as a list, "a, b and c"; of many, the first of them."""
    if len(words) > most:
        words = [*words[: most - 1], f"{len(words) - most + 1} more"]
    *first, last = words or [""]
    return f"{', '.join(first)} and {last}" if first else last
