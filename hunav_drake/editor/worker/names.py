"""What is wrong with a scenario, of all that a simulation knows."""

import contextlib
from pathlib import Path
from typing import Any

from hunav_drake.scenario.building import build_scenario
from hunav_drake.scenario.checks import ALL_CHECKS
from hunav_drake.scenario.error import Finding
from hunav_drake.scenario.loading import find_files
from hunav_drake.scenario.yaml_source import parse_yaml


def find_names_faults(
    text: str, folder: str | None, name: str | None
) -> list[dict[str, Any]]:
    """Returns all findings about a scenario, as plain data.

    Args:
        text: Its YAML; if it cannot be read, that is not found here.
        folder: Where its paths start.
        name: Which one of the scenarios in the text it is.
    """
    document = parse_yaml(text, name="text")
    if document.root is None:
        return []
    prefix = () if name is None else (name,)
    plain = document.plain(prefix)
    if folder is not None:
        find_files(plain, Path(folder).resolve())
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
