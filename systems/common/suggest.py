"""Suggestions for misspelt words."""

from collections.abc import Iterable
import difflib
import functools


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
