"""The fast checks of a scenario."""

from collections.abc import Iterator, Sequence
import dataclasses as dc
from pathlib import Path
from typing import Any

from hunav_drake.editor.document.plain_data import get
from hunav_drake.editor.fixes import fix_of
from hunav_drake.scenario.building import Check, build_scenario
from hunav_drake.scenario.checks import (
    check_epsilon,
    check_jitter,
    check_people,
    check_sensors,
    check_times,
)
from hunav_drake.scenario.error import Finding, Loc
from hunav_drake.scenario.fleet import check_fleet
from hunav_drake.scenario.geometry import (
    check_places,
    check_walls,
    check_world_files,
)
from hunav_drake.scenario.population import check_areas
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.choice_loading import registered_only
from hunav_drake.systems.crowd.motion_model import MOTION_MODELS
from hunav_drake.systems.planning.planner import PLANNERS


def find_faults(
    data: Any, known: Sequence[Loc] = (), folder: Path | None = None
) -> list[Finding]:
    """Returns the faults that need neither Drake nor compiled code.

    It does not check names of behaviors and metrics, parameters of planners
    and motion models, models from files, and populations.

    Args:
        data: A scenario as plain data.
        known: Parts that are known to be wrong.
        folder: The folder of relative paths of maps; without, no map is read.
    """
    with registered_only(*DEFERRED):
        return build_scenario(with_map(data, folder), FAST_CHECKS, known)[1]


def with_map(data: Any, folder: Path | None) -> Any:
    """Returns data with the path of the map, or without a map outside."""
    name = get(data, ("world", "map"))
    if not isinstance(name, str) or not name:
        return data
    world = {key: it for key, it in data["world"].items() if key != "map"}
    if (path := inside(folder, name)) is not None:
        world["map"] = str(path)
    return {**data, "world": world}


def inside(folder: Path | None, name: str) -> Path | None:
    """Returns the path of a file if it is in a folder, else None."""
    if folder is None or not name.isprintable():
        return None
    try:
        path = (folder / name).resolve()
        return path if path.is_relative_to(folder.resolve()) else None
    except (OSError, RuntimeError, ValueError):
        return None


def message_of(
    finding: Finding,
    data: Any,
    line: int | None = None,
    severity: str = "error",
) -> dict[str, Any]:
    """Returns the message to the page about a finding.

    Args:
        finding: The finding.
        data: The scenario as plain data.
        line: Its line in the text, if known.
        severity: "error", or "warning" if the scenario can run all the same.
    """
    message, _, remedy = finding.message.partition("; ")
    return {
        "path": list(finding.loc),
        "message": message,
        "remedy": remedy,
        "severity": severity,
        "fix": fix_of(finding, data),
        "uses": [list(loc) for loc in finding.uses],
        "line": line,
    }


def _without_models(check: Check) -> Check:
    """Returns a check that ignores the models of the world."""

    def checked(scenario: Scenario) -> Iterator[Finding]:
        world = dc.replace(scenario.world, models=[])
        yield from check(dc.replace(scenario, world=world))

    return checked


# Their modules load compiled code.
DEFERRED = (PLANNERS, MOTION_MODELS)

FAST_CHECKS: tuple[Check, ...] = (
    check_fleet,
    check_people,
    check_epsilon,
    check_jitter,
    check_areas,
    check_times,
    check_sensors,
    _without_models(check_world_files),
    check_walls,
    _without_models(check_places),
)
