"""Registers of parts that are chosen by name, with parameters."""

from collections.abc import Callable, Iterator, Mapping
import dataclasses
import importlib
from typing import Any

from pydantic import TypeAdapter, ValidationError

from hunav_drake.systems.common.suggest import did_you_mean


class Registry(Mapping[str, type[Any]]):
    """Parts by name; each is the dataclass of its parameters.

    Their values are checked by pydantic, also where the dataclass is a plain
    one.
    """

    def __init__(
        self, kind: str, needs: tuple[str, ...], home: str = ""
    ) -> None:
        """Constructs a Registry that is empty.

        Args:
            kind: What the parts are called in messages.
            needs: The attributes that every part must have.
            home: The module that registers the parts of the package. It is
                loaded before one from elsewhere is registered, so that none
                takes a name of theirs.
        """
        self._kind = kind
        self._needs = needs
        self._home = home
        self._parts: dict[str, type[Any]] = {}

    def __repr__(self) -> str:
        return f"<{self._kind}s: {', '.join(sorted(self._parts))}>"

    def __getitem__(self, name: str) -> type[Any]:
        return self._parts[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._parts)

    def __len__(self) -> int:
        return len(self._parts)

    def register[T](self, name: str) -> Callable[[type[T]], type[T]]:
        """Returns a decorator that makes a part known by a name.

        A part replaces one that was defined in the same place, as when a cell
        of a notebook is run again.

        Raises:
            ValueError: If the name is taken.
            TypeError: If the part is no class, or lacks something.
        """
        if not isinstance(name, str) or not name:
            raise ValueError(
                f"the name of a {self._kind} is a text, got {name!r:.80}"
            )

        def add(part: type[T]) -> type[T]:
            if not (isinstance(part, type) and dataclasses.is_dataclass(part)):
                raise TypeError(
                    f"a {self._kind} is a dataclass, whose fields are its"
                    f" parameters; got {part!r}"
                )
            missing = [need for need in self._needs if not hasattr(part, need)]
            if missing:
                raise TypeError(
                    f"{part.__qualname__} is no {self._kind}: it lacks"
                    f" {', '.join(missing)}"
                )
            if self._home and not part.__module__.startswith("hunav_drake."):
                importlib.import_module(self._home)
            old = self._parts.get(name)
            if old is not None and _origin(old) != _origin(part):
                raise ValueError(
                    f"a {self._kind} named {name!r} is registered already, from"
                    f" {'.'.join(_origin(old))}; choose another name"
                )
            self._parts[name] = part
            return part

        return add

    def make(self, name: str, parameters: Mapping[str, Any]) -> Any:
        """Returns the part of a name, with some of its parameters set.

        Raises:
            ValueError: If there is no such part or parameter, or if a value
                is outside its range.
        """
        if not isinstance(name, str) or name not in self._parts:
            hint = did_you_mean(str(name), self._parts)
            known = ", ".join(sorted(self._parts))
            raise ValueError(
                f"no {self._kind} {name!r}{hint} (there are: {known})"
            )
        part = self._parts[name]
        whole = f"{self._kind} {name!r}"
        accepted = [field.name for field in dataclasses.fields(part)]
        for key in parameters:
            if key not in accepted:
                raise ValueError(
                    f"{whole} has no parameter {key!r}"
                    f"{did_you_mean(key, accepted)}"
                    f" (there are: {', '.join(sorted(accepted)) or 'none'})"
                )
        try:
            return TypeAdapter(part).validate_python(dict(parameters))
        except ValidationError as error:
            first = error.errors()[0]
            loc = ".".join(map(str, first["loc"]))
            message = first["msg"].removeprefix("Value error, ")
            if ", got " not in message:
                message += f", got {first['input']!r}"
            raise ValueError(f"{whole}: {loc}: {message}") from error


def _origin(part: type[Any]) -> tuple[str, str]:
    return part.__module__, part.__qualname__
