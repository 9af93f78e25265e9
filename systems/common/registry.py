"""Registers of choices: dataclasses distinguished by one key.

A planner, a motion model, a robot or the shape of a wall is a choice. Its
class is a dataclass of its parameters, known by a name. As data it is a
mapping: the key `type` names the class, and parameters stand beside it::

    planner: {type: pursuit, cruise_speed: 0.8}

The name alone stands for the choice with its defaults: ``planner: pursuit``.
A class that is not registered is named by its module: ``my_module:MyPlanner``.
"""

from collections.abc import Callable, Iterator, Mapping
import dataclasses
import functools
import importlib.util
import inspect
from typing import Annotated, Any

from pydantic import TypeAdapter, ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError, core_schema

from hunav_drake.systems.common.choice_loading import (
    UnloadedChoice,
    is_loaded,
    may_import,
)
from hunav_drake.systems.common.old_words import OLD_TAGS, TAG, twice, with_tag
from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.suggest import shown, suggestion


class Registry(Mapping[str, type[Any]]):
    """The choices of one kind, by name.

    As a part of an annotation, ``Annotated[Base, REGISTRY]``, it is the type
    of a field of a pydantic dataclass: the field takes a choice, its name, or
    a mapping with a `type`. Choices are looked up each time, so that users may
    add some later.
    """

    def __init__(
        self,
        kind: str,
        base: type[Any],
        *,
        default: str = "",
        home: str | Mapping[str, str] = "",
    ) -> None:
        """Constructs a Registry that is empty.

        Args:
            kind: The name of the choices in messages.
            base: The class that all choices derive from.
            default: The `type` of a mapping without one; by default, a mapping
                must have one.
            home: The module that registers the choices of the package, or that
                of each, by name, relative to the package of `base`; loaded when
                it is needed.
        """
        self.kind = kind
        self.default = default
        self._base = base
        base.__registry__ = self
        # By name, "" for all names.
        package = base.__module__.rpartition(".")[0]
        homes = {"": home} if isinstance(home, str) else home
        self._homes = {
            name: importlib.util.resolve_name(module, package)
            for name, module in homes.items()
            if module
        }
        self._choices: dict[str, type[Any]] = {}
        self._adapter: TypeAdapter[Any] = TypeAdapter(Annotated[Any, self])

    __hash__ = object.__hash__

    def __eq__(self, other: object) -> bool:
        return self is other

    def __repr__(self) -> str:
        names = sorted({*self._homes, *self._choices} - {""})
        return f"<{self.kind}s: {', '.join(names)}>"

    def __getitem__(self, name: str) -> type[Any]:
        self._load(name)
        return self._choices[name]

    def __iter__(self) -> Iterator[str]:
        # (In any order of loading, choices come in that of the package.)
        choices = self._loaded()
        return iter(
            {it: None for it in (*self._homes, *choices) if it in choices}
        )

    def __len__(self) -> int:
        return len(self._loaded())

    def register[T](self, name: str) -> Callable[[type[T]], type[T]]:
        """Returns a decorator that registers a choice by a name.

        A choice replaces one that was defined in the same place, as when a
        cell of a notebook is run again.

        Raises:
            ValueError: If the name, or the class, is registered already.
            TypeError: If it is not itself a dataclass, does not derive from
                the base class, lacks one of its methods, or sets another
                default of a parameter of its base without a type.
        """
        if not isinstance(name, str) or not name:
            raise ValueError(
                f"the name of a {self.kind} is a text, got {name!r:.80}"
            )

        def add(choice: type[T]) -> type[T]:
            self._check(choice)
            # Nobody may take a name of the package before it is loaded.
            at_home = choice.__module__.startswith("hunav_drake.")
            known = self._choices if at_home else self._loaded()
            old = known.get(name)
            if old is not None and _origin(old) != _origin(choice):
                raise ValueError(
                    f"a {self.kind} named {name!r} is registered already, from"
                    f" {'.'.join(_origin(old))}; choose another name"
                )
            if vars(choice).get("__choice__", name) != name:
                raise ValueError(
                    f"{choice.__qualname__} is registered already, as"
                    f" {name_of(choice)!r}; derive a class from it"
                )
            known_as: Any = plain_errors(choice)
            known_as.__choice__ = name
            self._choices[name] = choice
            return choice

        return add

    def make(self, data: Any = None) -> Any:
        """Returns the choice that data stand for.

        Args:
            data: A choice, its name, or a mapping with a `type`; None for
                the default.

        Raises:
            ValidationError: If there is no such choice or parameter, or if a
                value is outside its range. It is a ValueError.
        """
        return self._adapter.validate_python({} if data is None else data)

    def find(self, data: Any) -> type[Any] | None:
        """Returns the class that data choose; None if there is none."""
        if isinstance(data, Mapping):
            old = OLD_TAGS.get(self.kind)
            data = data.get(TAG, data.get(old, self.default))
        if isinstance(data, str):
            try:
                return self._named(data)
            except _NoChoiceError:
                return None
        return type(data) if known_name(data) else None

    def __get_pydantic_core_schema__(
        self, source: Any, handler: Any
    ) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self._validate)

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: Any
    ) -> dict[str, Any]:
        if not is_loaded(self):
            return {"x-deferred": True}
        names, forms = [], []
        # Places in modules are any.
        place = {"type": "string", "pattern": r"^[^:]+:[^:]+$"}
        for name in sorted(self):
            if ":" in name:
                continue
            choice: Any = self[name]
            form = handler(_adapter(choice).core_schema)
            whole = handler.resolve_ref_schema(form)
            whole["properties"] = {
                TAG: {"const": name},
                **whole.get("properties", {}),
            }
            whole["additionalProperties"] = False
            if not whole.get("required"):
                names.append(name)
            if name != self.default:
                whole["required"] = [TAG, *whole.get("required", [])]
            forms.append(form)
        bare = [{"enum": names}] if names else []
        placed = {
            "type": "object",
            "properties": {TAG: place},
            "required": [TAG],
        }
        return {"oneOf": [*bare, *forms, place, placed]}

    def _loaded(self) -> dict[str, type[Any]]:
        for name in self._homes:
            self._load(name)
        return self._choices

    def _load(self, name: str) -> None:
        """Loads the module of a choice of the package."""
        module = self._homes.get(name, self._homes.get(""))
        if module and is_loaded(self):
            importlib.import_module(module)

    def _check(self, choice: Any) -> None:
        # (A class inherits being a dataclass, but its own fields are none.)
        is_class = isinstance(choice, type)
        if not (is_class and "__dataclass_fields__" in vars(choice)):
            remedy = (
                f"write @dataclass above class {choice.__qualname__}, below the"
                " line that registers it"
                if is_class
                else f"got {choice!r:.80}"
            )
            raise TypeError(
                f"a {self.kind} is a dataclass, whose fields are its"
                f" parameters; {remedy}"
            )
        if not issubclass(choice, self._base):
            raise TypeError(
                f"{choice.__qualname__} is no {self.kind}: it must derive from"
                f" {self._base.__name__}"
            )
        if inspect.isabstract(choice):
            missing = ", ".join(sorted(choice.__abstractmethods__))
            raise TypeError(
                f"{choice.__qualname__} is no {self.kind}: it lacks {missing}"
            )
        for name in sorted(getattr(self._base, "__abstractmethods__", ())):
            _check_parameters(choice, self._base, name)
        fields = [field.name for field in dataclasses.fields(choice)]
        untyped = set(fields) & vars(choice).keys()
        untyped -= inspect.get_annotations(choice).keys()
        for name in sorted(untyped):
            raise TypeError(
                f"{choice.__qualname__}.{name} changes nothing without a type;"
                f" write {name}: TYPE = {vars(choice)[name]!r:.40}"
            )
        for tag in (TAG, OLD_TAGS.get(self.kind)):
            if tag in fields:
                raise TypeError(
                    f"{choice.__qualname__} must not have a field {tag!r}:"
                    f" that key names the {self.kind}"
                )

    def _validate(self, value: Any) -> Any:
        """Makes a choice from data, for pydantic."""
        if isinstance(value, self._base) and not isinstance(value, type):
            if known_name(value) is None:
                raise PydanticCustomError(
                    "choice",
                    "{type} is not registered; give it a name by a decorator"
                    " @register_...",
                    {"type": type(value).__qualname__},
                )
            return value
        if isinstance(value, UnloadedChoice) and not is_loaded(self):
            return value
        if isinstance(value, str):
            value = {TAG: value}
        if not isinstance(value, Mapping):
            raise PydanticCustomError(
                "choice", f"must be a mapping, or the name of a {self.kind}"
            )
        value = with_tag(self.kind, value)
        if fault := twice(self.kind, value):
            error = PydanticCustomError("twice", "{fault}", {"fault": fault})
            old = OLD_TAGS[self.kind]
            self._raise_at(error, {old: value[old]})
        parameters = {key: value[key] for key in value if key != TAG}
        if not is_loaded(self):
            name = value.get(TAG, self.default)
            self._check_name(name)
            return UnloadedChoice(self._base, {TAG: name, **parameters})
        choice: Any = self._select(value)
        result = _adapter(choice).validate_python(parameters)
        # Users' dataclasses may ignore unknown parameters.
        fields = {field.name for field in dataclasses.fields(choice)}
        self._raise_at(
            "unexpected_keyword_argument",
            {key: parameters[key] for key in parameters if key not in fields},
        )
        return result

    def _select(self, value: Mapping[str, Any]) -> type[Any]:
        """Returns the class that a mapping names."""
        name = value.get(TAG, self.default or None)
        words = ""
        try:
            choice = self._named(name) if isinstance(name, str) else None
        except _NoChoiceError as error:
            choice, words = None, str(error)
        if choice is not None:
            return choice
        choices = self._loaded()
        if TAG not in value:
            words = f"is missing; {suggestion('', list(choices))}"
        elif isinstance(name, str):
            words = words or (
                f"there is no {self.kind} {shown(name)};"
                f" {suggestion(name, list(choices))}"
            )
        else:
            self._check_name(name)
        self._raise_at(
            PydanticCustomError("choice_name", "{words}", {"words": words}),
            {TAG: name},
        )
        raise AssertionError("not reached")

    def _check_name(self, name: Any) -> None:
        if not isinstance(name, str) or not name:
            words = f"must be the name of a {self.kind}, got {shown(name)}"
            self._raise_at(
                PydanticCustomError("choice_name", "{words}", {"words": words}),
                {TAG: name},
            )

    def _named(self, name: str) -> type[Any] | None:
        """Returns the class of a name, or of a place ``module:Class``.

        A _NoChoiceError says that there is no such place, or no choice there.
        """
        self._load(name)
        known = self._choices.get(name)
        module, colon, place = name.partition(":")
        if known is not None or not (colon and module and place):
            return known
        if not (may_import(module) or module in self._homes.values()):
            raise _NoChoiceError(
                f"{shown(name)} is code in a module, and a scenario runs none"
                f" here; import {shown(module)} beforehand, as by --import"
            )
        try:
            found: Any = importlib.import_module(module)
            for part in place.split("."):
                found = getattr(found, part)
        except Exception as error:
            raise _NoChoiceError(
                f"cannot get {shown(name)}, as module:Class:"
                f" {type(error).__name__}: {error}"
            ) from error
        try:
            self._check(found)
        except TypeError as error:
            raise _NoChoiceError(f"{shown(name)}: {error}") from error
        choice: type[Any] = found
        if known_name(choice) is None:
            found.__choice__ = name
            self._choices[name] = choice
        return choice

    def _raise_at(
        self, error: str | PydanticCustomError, places: Mapping[str, Any]
    ) -> None:
        """Raises an error at each of some keys with their values, if any."""
        if places:
            raise ValidationError.from_exception_data(
                self.kind,
                [
                    InitErrorDetails(type=error, loc=(key,), input=value)
                    for key, value in places.items()
                ],
            )


class _NoChoiceError(Exception):
    """Nothing can be chosen by a name; the text says why."""


def _check_parameters(choice: Any, base: Any, name: str) -> None:
    """Checks that a method can be called like that of the base."""
    own, wanted = getattr(choice, name), getattr(base, name)
    if not (inspect.isfunction(own) and inspect.isfunction(wanted)):
        return
    signature = inspect.signature(wanted)
    try:
        inspect.signature(own).bind(*signature.parameters)
    except TypeError:
        raise TypeError(
            f"{choice.__qualname__}.{name}() must take"
            f" ({', '.join(signature.parameters)}), got"
            f" ({', '.join(inspect.signature(own).parameters)})"
        ) from None


@functools.cache
def _adapter(choice: Any) -> TypeAdapter[Any]:
    return TypeAdapter(choice)


def _origin(choice: type[Any]) -> tuple[str, str]:
    return choice.__module__, choice.__qualname__


def known_name(choice: Any) -> str | None:
    """Returns the name of a choice, or of its class; None if it has none."""
    cls = choice if isinstance(choice, type) else type(choice)
    # Not inherited: a class derived from a choice is another one.
    name: str | None = vars(cls).get("__choice__")
    return name


def name_of(choice: Any) -> str:
    """Returns the name by which a choice, or its class, is registered.

    Raises:
        ValueError: If it is not registered.
    """
    name = known_name(choice)
    if name is None:
        raise ValueError(f"{choice!r:.80} is not registered")
    return name
