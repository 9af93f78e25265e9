"""Scenario files: finding, loading and naming them."""

from collections.abc import Mapping, Sequence
import dataclasses as dc
from functools import cache
import os
from pathlib import Path
from typing import Any

from hunav_drake.scenario.building import (
    Places,
    build_scenario,
    document_faults,
)
from hunav_drake.scenario.checks import ALL_CHECKS, warn_of_doubts
from hunav_drake.scenario.error import (
    Fault,
    Loc,
    ScenarioError,
    shown,
    suggestion,
)
from hunav_drake.scenario.file_paths import find_files
from hunav_drake.scenario.foreign_files import FOREIGN_FILES
from hunav_drake.scenario.old_words import renew
from hunav_drake.scenario.overrides import apply_overrides
from hunav_drake.scenario.reachability import check_ways
from hunav_drake.scenario.schema import Scenario
from hunav_drake.scenario.yaml_document import YamlDocument
from hunav_drake.scenario.yaml_source import parse_yaml, read_yaml
from hunav_drake.scenarios import hard_names, shipped_names, shipped_text
from hunav_drake.systems.common.files import as_file_name
from hunav_drake.systems.common.suggest import nearest


def LoadScenario(
    filename: str | Path | None = None,
    *,
    data: str | bytes | None = None,
    scenario_name: str | None = None,
    overrides: Mapping[str, str] | Sequence[str] = (),
    ways: bool = False,
    folder: str | Path | None = None,
) -> Scenario:
    """Loads a scenario from a file or from text, and checks it.

    A heading of more than a full turn, which may be in degrees, gives a
    warning, and so does a robot model that is smaller than the robot's disc.

    Args:
        filename: A file, or the name of a shipped scenario, such as
            "passing". The file may be an agents.yaml of HuNavSim: see
            ImportAgents().
        data: The text of a file, instead of a file.
        scenario_name: If given, the file is a mapping from names to
            scenarios, and the one of this name is loaded.
        overrides: Settings that replace those of the file, as on the command
            line: "robot.radius=0.3", "humans[1].goals=[[1, 2]]", or a mapping
            of such paths to values. The values are YAML.
        ways: Whether to check that the robot and the people can reach their
            goals, as `hunav check` does.
        folder: The folder that relative paths in `data` start from; by
            default, the current one. Paths in a file start from its folder.

    Returns:
        The scenario, in which each person has a name and a number. If the
        file gives no name, the scenario is named after `scenario_name` or the
        file.

    Raises:
        ScenarioError: If the file cannot be read, does not fit the schema, or
            cannot be simulated. The error lists all faults with their places.
        TypeError: If `filename` is neither a text nor a path, or `data` no
            text.
        ValueError: If not exactly one of `filename` and `data` is given.
    """
    if not isinstance(filename, str | Path | None):
        raise TypeError(
            "LoadScenario() takes the name of a file, or of a shipped scenario,"
            f" got {shown(filename)}; for data, use"
            " CheckScenario(Scenario(...)), or LoadScenario(data='...') for"
            " YAML"
        )
    if not isinstance(data, str | None):
        raise TypeError(
            "LoadScenario() takes data as YAML text (JSON is YAML, too), got"
            f" {shown(data)}; for a mapping, use data=json.dumps(...)"
        )
    if (filename is None) == (data is None):
        raise ValueError(
            "LoadScenario() takes either filename or data, and one of them"
        )
    if filename is not None:
        document = _read(filename)
    else:
        document = parse_yaml(data or "", name="data")
    if document.root is None:
        raise ScenarioError(document.name, document_faults(document))
    checks = (*ALL_CHECKS, check_ways) if ways else ALL_CHECKS
    content = document.plain()
    if isinstance(content, dict) and scenario_name is None:
        for key in FOREIGN_FILES.keys() & content:
            foreign = FOREIGN_FILES[key](document)
            locs, faults = apply_overrides(foreign.data, overrides)
            if faults:
                raise ScenarioError(foreign.name, faults)
            return _name(foreign.build(checks, locs), filename, None)
    prefix = _prefix(document, content, scenario_name)
    renew(document, prefix)
    plain = document.plain(prefix)
    if filename is not None:
        is_file = os.path.isfile(filename)
        folder = Path(filename).resolve().parent if is_file else None
    if folder is not None:
        find_files(plain, Path(folder).resolve())
    faults = document_faults(document, prefix)
    locs, override_faults = apply_overrides(plain, overrides)
    size = len(prefix)
    unread = [loc[size:] for loc in document.unread if loc[:size] == prefix]
    scenario, findings = build_scenario(plain, checks, unread)
    places = Places(document, prefix, overrides=locs)
    faults += [places.fault(found, plain) for found in findings]
    faults += override_faults
    if scenario is None or faults:
        raise ScenarioError(document.name, faults)
    warn_of_doubts(scenario, lambda found: places.fault(found, plain))
    return _name(scenario, filename, scenario_name)


def ListScenarios() -> dict[str, str]:
    """Returns the names of the shipped scenarios with their descriptions."""
    return dict(_descriptions())


@cache
def _descriptions() -> dict[str, str]:
    result = {}
    for name in shipped_names():
        document = parse_yaml(shipped_text(name), name=f"{name}.yaml")
        text = str(document.plain(("description",)) or "")
        result[name] = " ".join(text.split())
    return result


def _name(
    scenario: Scenario, filename: str | Path | None, scenario_name: str | None
) -> Scenario:
    """Returns the scenario, with a default name if it has none."""
    default = scenario_name or (Path(filename).stem if filename else "")
    name = scenario.name or (as_file_name(default) if default else "")
    return dc.replace(scenario, name=name)


def _prefix(
    document: YamlDocument, content: Any, scenario_name: str | None
) -> Loc:
    """Returns the path of the scenario in a file of one or several."""
    faults = []
    if scenario_name is None:
        names = _several(content)
        if not names:
            return ()
        message = (
            "holds several scenarios: choose one by scenario_name, or"
            f" --name: {', '.join(map(shown, names[:20]))}"
        )
    else:
        names = list(content) if isinstance(content, dict) else []
        is_one = bool(_PARTS & {*names}) and not _are_scenarios(content)
        if scenario_name in names and not is_one:
            return (scenario_name,)
        message = (
            f"there is no scenario {shown(scenario_name)} in it;"
            f" {suggestion(scenario_name, names[:100])}"
        )
        if is_one:
            message = "holds one scenario; leave scenario_name, or --name, out"
        faults = document_faults(document)
    faults.append(Fault(document.name, 0, "", message))
    raise ScenarioError(document.name, faults)


# The keys of a scenario.
_PARTS = frozenset(field.name for field in dc.fields(Scenario))


def _several(content: Any) -> list[str]:
    """Returns the names of the scenarios in a file of several, else nothing."""
    if not isinstance(content, dict) or not content or _PARTS & set(content):
        return []
    return list(content) if _are_scenarios(content) else []


def _are_scenarios(content: dict[str, Any]) -> bool:
    return all(
        isinstance(part, dict) and _PARTS & set(part)
        for part in content.values()
    )


def _read(filename: str | Path) -> YamlDocument:
    """Reads a file, or the shipped scenario of that name."""
    shipped = shipped_names()
    is_file = os.path.isfile(filename)
    if not is_file and str(filename) in {*shipped, *hard_names()}:
        return parse_yaml(shipped_text(str(filename)), name=f"{filename}.yaml")
    document = read_yaml(filename)
    if not is_file:
        line, finding = document.findings[0]
        message = f"{finding.message}; shipped scenarios: {', '.join(shipped)}"
        if near := nearest(Path(filename).stem, shipped):
            message += f"; did you mean {near}?"
        document.findings[0] = line, dc.replace(finding, message=message)
    return document
