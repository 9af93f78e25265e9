"""Words for messages: what somebody wrote, and what may have been meant."""

from collections.abc import Iterable, Sequence
import difflib
import functools
from typing import Any


def nearest(word: str, valid: Iterable[str], cutoff: float = 0.6) -> str | None:
    """Returns the valid word nearest to a word, if one is near.

    Case does not matter. The cutoff, from 0 to 1, is how alike they must be.
    """
    # No valid word is long; comparing with a long one would take its time.
    return _nearest(word[:64].lower(), tuple(valid), cutoff)


@functools.lru_cache(maxsize=1024)
def _nearest(word: str, valid: tuple[str, ...], cutoff: float) -> str | None:
    by_lower = {name.lower(): name for name in valid}
    near = difflib.get_close_matches(word, by_lower, n=1, cutoff=cutoff)
    return by_lower[near[0]] if near else None


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


def suggestion(word: str, valid: Sequence[str]) -> str:
    """Returns the nearest valid word, or all of them, for a message."""
    if near := nearest(word, valid):
        return f"did you mean {shown(near)}?"
    return "valid: " + ", ".join(sorted(valid)) if valid else "there are none"
