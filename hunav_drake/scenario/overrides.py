"""Applies overrides, such as settings of the command line, to a scenario."""

from collections.abc import Mapping, Sequence
import copy
import itertools
import re
from typing import Any

from hunav_drake.scenario.building import hint_at, kind_of, override_place
from hunav_drake.scenario.error import Fault, Loc, child, path_text, shown
from hunav_drake.scenario.old_words import renew_override
from hunav_drake.scenario.yaml_source import parse_yaml
from hunav_drake.systems.common.old_words import TAG

# The path of a part of a scenario, as in humans[1].goals[0].
# (Names of people may have letters and marks of any script.)
_KEY = r"[^\W\d](?:[\w-]|[^\x00-\x7f])*"
_PATH = re.compile(rf"{_KEY}(\.{_KEY}|\[[0-9]{{1,9}}\])*")
_STEP = re.compile(rf"({_KEY})|\[([0-9]+)\]")
_MAX_STEPS = 20


def apply_overrides(
    data: Any, overrides: Mapping[str, str] | Sequence[str]
) -> tuple[dict[Loc, str], list[Fault]]:
    """Applies overrides to plain data, in order.

    Args:
        data: The data, changed. Missing mappings along a path are created,
            missing members of lists are not.
        overrides: Texts of a path, an equals sign and a value in YAML, such
            as "robot.radius=0.3"; one such text; or a mapping of paths to
            values. Members of a list may go by name: "humans.ana.radius=0.3".
            With several robots, paths of `robot` and `planner` are
            those of each of them, and so are those of `sensors`, unless the
            scenario has some of its own.

    Returns:
        The text of each override by the path that it set; and the faults of
        those that could not be applied.
    """
    if isinstance(overrides, str):
        overrides = [overrides]
    elif isinstance(overrides, Mapping):
        overrides = [f"{path}={value}" for path, value in overrides.items()]
    locs: dict[Loc, str] = {}
    faults = []
    for text in overrides:
        try:
            locs |= dict.fromkeys(_apply(data, text), text)
        except ValueError as error:
            faults.append(Fault(override_place(text), 0, "", str(error)))
    return locs, faults


def seed_change(overrides: Sequence[str]) -> str:
    """Returns the override that sets the seed; empty if there is none."""
    for text in overrides:
        data: dict[str, Any] = {}
        if text.lstrip().startswith("simulation"):
            apply_overrides(data, text)
        simulation = data.get("simulation")
        if isinstance(simulation, dict) and "seed" in simulation:
            return text
    return ""


def _apply(data: Any, text: str) -> list[Loc]:
    """Applies one override; returns its paths, or raises a ValueError."""
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
    loc = renew_override(_numbered(data, loc), value, text)
    locs = [loc]
    members = data.get("robots") if isinstance(data, dict) else None
    own = {"robot", "planner"}
    if isinstance(data, dict) and not data.get("sensors"):
        own.add("sensors")
    if members and isinstance(members, list) and loc[0] in own:
        each = [("robots", i, *loc) for i in range(len(members))]
        locs = [_numbered(data, it) for it in each]
    for it in locs:
        _set(data, it, copy.deepcopy(value))
    return locs


def _numbered(data: Any, loc: Loc) -> Loc:
    """Returns a path in which members of lists go by index, not by name."""
    found: list[str | int] = []
    for step in loc:
        names = (
            [child(it, "name") for it in data] if isinstance(data, list) else []
        )
        if isinstance(step, str) and names.count(step) == 1:
            step = names.index(step)
        found.append(step)
        data = child(data, step)
    return tuple(found)


def _set(data: Any, loc: Loc, value: Any) -> None:
    """Sets a part of data, or raises a ValueError."""
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


def _make_mapping(target: dict[str, Any], step: str, loc: Loc) -> None:
    """Makes a mapping of a missing part, or of the bare name of a choice."""
    value = target.get(step)
    if value is None:
        target[step] = {}
    elif isinstance(value, str) and kind_of(hint_at(loc)):
        target[step] = {TAG: value}


def _member(data: Any, loc: Loc) -> Any:
    """Returns the part of data at the last step of a path."""
    step = loc[-1]
    whole = path_text(None, loc[:-1]) or "the scenario"
    if isinstance(step, str):
        if isinstance(data, list):
            raise ValueError(
                f"{whole} has no member named {shown(step)}; its members go by"
                f" name, or by number, as in {whole}[0]"
            )
        if not isinstance(data, dict):
            raise ValueError(f"{whole} is {shown(data)}, not a mapping")
        if step not in data:
            raise ValueError(f"{path_text(None, loc)} is not given")
    elif not isinstance(data, list):
        raise ValueError(f"{whole} is {shown(data)}, not a list")
    elif step >= len(data):
        raise ValueError(f"{whole} has {len(data)} members, counted from 0")
    return data[step]
