"""Limits what scenarios may load: modules of choices, or only their names."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
import dataclasses
import functools
import sys
from typing import Any, TypedDict, get_type_hints

from pydantic import TypeAdapter

_registered_only = ContextVar("_registered_only", default=False)
_not_loaded: ContextVar[tuple[Any, ...]] = ContextVar("_not_loaded", default=())


@contextmanager
def registered_only(*not_loaded: Any) -> Iterator[None]:
    """Lets scenarios choose only registered classes; no module is run for them.

    The own modules of registers that are `not_loaded` are not loaded, either.
    Their choices are checked only for common fields: see `UnloadedChoice`.
    """
    tokens = _registered_only.set(True), _not_loaded.set(not_loaded)
    try:
        yield
    finally:
        _registered_only.reset(tokens[0])
        _not_loaded.reset(tokens[1])


def may_import(module: str) -> bool:
    """Returns whether a choice may be named by its place in a module."""
    return module in sys.modules or not _registered_only.get()


def is_loaded(registry: Any) -> bool:
    """Returns whether the choices of a register may be loaded."""
    return not any(registry is other for other in _not_loaded.get())


class UnloadedChoice:
    """Stands for a choice whose class is not loaded: see `registered_only`.

    Its attributes are the fields that all choices of its kind have.
    """

    def __init__(self, base: Any, data: Mapping[str, Any]) -> None:
        """Constructs it from data, of which it checks the common fields."""
        defaults, adapter = _common(base)
        self.__dict__.update(defaults)
        self.__dict__.update(adapter.validate_python(dict(data)))
        self._data = {**defaults, **data}

    def __eq__(self, other: object) -> bool:
        """Returns whether another one has equal data."""
        if not isinstance(other, UnloadedChoice):
            return NotImplemented
        return self._data == other._data

    # It has no hash: its data may hold lists.
    __hash__ = None  # type: ignore[assignment]

    def as_data(self) -> dict[str, Any]:
        """Returns its fields, with the defaults of those that all have."""
        return dict(self._data)


@functools.cache
def _common(base: Any) -> tuple[dict[str, Any], TypeAdapter[Any]]:
    """Returns the fields of a base class: their defaults and their rules."""
    hints = get_type_hints(base, include_extras=True)
    own = dataclasses.fields(base) if dataclasses.is_dataclass(base) else ()
    fields = {it.name: hints[it.name] for it in own}
    # (mypy knows only fields that are written out.)
    kind: Any = TypedDict("kind", fields, total=False)  # type: ignore[misc]
    return {it.name: _default(it) for it in own}, TypeAdapter(kind)


def _default(field: dataclasses.Field[Any]) -> Any:
    """Returns the default of a field."""
    if field.default_factory is dataclasses.MISSING:
        return field.default
    return field.default_factory()
