"""What is wrong with a scenario, as far as it can be told at once."""

from collections.abc import Iterator, Sequence
import dataclasses as dc
from typing import Any

from hunav_drake.editor.document.plain_data import jsonable
from hunav_drake.scenario.building import Check, build_scenario
from hunav_drake.scenario.checks import (
    check_epsilon,
    check_jitter,
    check_people,
    check_sensors,
    check_times,
)
from hunav_drake.scenario.error import Finding, Loc
from hunav_drake.scenario.geometry import (
    check_places,
    check_walls,
    check_world_files,
)
from hunav_drake.scenario.population import check_areas
from hunav_drake.scenario.schema import Scenario
from hunav_drake.scenario.yaml_document import YamlDocument
from hunav_drake.systems.common.choice_loading import registered_only
from hunav_drake.systems.crowd.motion_model import MOTION_MODELS
from hunav_drake.systems.planning.planner import PLANNERS


def find_faults(data: Any, known: Sequence[Loc] = ()) -> list[Finding]:
    """Looks for what can be found without Drake and without compiled code.

    Names of behaviors and metrics, the parameters of planners and of motion
    models, models of files, and populations are not looked at.

    Args:
        data: A scenario as plain data.
        known: Parts that are known to be wrong already.
    """
    with registered_only(*DEFERRED):
        return build_scenario(data, FAST_CHECKS, known)[1]


def message_of(
    finding: Finding, document: YamlDocument | None = None, prefix: Loc = ()
) -> dict[str, Any]:
    """Returns a finding as the page gets it."""
    message, _, remedy = finding.message.partition("; ")
    line = document.line((*prefix, *finding.loc)) if document else 0
    return {
        "path": list(finding.loc),
        "message": message,
        "remedy": remedy,
        "severity": "error",
        "fix": None,
        "uses": jsonable(finding.uses),
        "line": line or None,
    }


def _without_models(check: Check) -> Check:
    """Returns a check of a scenario without the models of its world."""

    def checked(scenario: Scenario) -> Iterator[Finding]:
        world = dc.replace(scenario.world, models=[])
        yield from check(dc.replace(scenario, world=world))

    return checked


# Their modules load compiled code.
DEFERRED = (PLANNERS, MOTION_MODELS)

FAST_CHECKS: tuple[Check, ...] = (
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
