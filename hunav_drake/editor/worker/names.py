"""What is wrong with a scenario, of all that a simulation knows."""

import contextlib
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from hunav_drake.scenario.building import build_scenario
from hunav_drake.scenario.checks import ALL_CHECKS
from hunav_drake.scenario.error import Finding
from hunav_drake.scenario.file_paths import find_files
from hunav_drake.scenario.yaml_source import parse_yaml
from hunav_drake.systems.world.models import footprint, model_hulls
from hunav_drake.systems.world.shapes import Model
from hunav_drake.systems.world.solids import WorldFileError

_MODEL: TypeAdapter[Model] = TypeAdapter(Model)


def find_names_faults(
    text: str, folder: str | None, name: str | None
) -> list[dict[str, Any]]:
    """Returns all findings about a scenario, as plain data.

    Args:
        text: Its YAML; if it cannot be read, that is not found here.
        folder: Where its paths start.
        name: Which one of the scenarios in the text it is.
    """
    plain = _plain(text, folder, name)
    if plain is None:
        return []
    findings: list[Finding] = []
    with contextlib.suppress(RecursionError):
        _, findings = build_scenario(plain, ALL_CHECKS)
    return [
        {
            "path": list(found.loc),
            "message": found.message,
            "uses": [list(part) for part in found.uses],
        }
        for found in findings
    ]


def find_model_outlines(
    text: str, folder: str | None, name: str | None
) -> dict[str, list[Any]]:
    """Returns what people walk around of the models in a scenario's world.

    Drake reads the models, so this is not for the editor's own process.

    Args:
        text: Its YAML.
        folder: Where its paths start.
        name: Which one of the scenarios in the text it is.

    Returns:
        For each file, as the text names it, closed outlines of points (x, y)
        from the model's own place, in meters.
    """
    named, found = _models(_plain(text, None, name)), {}
    for data, full in zip(
        named, _models(_plain(text, folder, name)), strict=True
    ):
        try:
            model = _MODEL.validate_python(full)
            hulls = model_hulls(model.file, (0.0, 0.0, 0.0))
        except (ValidationError, WorldFileError):
            # It is told as a fault.
            continue
        cuts = [it for hull in hulls if (it := footprint(hull)) is not None]
        found[data["file"]] = [it.round(4).tolist() for it in cuts]
    return found


def _plain(text: str, folder: str | None, name: str | None) -> Any:
    """Returns a scenario as plain data; None if the text cannot be read."""
    document = parse_yaml(text, name="text")
    if document.root is None:
        return None
    plain = document.plain(() if name is None else (name,))
    if folder is not None:
        find_files(plain, Path(folder).resolve())
    return plain


def _models(plain: Any) -> list[dict[str, Any]]:
    """Returns the models of a world that name a file."""
    world = plain.get("world") if isinstance(plain, dict) else None
    models = world.get("models") if isinstance(world, dict) else None
    return [
        it
        for it in (models if isinstance(models, list) else [])
        if isinstance(it, dict) and isinstance(it.get("file"), str)
    ]
