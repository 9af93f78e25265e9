"""The schema and the default values for forms."""

import functools
from typing import Any

from hunav_drake.editor.faults import DEFERRED
from hunav_drake.scenario.json_schema import scenario_json_schema
from hunav_drake.scenario.schema import Scenario
from hunav_drake.scenario.writer import plain
from hunav_drake.systems.common.choice_loading import (
    UnloadedChoice,
    registered_only,
)
from hunav_drake.systems.robot.drives import DRIVES
from hunav_drake.systems.robot.robot_config import ROBOTS
from hunav_drake.systems.sensing.sensor_config import SENSORS
from hunav_drake.systems.world.furniture import FURNITURE
from hunav_drake.systems.world.shapes import WALLS

_CHOICES = (WALLS, FURNITURE, ROBOTS, DRIVES, SENSORS)


def form_schema() -> dict[str, Any]:
    """Returns the JSON schema of a scenario, without deferred choices."""
    return _schema(tuple(tuple(registry) for registry in _CHOICES))


@functools.cache
def _schema(choices: tuple[tuple[str, ...], ...]) -> dict[str, Any]:
    """Returns the schema; the cache depends on the registered choices."""
    del choices
    with registered_only(*DEFERRED):
        return scenario_json_schema()


def form_defaults() -> dict[str, Any]:
    """Returns the default scenario as plain data."""
    with registered_only(*DEFERRED):
        result: dict[str, Any] = _named(plain(Scenario()))
    return result


def _named(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _named(item) for key, item in data.items()}
    if isinstance(data, list):
        return [_named(item) for item in data]
    if isinstance(data, UnloadedChoice):
        return {key: plain(item) for key, item in data.as_data().items()}
    return data
