"""Applies settings from the command line to a scenario."""

from collections.abc import Mapping, Sequence
import itertools
import re
from typing import Any

from hunav_drake.scenario.building import hint_at, kind_of
from hunav_drake.scenario.error import Loc, path_text, shown
from hunav_drake.scenario.old_words import renew_override
from hunav_drake.scenario.yaml_source import parse_yaml
from hunav_drake.systems.common.old_words import TAG

# A part of a scenario, as in humans[1].goals[0]: names and places in lists.
_KEY = r"[A-Za-z_][\w-]*"
_PATH = re.compile(rf"{_KEY}(\.{_KEY}|\[[0-9]{{1,9}}\])*", re.ASCII)
_STEP = re.compile(rf"({_KEY})|\[([0-9]+)\]", re.ASCII)
_MAX_STEPS = 20


def override_texts(overrides: Mapping[str, str] | Sequence[str]) -> list[str]:
    """Returns settings as they are written: ["robot.radius=0.3"]."""
    if isinstance(overrides, str):
        return [overrides]
    if isinstance(overrides, Mapping):
        return [f"{path}={value}" for path, value in overrides.items()]
    return list(overrides)


def apply_override(data: Any, text: str) -> Loc:
    """Sets one part of plain data: a path, an equals sign, a value in YAML.

    Mappings on the way are made where they are missing; members of lists are
    not. Returns the path as steps.

    Raises:
        ValueError: If the text is not of that form, its value is not YAML, or
            its path does not fit the data.
    """
    path, equals, value_text = text.partition("=")
    path = path.strip()
    loc: Loc = tuple(name or int(index) for name, index in _STEP.findall(path))
    if not (equals and _PATH.fullmatch(path)) or len(loc) > _MAX_STEPS:
        raise ValueError(
            "must be a path and a value, as in robot.radius=0.3 or"
            " humans[1].radius=0.4"
        )
    document = parse_yaml(value_text, name="value")
    for _, finding in document.findings:
        raise ValueError(f"the value {finding.message}")
    value = document.plain()
    loc = renew_override(loc, value, text)
    target = data
    for i, (step, following) in enumerate(itertools.pairwise(loc)):
        if (
            isinstance(target, dict)
            and isinstance(step, str)
            and isinstance(following, str)
        ):
            _make_mapping(target, step, loc[: i + 1])
        target = _member(target, loc[: i + 1])
    if not (isinstance(target, dict) and isinstance(loc[-1], str)):
        _member(target, loc)
    target[loc[-1]] = value
    return loc


def _make_mapping(target: dict[str, Any], step: str, loc: Loc) -> None:
    """Makes a mapping of what is missing, or of the bare name of a choice."""
    value = target.get(step)
    if value is None:
        target[step] = {}
    elif isinstance(value, str) and kind_of(hint_at(loc)):
        target[step] = {TAG: value}


def _member(data: Any, loc: Loc) -> Any:
    """Returns the part of some data that the last step of a path leads to."""
    step = loc[-1]
    whole = path_text(None, loc[:-1]) or "the scenario"
    if isinstance(step, str):
        if not isinstance(data, dict):
            raise ValueError(f"{whole} is {shown(data)}, not a mapping")
        if step not in data:
            raise ValueError(f"{path_text(None, loc)} is not given")
    elif not isinstance(data, list):
        raise ValueError(f"{whole} is {shown(data)}, not a list")
    elif step >= len(data):
        raise ValueError(f"{whole} has {len(data)} members, counted from 0")
    return data[step]
