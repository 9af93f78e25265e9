"""The JSON schema of scenario files, for editors and other programs."""

import inspect
import re
import textwrap
from typing import Any

from pydantic import TypeAdapter
from pydantic.json_schema import GenerateJsonSchema
from pydantic_core import core_schema

from hunav_drake.scenario.schema import Scenario

_FIELD = re.compile(r"    (\w+):.*")
_BOUNDS = {
    "ge": "minimum",
    "gt": "exclusiveMinimum",
    "le": "maximum",
    "lt": "exclusiveMaximum",
}
_COMMENT = re.compile(r"    # ?(.*)")


def scenario_json_schema() -> dict[str, Any]:
    """Returns the JSON schema (2020-12) of a scenario.

    Registered choices of users are in it. What a scenario file may hold, and
    the ranges of its numbers, are told; that bodies do not overlap walls, say,
    only `CheckScenario` knows. Comments above fields are their descriptions.
    """
    return {
        "$schema": GenerateJsonSchema.schema_dialect,
        **described_schema(Scenario),
        "title": "Scenario of hunav_drake",
    }


def described_schema(cls: type[Any]) -> dict[str, Any]:
    """Returns the JSON schema of a dataclass, described by its comments."""
    schema = TypeAdapter(cls).json_schema(schema_generator=_WithDescriptions)
    result: dict[str, Any] = _with_bounds(schema)
    return result


def _with_bounds(schema: Any) -> Any:
    """Returns a schema with the words of JSON schemas for bounds.

    pydantic leaves its own where a number is prepared before it is judged.
    """
    if isinstance(schema, list):
        return [_with_bounds(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    is_number = schema.get("type") in ("integer", "number")
    return {
        (_BOUNDS.get(key, key) if is_number else key): _with_bounds(part)
        for key, part in schema.items()
    }


class _WithDescriptions(GenerateJsonSchema):
    """Describes the fields of dataclasses by the comments above them."""

    def dataclass_schema(
        self, schema: core_schema.DataclassSchema
    ) -> dict[str, Any]:
        """Returns the schema of a dataclass."""
        result = super().dataclass_schema(schema)
        comments = _field_comments(schema["cls"])
        for name, part in result.get("properties", {}).items():
            if name in comments:
                part.setdefault("description", comments[name])
        return result


def _field_comments(cls: type[Any]) -> dict[str, str]:
    """Returns the comments above the fields of a class and its bases."""
    comments: dict[str, str] = {}
    for base in reversed(cls.__mro__[:-1]):
        try:
            source = textwrap.dedent(inspect.getsource(base))
        except (OSError, TypeError):
            # Made where no source is kept, as at a prompt.
            continue
        block: list[str] = []
        # What a field directly below another one shares.
        above = ""
        for line in source.splitlines():
            if comment := _COMMENT.fullmatch(line):
                block.append(comment[1])
                continue
            if field := _FIELD.fullmatch(line):
                above = " ".join(block) or above
                if above:
                    comments[field[1]] = above
            elif not line.startswith("    "):
                above = ""
            block = []
    return comments
