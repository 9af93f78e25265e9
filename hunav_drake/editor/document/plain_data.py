"""Operations on immutable plain data: lists, mappings and scalars.

Unchanged parts are shared, so identity shows whether a part has changed.
"""

from collections.abc import Iterator, Sequence
import math
from typing import Any

from hunav_drake.scenario.building import hint_at, kind_of
from hunav_drake.scenario.error import Loc, path_text, shown
from hunav_drake.scenario.yaml_source import MAX_DEPTH, MAX_NODES
from hunav_drake.systems.common.old_words import TAG

# A change of data: the path of a part, and its new value.
Change = tuple[Loc, Any]

# With more changes, views get all data.
_MAX_CHANGES = 500

# The longest text of a scalar or a key.
_MAX_TEXT = 2**20


class OperationError(ValueError):
    """An operation does not fit the data; the text says why."""


def apply(data: Any, operations: Sequence[Sequence[Any]]) -> Any:
    """Returns data after some operations; unchanged parts are shared.

    Args:
        data: Plain data, which are not changed.
        operations: ``("set", path, value)``, ``("insert", path, value)``,
            whose path ends with an index, or ``("remove", path)``. Missing
            mappings on the path, and a missing list to insert into, are
            created.

    Raises:
        OperationError: If one does not fit the data.
    """
    for kind, path, *value in operations:
        data = _changed(data, kind, tuple(path), (), *value)
    if size_of(data) > MAX_NODES:
        raise OperationError(f"a scenario has at most {MAX_NODES} parts")
    return data


def check_plain(value: Any, depth: int = 0) -> None:
    """Checks that a value is plain data that YAML can represent.

    Raises:
        OperationError: If it is not.
    """
    if depth > MAX_DEPTH:
        raise OperationError(f"is nested deeper than {MAX_DEPTH} levels")
    if isinstance(value, str):
        _check_text(value)
    elif isinstance(value, dict):
        for key, item in value.items():
            if not isinstance(key, str):
                raise OperationError(f"a key must be text, got {shown(key)}")
            _check_text(key)
            check_plain(item, depth + 1)
    elif isinstance(value, list):
        for item in value:
            check_plain(item, depth + 1)
    elif isinstance(value, int) and abs(value) >= 10**100:
        raise OperationError(f"{shown(value)} is too large for a scenario")
    elif value is not None and not isinstance(value, bool | int | float):
        raise OperationError(
            f"must be a number, text, flag, list or mapping, got"
            f" {type(value).__name__}"
        )


def _check_text(text: str) -> None:
    if len(text) > _MAX_TEXT:
        raise OperationError(f"a text has at most {_MAX_TEXT} characters")
    if any("\ud800" <= letter <= "\udfff" for letter in text):
        raise OperationError("a text must not have surrogate characters")


def same(one: Any, other: Any) -> bool:
    """Returns whether data are equal; 1, 1.0 and true are different."""
    if one is other:
        return True
    if type(one) is not type(other):
        return False
    if isinstance(one, dict):
        return (
            len(one) == len(other)
            and list(one) == list(other)
            and all(same(one[key], other[key]) for key in one)
        )
    if isinstance(one, list):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, float) and math.isnan(one):
        return math.isnan(other)
    return bool(one == other)


def shared(old: Any, new: Any) -> Any:
    """Returns new data that share equal parts with the old data."""
    if same(old, new):
        return old
    if isinstance(old, dict) and isinstance(new, dict):
        return {
            key: shared(old[key], item) if key in old else item
            for key, item in new.items()
        }
    if isinstance(old, list) and isinstance(new, list):
        if len(old) == len(new):
            return [shared(a, b) for a, b in zip(old, new, strict=True)]
        # An item was inserted or removed: the parts before and after stay.
        head = _common(old, new)
        most = min(len(old), len(new)) - head
        tail = min(_common(old[::-1], new[::-1]), most)
        middle = new[head : len(new) - tail]
        return [*old[:head], *middle, *old[len(old) - tail :]]
    return new


def _common(old: list[Any], new: list[Any]) -> int:
    count = 0
    for one, other in zip(old, new, strict=False):
        if not same(one, other):
            break
        count += 1
    return count


def changes(old: Any, new: Any) -> list[Change]:
    """Returns the changes from old to new data; shared parts are equal."""
    found: list[Change] = []
    for change in _changes(old, new, ()):
        found.append(change)
        if len(found) > _MAX_CHANGES:
            return [((), new)]
    return found


def _changes(old: Any, new: Any, loc: Loc) -> Iterator[Change]:
    if old is new:
        return
    if isinstance(old, dict) and isinstance(new, dict):
        if set(old) <= set(new):
            for key, item in new.items():
                if key not in old:
                    yield (*loc, key), item
                else:
                    yield from _changes(old[key], item, (*loc, key))
            return
    elif (
        isinstance(old, list) and isinstance(new, list) and len(old) == len(new)
    ):
        if not any(isinstance(item, list | dict) for item in new):
            if not same(old, new):
                yield loc, new
            return
        for i, item in enumerate(new):
            yield from _changes(old[i], item, (*loc, i))
        return
    if not same(old, new):
        yield loc, new


def size_of(data: Any) -> int:
    """Returns the number of parts of data, including the whole."""
    if isinstance(data, dict):
        return 1 + sum(map(size_of, data.values()))
    if isinstance(data, list):
        return 1 + sum(map(size_of, data))
    return 1


def jsonable(data: Any) -> Any:
    """Returns data with numbers that JSON does not have as text."""
    if isinstance(data, dict):
        return {key: jsonable(item) for key, item in data.items()}
    if isinstance(data, list | tuple):
        return [jsonable(item) for item in data]
    if isinstance(data, float) and not math.isfinite(data):
        return {math.inf: ".inf", -math.inf: "-.inf"}.get(data, ".nan")
    return data


def get(data: Any, path: Sequence[str | int], default: Any = None) -> Any:
    """Returns a part of data, or the default if there is none."""
    for step in path:
        is_key = isinstance(data, dict) and step in data
        is_index = isinstance(data, list) and step in range(len(data))
        if not is_key and not is_index:
            return default
        data = data[step]
    return data


def _changed(
    data: Any, kind: str, path: Loc, done: Loc, value: Any = None
) -> Any:
    """Returns the data at the path `done` after one operation."""
    if not path:
        if kind != "set":
            raise OperationError(f"cannot {kind} the whole scenario")
        return value
    step, rest = path[0], path[1:]
    place = path_text(None, done) or "the scenario"
    if isinstance(step, str):
        data = _as_mapping(data, done)
        if not isinstance(data, dict):
            raise OperationError(f"{place} is {shown(data)}, not a mapping")
        if rest or kind == "set":
            inner = _changed(data.get(step), kind, rest, (*done, step), value)
            return {**data, step: inner}
        if kind == "insert":
            raise OperationError("the path to insert at must end with an index")
        if step not in data:
            raise OperationError(f"{path_text(None, (*done, step))} is not set")
        return {key: item for key, item in data.items() if key != step}
    if data is None and kind == "insert" and not rest:
        data = []
    if not isinstance(data, list):
        raise OperationError(f"{place} is {shown(data)}, not a list")
    if not rest and kind == "insert":
        if not 0 <= step <= len(data):
            raise OperationError(f"{place} has {len(data)} members, from 0")
        return [*data[:step], value, *data[step:]]
    if not 0 <= step < len(data):
        raise OperationError(f"{place} has {len(data)} members, from 0")
    if not rest and kind == "remove":
        return [*data[:step], *data[step + 1 :]]
    inner = _changed(data[step], kind, rest, (*done, step), value)
    return [*data[:step], inner, *data[step + 1 :]]


def _as_mapping(data: Any, loc: Loc) -> Any:
    """Returns a mapping for missing data, or for the name of a choice."""
    if data is None:
        return {}
    if isinstance(data, str) and kind_of(hint_at(loc)):
        return {TAG: data}
    return data
