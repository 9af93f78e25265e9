"""The JSON schema of scenario files, for editors and other programs."""

from typing import Any

from pydantic import TypeAdapter
from pydantic.json_schema import GenerateJsonSchema
from pydantic_core import core_schema

from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.field_docs import class_doc, field_docs

_BOUNDS = {
    "ge": "minimum",
    "gt": "exclusiveMinimum",
    "le": "maximum",
    "lt": "exclusiveMaximum",
}


def scenario_json_schema() -> dict[str, Any]:
    """Returns the JSON schema (2020-12) of a scenario.

    It includes the choices that users registered. It describes keys, types and
    ranges; other rules, such as that bodies must not overlap walls, are checked
    by `CheckScenario`. The strings below fields are their descriptions.
    """
    return {
        "$schema": GenerateJsonSchema.schema_dialect,
        **described_schema(Scenario),
        "title": "Scenario of hunav_drake",
    }


def described_schema(cls: type[Any]) -> dict[str, Any]:
    """Returns the JSON schema of a dataclass with descriptions."""
    schema = TypeAdapter(cls).json_schema(schema_generator=_WithDescriptions)
    result: dict[str, Any] = _with_bounds(schema)
    return result


def _with_bounds(schema: Any) -> Any:
    """Returns a schema with JSON schema's keywords for bounds.

    pydantic keeps its own where a number is converted before it is validated.
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
    """Describes the fields of dataclasses by the strings below them."""

    def dataclass_schema(
        self, schema: core_schema.DataclassSchema
    ) -> dict[str, Any]:
        """Returns the schema of a dataclass."""
        result = super().dataclass_schema(schema)
        if text := class_doc(schema["cls"]):
            result["description"] = text
        docs = field_docs(schema["cls"])
        for name, part in result.get("properties", {}).items():
            if name in docs:
                part.setdefault("description", docs[name])
        return result
