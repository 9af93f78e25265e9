"""The keys that named a choice before `type`: read for one version more."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any
import warnings

# The key that names a choice.
TAG = "type"

# The old names of that key, by kind of choice.
OLD_TAGS: Mapping[str, str] = MappingProxyType(
    {
        "planner": "name",
        "motion model": "name",
        "robot": "model",
        "wall shape": "shape",
        "kind of furniture": "kind",
        "behavior": "tree",
    }
)


def old_tag(kind: str, data: Any) -> str | None:
    """Returns the old key by which data name a choice; None if by none."""
    old = OLD_TAGS.get(kind)
    if not isinstance(data, Mapping) or TAG in data or old not in data:
        return None
    return old


def with_tag(kind: str, data: Any) -> Any:
    """Returns data of a choice with the new key; warns if it had the old."""
    old = old_tag(kind, data)
    if old is None:
        return data
    text = f"the key {old!r} of a {kind} is now {TAG!r}"
    warnings.warn(text, FutureWarning, stacklevel=3)
    return {TAG if key == old else key: it for key, it in data.items()}


def twice(kind: str, data: Mapping[Any, Any]) -> str:
    """Returns the fault of an old key beside the new one; empty if none."""
    old = OLD_TAGS.get(kind)
    if old not in data or TAG not in data:
        return ""
    return f"is the old word for {TAG}, which is given, too; remove {old}"
