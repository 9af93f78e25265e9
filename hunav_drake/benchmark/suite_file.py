"""Suite files: the shipped suites and those of users."""

from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from hunav_drake.benchmark.paper import PAPER
from hunav_drake.benchmark.suite import Suite
from hunav_drake.scenario.building import (
    Places,
    document_faults,
    schema_findings,
)
from hunav_drake.scenario.error import Fault, ScenarioError
from hunav_drake.scenario.yaml_source import parse_yaml, read_yaml
from hunav_drake.systems.common.suggest import did_you_mean

# The shipped suites by name.
SUITES = {"paper": PAPER}


def LoadSuite(
    *, filename: str | Path | None = None, data: str | None = None
) -> Suite:
    """Loads a suite from a file or from text.

    Args:
        filename: A file, or the name of a shipped suite, such as "paper".
        data: The text of a file, instead of a file.

    Raises:
        ScenarioError: If it cannot be read or does not fit the schema; it
            lists all faults with their places. What its scenarios say is
            checked when it is run.
        ValueError: If not exactly one of `filename` and `data` is given.
    """
    if (filename is None) == (data is None):
        raise ValueError(
            "LoadSuite() takes either filename or data, and one of them"
        )
    if filename is not None and not Path(filename).is_file():
        if str(filename) in SUITES:
            return SUITES[str(filename)]
        known = ", ".join(SUITES)
        near = did_you_mean(str(filename), list(SUITES))
        message = f"there is no such file{near}; shipped suites: {known}"
        raise ScenarioError(
            str(filename), [Fault(str(filename), 0, "", message)]
        )
    if filename is not None:
        document = read_yaml(filename)
    else:
        document = parse_yaml(data or "", name="data")
    faults = document_faults(document)
    if document.root is None or faults:
        raise ScenarioError(document.name, faults)
    plain = document.plain()
    if isinstance(plain, dict) and filename is not None:
        plain.setdefault("name", Path(filename).stem[:64])
    return _build(plain, Places(document), document.name)


def _build(plain: Any, places: Places, name: str) -> Suite:
    try:
        return TypeAdapter(Suite).validate_python(plain)
    except ValidationError as error:
        findings = schema_findings(error, plain, Suite)
        faults = [places.fault(found, plain) for found in findings]
        raise ScenarioError(name, faults) from error
