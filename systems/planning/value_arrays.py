"""Conversion of immutable values to arrays for files, and back.

Values are None, booleans, numbers, texts, NumPy arrays, and tuples,
NamedTuples, members of an Enum and frozen dataclasses of such values. No code
of a file runs: a class is looked up among the loaded ones, and an object is
filled without its constructor.
"""

import dataclasses
from enum import Enum
import json
import sys
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

Arrays = dict[str, NDArray[Any]]

_FORM = "value"


def to_arrays(value: Any, what: str) -> Arrays:
    """Returns arrays from which a value can be restored.

    Raises:
        ValueError: If it holds anything else than the module lists, or a class
            that is not at the top level of a module. The message begins with
            `what`, a name of the value.
    """
    arrays: Arrays = {}
    form = _form(value, arrays, what)
    return {_FORM: np.array(json.dumps(form)), **arrays}


def from_arrays(arrays: Arrays) -> Any:
    """Returns the value that `to_arrays` turned into arrays.

    Raises:
        ValueError: If they hold no value, or one of a class that is not loaded.
    """
    try:
        return _value(json.loads(str(arrays[_FORM])), arrays)
    except (LookupError, TypeError, AttributeError, RecursionError) as error:
        raise ValueError(f"holds no value: {error!r}") from error


def _form(value: Any, arrays: Arrays, what: str) -> Any:
    """Returns a value as JSON; its arrays are added to `arrays`."""
    cls = type(value)
    if value is None or cls in (bool, int, float, str):
        return value
    if isinstance(value, np.ndarray | np.generic) and not value.dtype.hasobject:
        name = f"array_{len(arrays)}"
        arrays[name] = np.asarray(value)
        return {"array": name, "scalar": isinstance(value, np.generic)}
    if cls is tuple:
        return {"tuple": [_form(item, arrays, what) for item in value]}
    kind = f"{cls.__module__}:{cls.__qualname__}"
    if _is_value_class(cls) and _find(kind) is cls:
        if isinstance(value, Enum):
            return {"class": kind, "name": value.name}
        items = {
            name: _form(getattr(value, name), arrays, what)
            for name in _names(cls)
        }
        return {"class": kind, "items": items}
    raise ValueError(
        f"{what} holds {value!r:.80} of {cls.__module__}.{cls.__qualname__},"
        " which cannot be saved: use None, numbers, texts, arrays, and tuples,"
        " NamedTuples or frozen dataclasses of such, of classes at the top"
        " level of a module"
    )


def _value(form: Any, arrays: Arrays) -> Any:
    if not isinstance(form, dict):
        return form
    if "array" in form:
        array = arrays[form["array"]]
        if form["scalar"]:
            return array[()]
        array.setflags(write=False)
        return array
    if "tuple" in form:
        return tuple(_value(item, arrays) for item in form["tuple"])
    cls = _find(form["class"])
    if cls is None or not _is_value_class(cls):
        raise ValueError(f"there is no class {form['class']}; import it first")
    if issubclass(cls, Enum):
        return cls[form["name"]]
    items = {key: _value(item, arrays) for key, item in form["items"].items()}
    if list(items) != list(_names(cls)):
        raise ValueError(f"{form['class']} has other fields now")
    hints = _hints(cls)
    for key, item in items.items():
        if not _fits(item, hints.get(key, Any)):
            raise ValueError(
                f"{form['class']}: {key} must be of type {hints[key]},"
                f" got {item!r:.80}"
            )
    if issubclass(cls, tuple):
        return tuple.__new__(cls, items.values())
    value = object.__new__(cls)
    for key, item in items.items():
        object.__setattr__(value, key, item)
    return value


def _is_value_class(cls: type[Any]) -> bool:
    if issubclass(cls, tuple):
        return hasattr(cls, "_fields")
    # There is no public way to ask whether a dataclass is frozen.
    is_frozen = dataclasses.is_dataclass(cls) and (
        cls.__dataclass_params__.frozen  # type: ignore[attr-defined]
    )
    return is_frozen or issubclass(cls, Enum)


def _names(cls: type[Any]) -> tuple[str, ...]:
    if issubclass(cls, tuple):
        # (A NamedTuple has them; `_is_value_class` has checked this.)
        names: tuple[str, ...] = cls._fields  # type: ignore[attr-defined]
        return names
    return tuple(field.name for field in dataclasses.fields(cls))


def _hints(cls: type[Any]) -> dict[str, Any]:
    """Returns the types of fields; empty if some cannot be looked up."""
    try:
        return get_type_hints(cls)
    except (NameError, TypeError):
        return {}


# The types that a numeric field accepts.
_LIKE: dict[Any, Any] = {
    bool: (bool, np.bool_),
    int: (int, np.integer),
    float: (float, int, np.floating, np.integer),
}


def _fits(value: Any, hint: Any) -> bool:
    """Returns whether a value has the type of a field."""
    origin, parts = get_origin(hint) or hint, get_args(hint)
    if origin in (Union, UnionType):
        return any(_fits(value, part) for part in parts)
    if origin is tuple and parts and isinstance(value, tuple):
        if parts[-1] is ...:
            parts = parts[:1] * len(value)
        pairs = zip(value, parts, strict=False)
        return len(value) == len(parts) and all(_fits(*it) for it in pairs)
    if origin is None:
        return value is None
    if origin in (np.ndarray, NDArray) and parts:
        # (The type arguments of an array depend on the version of NumPy.)
        numbers = get_args(parts[-1]) or parts[-1:]
        is_told = isinstance(numbers[0], type)
        return isinstance(value, np.ndarray) and (
            not is_told or np.issubdtype(value.dtype, numbers[0])
        )
    kinds = _LIKE.get(origin, origin)
    return (
        origin is Any
        or not isinstance(origin, type)
        or isinstance(value, kinds)
    )


def _find(kind: str) -> type[Any] | None:
    """Returns a loaded class by its module and name."""
    module, _, name = kind.partition(":")
    found = getattr(sys.modules.get(module), name, None)
    return found if isinstance(found, type) else None
