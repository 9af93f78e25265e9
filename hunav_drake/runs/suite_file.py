"""Suite files: the shipped suites and those of users."""

from importlib import resources
from pathlib import Path
from typing import Annotated, Any

from pydantic import TypeAdapter, ValidationError

from hunav_drake.runs.suite import Suite
from hunav_drake.runs.suite_checks import formula_findings
from hunav_drake.scenario.building import (
    Places,
    document_faults,
    schema_findings,
)
from hunav_drake.scenario.error import Fault, ScenarioError
from hunav_drake.scenario.old_words import renew
from hunav_drake.scenario.yaml_document import YamlDocument
from hunav_drake.scenario.yaml_source import parse_yaml, read_yaml
from hunav_drake.systems.common.files import as_file_name
from hunav_drake.systems.common.suggest import did_you_mean
from hunav_drake.systems.planning.planner import PLANNERS, PlannerConfig


def ListSuites() -> dict[str, str]:
    """Returns the names and descriptions of the shipped suites."""
    return {
        name: LoadSuite(filename=name).description for name in _shipped_names()
    }


def LoadSuite(
    *, filename: str | Path | None = None, data: str | None = None
) -> Suite:
    """Loads a suite from a file or from text.

    Args:
        filename: A file, or the name of a shipped suite, such as "paper".
        data: The text of a suite, instead of a file.

    Raises:
        ScenarioError: If it cannot be read or does not fit the schema; it
            lists all faults with their places. Its scenarios are checked when
            it is run.
        ValueError: If not exactly one of `filename` and `data` is given.
    """
    if (filename is None) == (data is None):
        raise ValueError("LoadSuite() takes exactly one of filename and data")
    document = (
        _read(filename) if filename else parse_yaml(data or "", name="data")
    )
    faults = document_faults(document)
    if document.root is None or faults:
        raise ScenarioError(document.name, faults)
    choices = list[Annotated[PlannerConfig, PLANNERS]]
    renew(document, ("planners",), choices)
    plain = document.plain()
    if isinstance(plain, dict) and filename is not None:
        plain.setdefault("name", as_file_name(Path(filename).stem))
    return _build(plain, Places(document), document.name)


def _shipped_names() -> list[str]:
    folder = resources.files("hunav_drake.runs") / "suites"
    return sorted(Path(entry.name).stem for entry in folder.iterdir())


def _read(filename: str | Path) -> YamlDocument:
    """Reads a file, or the shipped suite of that name."""
    names = _shipped_names()
    if Path(filename).is_file():
        return read_yaml(filename)
    if str(filename) not in names:
        near = did_you_mean(str(filename), names)
        known = ", ".join(names)
        message = f"there is no such file{near}; shipped suites: {known}"
        raise ScenarioError(
            str(filename), [Fault(str(filename), 0, "", message)]
        )
    folder = resources.files("hunav_drake.runs") / "suites"
    file = folder / f"{filename}.yaml"
    return parse_yaml(file.read_bytes(), name=file.name)


def _build(plain: Any, places: Places, name: str) -> Suite:
    try:
        suite = TypeAdapter(Suite).validate_python(plain)
    except ValidationError as error:
        findings = schema_findings(error, plain, Suite)
        faults = [places.fault(found, plain) for found in findings]
        raise ScenarioError(name, faults) from error
    if faults := [places.fault(it, plain) for it in formula_findings(suite)]:
        raise ScenarioError(name, faults)
    return suite
