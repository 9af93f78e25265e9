"""Builds a Scenario from plain data, or lists all faults of the data."""

from collections.abc import Callable, Iterable, Mapping, Sequence
import copy
import dataclasses as dc
import functools
from functools import partial
from types import NoneType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

from pydantic import TypeAdapter, ValidationError

from hunav_drake.scenario.error import (
    Fault,
    Finding,
    Loc,
    child,
    path_text,
    suggestion,
)
from hunav_drake.scenario.fleet import check_fleet, find_of_each
from hunav_drake.scenario.schema import Scenario
from hunav_drake.scenario.yaml_document import YamlDocument
from hunav_drake.systems.common.old_words import TAG
from hunav_drake.systems.common.plain_errors import message_of
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.people.behavior_choice import BehaviorConfig

# A function that finds faults of a scenario that fits the schema.
Check = Callable[[Scenario], Iterable[Finding]]

# At most so many faults of the schema are read: with more it is no scenario.
_MAX_SCHEMA_FAULTS = 1000

# Substitutes for a person, a wall or furniture that does not fit the schema,
# while the rest is checked: out of the way of everything else.
_SUBSTITUTE_HUMAN = {"pose": [0.0, 0.0, 0.0]}
_SUBSTITUTES = {
    "walls": {"type": "box", "center": [1e5, 1e5], "size": [1e-3, 1e-3]},
    "furniture": {"type": "pillar", "center": [1e5, 1e5]},
}

_OLD_PARAMETERS = (
    "parameters stand beside the type now, as in planner: {type: pursuit,"
    " cruise_speed: 0.8} or crowd: {model: {type: orca, time_horizon: 2.0}}"
)


@dc.dataclass(frozen=True)
class Places:
    """The places in files where the parts of a scenario were written.

    Attributes:
        document: The file or text; None for a scenario made in Python.
        prefix: The path of the scenario in the document.
        origins: For a file of another format, the origin of each part of the
            scenario.
        overrides: The text of the override that set a part.
    """

    document: YamlDocument | None = None
    prefix: Loc = ()
    origins: Mapping[Loc, tuple[YamlDocument, Loc]] = dc.field(
        default_factory=dict
    )
    overrides: Mapping[Loc, str] = dc.field(default_factory=dict)

    def fault(self, finding: Finding, data: Any) -> Fault:
        """Returns a finding with its place; data may be a Scenario."""
        path = path_text(data, finding.loc)
        for loc in (finding.loc, *finding.uses):
            for size in range(len(loc), 0, -1):
                if text := self.overrides.get(loc[:size]):
                    return Fault(override_place(text), 0, path, finding.message)
        if self.document is None:
            return Fault("scenario", 0, path, finding.message)
        document = self.document
        # A default is written nowhere, but the parts that it depends on are.
        parts = [(*self.prefix, *part) for part in (finding.loc, *finding.uses)]
        loc = next(filter(document.find, parts), parts[0])
        for size in range(len(finding.loc), 0, -1):
            if origin := self.origins.get(finding.loc[:size]):
                document, loc = origin
                # The two outer keys are the same in all such files.
                path = path_text(None, loc[2:])
                break
        return Fault(document.name, document.line(loc), path, finding.message)


def override_place(text: str) -> str:
    """Returns the source of an override, for messages."""
    line = " ".join(text.split())
    return f"--set {line if len(line) <= 60 else line[:57] + '...'}"


def document_faults(document: YamlDocument, prefix: Loc = ()) -> list[Fault]:
    """Returns the faults of a document's YAML.

    Paths below the prefix are relative to it, all others are full.
    """
    whole, part = document.plain(), document.plain(prefix)
    result = []
    for line, finding in document.findings:
        loc = finding.loc
        if prefix and loc[: len(prefix)] == prefix:
            path = path_text(part, loc[len(prefix) :])
        else:
            path = path_text(whole, loc)
        result.append(Fault(document.name, line, path, finding.message))
    return result


def build_scenario(
    data: Any, checks: Sequence[Check], known: Iterable[Loc] = ()
) -> tuple[Scenario | None, list[Finding]]:
    """Builds a scenario from plain data, and finds all faults.

    Args:
        data: Lists, mappings and scalars in the form of a Scenario.
        checks: The checks beyond the schema.
        known: Parts with known faults; findings on them and on parts that
            depend on them are dropped.

    Returns:
        The scenario, None if there are findings; and the findings.
    """
    findings: list[Finding] = []
    scenario: Scenario | None
    try:
        scenario = TypeAdapter(Scenario).validate_python(data)
    except ValidationError as error:
        findings = schema_findings(error, data)
        scenario = _best_effort(data, [finding.loc for finding in findings])
    silent = _Overlap(known)
    findings = [found for found in findings if not silent.meets(found.loc)]
    if scenario is None:
        return None, findings
    of_each: list[Check] = [partial(find_of_each, it) for it in checks]
    for check in (check_fleet, *of_each):
        silent = _Overlap([*known, *(found.loc for found in findings)])
        findings += [
            found
            for found in check(scenario)
            if not any(map(silent.meets, (found.loc, *found.uses)))
        ]
    if findings:
        return None, findings
    return scenario, []


def schema_findings(
    error: ValidationError, data: Any, schema: Any = Scenario
) -> list[Finding]:
    """Returns the errors of pydantic for plain data, in this project's words.

    `schema` is the type that the data were validated against.
    """
    result: dict[Loc, Finding] = {}
    for item in error.errors(include_url=False)[:_MAX_SCHEMA_FAULTS]:
        loc, keys = _clean(item["loc"], data, schema)
        kind = item["type"]
        if kind == "missing" and isinstance(loc[-1], int):
            # pydantic lists all missing numbers in order: the last one counts.
            got = len(item["input"])
            message = f"must be {loc[-1] + 1} numbers, got {got}"
            loc = loc[:-1]
        elif kind == "missing":
            message = "is missing"
        elif kind == "unexpected_keyword_argument":
            message = f"unknown key; {suggestion(str(loc[-1]), keys)}"
            if loc[-1] == "parameters":
                message = _OLD_PARAMETERS
        else:
            message = message_of(kind, item)
        result[loc] = Finding(loc, message)
    return list(result.values())


def _clean(
    steps: Sequence[str | int], data: Any, schema: Any
) -> tuple[Loc, list[str]]:
    """Returns a path of pydantic without the names of union members.

    The second value is the list of keys that are valid at its last step.
    """
    loc: list[str | int] = []
    keys: list[str] = []
    hint: Any = schema
    for step in steps:
        hint, registry = _plain(hint)
        if registry is not None:
            hint = registry.find(data)
        elif get_origin(hint) in (Union, UnionType):
            members = [_plain(m)[0] for m in get_args(hint)]
            members = [m for m in members if m is not NoneType]
            if len(members) > 1:
                by_name = {m.__name__.lower(): m for m in members}
                hint = by_name.get(str(step))
                continue
            hint = members[0]
        loc.append(step)
        data = child(data, step)
        keys = []
        if isinstance(hint, type) and dc.is_dataclass(hint):
            keys = [field.name for field in dc.fields(hint)]
            keys += [TAG] if registry is not None else []
        hint = inner_hint(hint, step)
    return tuple(loc), keys


def _plain(hint: Any) -> tuple[Any, Registry | None]:
    """Returns a type without its annotations, and its register if any."""
    registry = None
    while get_origin(hint) is Annotated:
        hint, *notes = get_args(hint)
        registry = next((n for n in notes if isinstance(n, Registry)), registry)
    return hint, registry


def inner_hint(hint: Any, step: str | int) -> Any:
    """Returns the type of a field of a dataclass, or of the items of a list."""
    hint, _ = _plain(hint)
    if isinstance(hint, type) and dc.is_dataclass(hint):
        return _hints(hint).get(str(step))
    return next(iter(get_args(hint)), None)


@functools.cache
def _hints(cls: type[Any]) -> dict[str, Any]:
    return get_type_hints(cls, include_extras=True)


def hint_at(loc: Loc) -> Any:
    """Returns the type of a part of a scenario; None if there is none."""
    hint: Any = Scenario
    for step in loc:
        hint = inner_hint(hint, step)
    return hint


def kind_of(hint: Any) -> str:
    """Returns the kind of choice of a type, as named by its register.

    It is "behavior" for behaviors, and empty for a type without a choice.
    """
    hint, registry = _plain(hint)
    if registry is not None:
        return registry.kind
    members = [_plain(member)[0] for member in get_args(hint)]
    return "behavior" if BehaviorConfig in members else ""


def _best_effort(data: Any, faulty: Iterable[Loc]) -> Scenario | None:
    """Returns a scenario with defaults for the parts that are faulty."""
    if not isinstance(data, dict):
        return None
    data = copy.deepcopy(data)
    for loc in faulty:
        if len(loc) >= 3 and loc[0] == "world" and loc[1] in _SUBSTITUTES:
            data["world"][loc[1]][loc[2]] = dict(_SUBSTITUTES[loc[1]])
        elif len(loc) >= 2 and loc[0] == "humans":
            human = data["humans"][loc[1]]
            if len(loc) == 2 or not isinstance(human, dict):
                data["humans"][loc[1]] = dict(_SUBSTITUTE_HUMAN)
            elif loc[2] == "pose":
                human.update(_SUBSTITUTE_HUMAN)
            else:
                human.pop(loc[2], None)
        elif loc == ("robots",):
            data["robots"] = [_substitute_robot(0)]
        elif loc and loc[0] == "robots":
            member = data["robots"][loc[1]]
            if len(loc) == 2 or not isinstance(member, dict):
                data["robots"][loc[1]] = _substitute_robot(loc[1])
            elif loc[2] == "name":
                member.update(_substitute_robot(loc[1]))
            else:
                _drop(member, loc[2:])
        elif loc:
            _drop(data, loc)
    try:
        return TypeAdapter(Scenario).validate_python(data)
    except ValidationError:
        # There are more faults than were read: those known are enough.
        return None


def _substitute_robot(i: str | int) -> dict[str, Any]:
    """Returns one of several robots, in place of a faulty one."""
    return {"name": f"robot_{i}"}


def _drop(data: Any, loc: Loc) -> None:
    """Takes a faulty part out of a scenario or of one of its robots."""
    key = loc[0]
    if len(loc) < 2 or not isinstance(data.get(key), dict):
        data.pop(key, None)
    elif loc[1] == TAG and kind_of(hint_at((key,))):
        # The parameters beside it are of an unknown type.
        data.pop(key)
    else:
        data[key].pop(loc[1], None)


class _Overlap:
    """Checks whether a part lies in one of some parts, or contains one."""

    def __init__(self, locs: Iterable[Loc]) -> None:
        self._locs = set(locs)
        self._around = {
            loc[:size] for loc in self._locs for size in range(len(loc) + 1)
        }

    def meets(self, loc: Loc) -> bool:
        return loc in self._around or any(
            loc[:size] in self._locs for size in range(len(loc))
        )
