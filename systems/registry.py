"""Registers of parts that are chosen by name, with parameters."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from hunav_drake.systems.suggest import did_you_mean


class Registry(Mapping[str, type[Any]]):
    """Parts by name; each is the pydantic dataclass of its parameters."""

    def __init__(self, kind: str) -> None:
        """Constructs a Registry that is empty.

        Args:
            kind: What the parts are called in messages.
        """
        self._kind = kind
        self._parts: dict[str, type[Any]] = {}

    def __getitem__(self, name: str) -> type[Any]:
        return self._parts[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._parts)

    def __len__(self) -> int:
        return len(self._parts)

    def register[T](self, name: str) -> Callable[[type[T]], type[T]]:
        """Returns a decorator that makes a part known by a name.

        Raises:
            ValueError: If the name is taken.
        """

        def add(part: type[T]) -> type[T]:
            if name in self._parts:
                raise ValueError(
                    f"a {self._kind} named {name!r} is registered already"
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
        if name not in self._parts:
            hint = did_you_mean(name, self._parts)
            known = ", ".join(sorted(self._parts))
            raise ValueError(
                f"no {self._kind} {name!r}{hint} (there are: {known})"
            )
        return self._parts[name](**parameters)
