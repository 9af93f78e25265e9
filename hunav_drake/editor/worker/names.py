"""All checks of a scenario, for which the simulation is loaded."""

from collections.abc import Iterator
import contextlib
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from hunav_drake.editor.document.plain_data import get
from hunav_drake.scenario.building import build_scenario
from hunav_drake.scenario.checks import ALL_CHECKS, find_doubts
from hunav_drake.scenario.error import Finding
from hunav_drake.scenario.file_paths import find_files
from hunav_drake.scenario.population import draw_people
from hunav_drake.scenario.reachability import check_ways
from hunav_drake.scenario.schema import Scenario
from hunav_drake.scenario.writer import plain
from hunav_drake.scenario.yaml_source import parse_yaml
from hunav_drake.systems.world.models import model_solids
from hunav_drake.systems.world.shapes import Model
from hunav_drake.systems.world.solids import WorldFileError

# At most so many people of a population are shown before a run.
_MOST_DRAWN = 500

_MODEL: TypeAdapter[Model] = TypeAdapter(Model)


def find_names_faults(
    text: str, folder: str | None, name: str | None
) -> list[dict[str, Any]]:
    """Returns what `hunav check` finds in a scenario, as plain data.

    Trials run in spite of goals that cannot be reached, and of doubts, so these
    have the severity "warning".

    Args:
        text: Its YAML; if it cannot be read, there are no findings.
        folder: The folder of its relative paths.
        name: The name of the scenario, if the text has several.
    """
    data = _plain(text, folder, name)
    if data is None:
        return []
    findings: list[Finding] = []
    harmless: set[str] = set()

    def ways(scenario: Scenario) -> Iterator[Finding]:
        for found in check_ways(scenario):
            harmless.add(found.message)
            yield found

    with contextlib.suppress(RecursionError):
        scenario, findings = build_scenario(data, (*ALL_CHECKS, ways))
        if scenario is not None:
            findings = find_doubts(scenario)
            harmless.update(found.message for found in findings)
    return [
        {
            "path": list(found.loc),
            "message": found.message,
            "uses": [list(part) for part in found.uses],
            "severity": "warning" if found.message in harmless else "error",
        }
        for found in findings
    ]


def find_model_outlines(
    text: str, folder: str | None, name: str | None
) -> dict[str, list[Any]]:
    """Returns the outlines of the models in a scenario's world.

    Drake reads the models, so this is not for the process of the page.

    Args:
        text: Its YAML.
        folder: The folder of its relative paths.
        name: The name of the scenario, if the text has several.

    Returns:
        For each file name in the text, closed outlines of points (x, y) in the
        frame of the model, in meters.
    """
    named, found = _models(_plain(text, None, name)), {}
    for data, full in zip(
        named, _models(_plain(text, folder, name)), strict=True
    ):
        try:
            model = _MODEL.validate_python(full)
            options = model.model_path, model.skip_missing
            cuts = model_solids(model.file, (0, 0, 0), *options).footprints
        except (ValidationError, WorldFileError):
            # The check reports it.
            continue
        found[data["file"]] = [it.round(4).tolist() for it in cuts]
    return found


def find_drawn_people(
    text: str, folder: str | None, name: str | None
) -> dict[str, Any]:
    """Returns the people that the seed draws for the cohorts of a scenario.

    Args:
        text: Its YAML.
        folder: The folder of its relative paths.
        name: The name of the scenario, if the text has several.

    Returns:
        The "seed"; and "people": for each the number of its "cohort", and its
        properties as a listed person ("human"). There are none if they cannot
        be drawn, which the checks report.
    """
    data = _plain(text, folder, name)
    scenario = None
    if get(data, ("population", "cohorts")):
        with contextlib.suppress(RecursionError):
            scenario = build_scenario(data, ())[0]
    if scenario is None:
        return {"seed": None, "people": []}
    population = scenario.population
    try:
        drawn = draw_people(scenario)
    except (OSError, ValueError):
        return {"seed": None, "people": []}
    # Those of cohorts come before those of sources.
    arriving = sum(source.number for source in population.sources)
    number = sum(cohort.number for cohort in population.cohorts)
    first = len(drawn) - arriving - number
    cohorts = [
        i for i, it in enumerate(population.cohorts) for _ in range(it.number)
    ]
    people = drawn[first : first + min(number, _MOST_DRAWN)]
    seed = population.seed
    return {
        "seed": scenario.simulation.seed if seed is None else seed,
        "people": [
            {"cohort": i, "human": _rounded(plain(human, whole=False))}
            for i, human in zip(cohorts, people, strict=False)
        ],
    }


def _rounded(value: Any) -> Any:
    """Returns data with all numbers in whole thousandths."""
    if isinstance(value, dict):
        return {key: _rounded(it) for key, it in value.items() if key != "id"}
    if isinstance(value, list):
        return [_rounded(it) for it in value]
    return round(value, 3) if isinstance(value, float) else value


def _plain(text: str, folder: str | None, name: str | None) -> Any:
    """Returns a scenario as plain data; None if the text cannot be read."""
    document = parse_yaml(text, name="text")
    if document.root is None:
        return None
    data = document.plain(() if name is None else (name,))
    if folder is not None:
        find_files(data, Path(folder).resolve())
    return data


def _models(data: Any) -> list[dict[str, Any]]:
    """Returns the models of a world that name a file."""
    world = data.get("world") if isinstance(data, dict) else None
    models = world.get("models") if isinstance(world, dict) else None
    return [
        it
        for it in (models if isinstance(models, list) else [])
        if isinstance(it, dict) and isinstance(it.get("file"), str)
    ]
