"""Scenarios to start with: places of some size, with people in them."""

from collections.abc import Mapping
from typing import Any

from pydantic import TypeAdapter, ValidationError

from hunav_drake.editor.document.plain_data import OperationError
from hunav_drake.editor.faults import DEFERRED
from hunav_drake.editor.templates.base import Template
from hunav_drake.editor.templates.cafe import Cafe
from hunav_drake.editor.templates.corridors import Corridor, Crossing, Room
from hunav_drake.editor.templates.office import Office
from hunav_drake.scenario.json_schema import described_schema
from hunav_drake.scenario.writer import SaveScenario
from hunav_drake.systems.common.choice_loading import registered_only
from hunav_drake.systems.common.suggest import shown, suggestion

__all__ = [
    "TEMPLATES",
    "Cafe",
    "Corridor",
    "Crossing",
    "Office",
    "Room",
    "Template",
    "template_forms",
    "template_text",
]

TEMPLATES: dict[str, type[Template]] = {
    "room": Room,
    "corridor": Corridor,
    "crossing": Crossing,
    "office": Office,
    "cafe": Cafe,
}


def template_forms() -> list[dict[str, Any]]:
    """Returns what a page needs to offer the templates."""
    result = []
    for name, template in TEMPLATES.items():
        schema = described_schema(template)
        defaults = {
            key: part.get("default")
            for key, part in schema.get("properties", {}).items()
        }
        result.append(
            {
                "name": name,
                "title": template.title,
                "schema": schema,
                "defaults": defaults,
            }
        )
    return result


def template_text(name: str, values: Mapping[str, Any]) -> str:
    """Returns the text of the scenario that a template makes.

    Args:
        name: One of `TEMPLATES`.
        values: Values for its fields; the others have their defaults.

    Raises:
        OperationError: If there is no such template, or no such scenario.
    """
    if name not in TEMPLATES:
        raise OperationError(
            f"there is no template {shown(name)};"
            f" {suggestion(name, list(TEMPLATES))}"
        )
    try:
        adapter: TypeAdapter[Any] = TypeAdapter(TEMPLATES[name])
        template = adapter.validate_python(dict(values))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"])) or name
        raise OperationError(
            f"template {name}: {place}: {first['msg']}"
        ) from None
    with registered_only(*DEFERRED):
        try:
            return SaveScenario(template.make())
        except ValueError as error:
            raise OperationError(f"template {name}: {error}") from error
