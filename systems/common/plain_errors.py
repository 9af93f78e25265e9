"""The errors of pydantic, in this project's words."""

from collections.abc import Mapping
import dataclasses
import functools
import re
from typing import Any

from pydantic import ValidationError

from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.suggest import shown, suggestion

_RULES = {
    "bool_type": "must be true or false",
    "dataclass_type": "must be a mapping",
    "dict_type": "must be a mapping",
    "finite_number": "must be a finite number",
    "float_type": "must be a number",
    "greater_than_equal": "must be at least {ge}",
    "int_type": "must be a whole number",
    "less_than_equal": "must be at most {le}",
    "list_type": "must be a list",
    "model_attributes_type": "must be a mapping",
    "string_too_short": "must not be empty",
    "string_too_long": "must have at most {max_length} characters",
    "string_type": "must be text",
    "string_unicode": "must be text",
    "too_long": "must be a list of at most {max_length}",
    "too_short": "must be a list of at least {min_length}",
    "tuple_type": "must be a list of numbers",
}


class ConfigError(ValueError):
    """A configuration cannot be made of its arguments; the text says why."""


def message_of(kind: str, item: Mapping[str, Any]) -> str:
    """Returns the rule that a value breaks, and the value.

    Args:
        kind: The type of an error of pydantic, or one of this project's own.
        item: The error, as `ValidationError.errors` gives it.
    """
    context = item.get("ctx", {})
    value = item["input"]
    if kind in ("range", "choice_name", "rule"):
        return str(item["msg"])
    if kind == "too_long" and context["field_type"] == "Tuple":
        got = context["actual_length"]
        return f"must be {context['max_length']} numbers, got {got}"
    if kind == "literal_error":
        text = context["expected"]
        words = re.findall("'([^']*)'", text)
        hint = suggestion(value, words) if isinstance(value, str) else text
        return f"unknown value {shown(value)}; {hint}"
    if kind in _RULES:
        got = "a number too large" if _is_huge(value) else shown(value)
        return f"{_RULES[kind].format(**context)}, got {got}"
    return f"{item['msg']}, got {shown(value)}"


def _is_huge(value: Any) -> bool:
    return isinstance(value, int) and abs(value) > 10**300


def plain_errors[T: type[Any]](cls: T) -> T:
    """Makes a pydantic dataclass report invalid arguments in one line.

    Its help lists its fields, too: see `explain`. As part of another one, which
    is made of plain data, it is checked as before.
    """
    construct = cls.__init__

    @functools.wraps(construct)
    def __init__(self: Any, *args: Any, **kwargs: Any) -> None:
        try:
            construct(self, *args, **kwargs)
        except ValidationError as error:
            raise ConfigError(_in_one_line(cls, error)) from None

    known: Any = cls
    known.__init__ = __init__
    return explain(cls)


def _in_one_line(cls: Any, error: ValidationError) -> str:
    faults: dict[str, str] = {}
    for item in error.errors(include_url=False):
        kind, loc = item["type"], item["loc"]
        place = "".join(
            f"[{step}]" if isinstance(step, int) else f".{step}" for step in loc
        ).lstrip(".")
        if kind == "missing" and isinstance(loc[-1], int):
            place = place.removesuffix(f"[{loc[-1]}]")
            words = f"must be {loc[-1] + 1} numbers, got {shown(item['input'])}"
        elif kind == "missing":
            words = f"is missing; give {place}=..."
        elif kind == "unexpected_keyword_argument":
            names = [field.name for field in dataclasses.fields(cls)]
            words = f"unknown argument; {suggestion(str(loc[-1]), names)}"
        elif kind == "unexpected_positional_argument":
            words = "must be given by its name, as in pose=(x, y, yaw)"
            place = f"argument {place.strip('[]')}"
        else:
            words = message_of(kind, item)
        faults[place] = words
    told = "; ".join(
        f"{place}: {words}" if place else words
        for place, words in faults.items()
    )
    return f"{cls.__name__}(): {told}"
