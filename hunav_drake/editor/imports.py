"""Imports files of HuNavSim and other scenarios."""

import itertools
from typing import Any, Literal, NamedTuple, TypeGuard

from hunav_drake.editor.document.plain_data import same
from hunav_drake.editor.faults import DEFERRED, FAST_CHECKS
from hunav_drake.hunavsim.agents_yaml import convert_agents
from hunav_drake.hunavsim.hunav_import import HunavImport
from hunav_drake.hunavsim.import_notes import group_notes
from hunav_drake.scenario.building import document_faults
from hunav_drake.scenario.error import Fault, ScenarioError
from hunav_drake.scenario.yaml_source import parse_yaml
from hunav_drake.systems.common.choice_loading import registered_only

Kind = Literal["agents", "metrics", "scenario"]
Mode = Literal["replace", "add"]


class Imported(NamedTuple):
    """The result of an import.

    Attributes:
        data: The new scenario, as plain data.
        notes: The parts that were not imported, a line for each.
        text: The text, if it is used unchanged.
    """

    data: dict[str, Any]
    notes: list[str]
    text: str | None = None


def imported(
    data: dict[str, Any], kind: Kind, mode: Mode, name: str, text: str
) -> Imported:
    """Imports a file into a scenario.

    Args:
        data: The scenario, which is not changed.
        kind: The type of the file: HuNavSim's agents.yaml or metrics.yaml, or
            a scenario.
        mode: Whether people and walls replace the current ones, or are added.
        name: The name of the file in messages.
        text: The content of the file.

    Raises:
        ScenarioError: With all faults of the file, by line.
    """
    if kind == "scenario":
        return _scenario(data, mode, name, text)
    document = parse_yaml(text, name=name, number_keys=kind == "agents")
    if document.root is None:
        raise ScenarioError(name, document_faults(document))
    if kind == "agents":
        source = convert_agents(document)
    else:
        source = HunavImport(document)
        source.add_metrics(document)
    with registered_only(*DEFERRED):
        source.build(FAST_CHECKS)
    notes = group_notes(source.left_out)
    if kind == "metrics":
        return Imported(_with_evaluator(data, source.data), notes)
    if mode == "add":
        result = _with_more(data, source.data)
        return Imported(_with_places(result, source.data["places"]), notes)
    people = {"humans": source.data["humans"]}
    if places := source.data["places"]:
        people["places"] = places
    return Imported(data | people, notes)


def _scenario(
    data: dict[str, Any], mode: Mode, name: str, text: str
) -> Imported:
    document = parse_yaml(text, name=name)
    if document.root is None or document.findings:
        raise ScenarioError(name, document_faults(document))
    other = document.plain()
    if not isinstance(other, dict):
        words = "must be a mapping, as a scenario is"
        raise ScenarioError(name, [Fault(name, 1, "", words)])
    if mode == "replace":
        return Imported(other, [], text)
    return Imported(_with_more(data, other), [])


def _with_evaluator(
    data: dict[str, Any], source: dict[str, Any]
) -> dict[str, Any]:
    result = dict(data)
    for key in ("evaluator", "simulation"):
        if isinstance(source.get(key), dict):
            old = data.get(key)
            result[key] = {**(old if isinstance(old, dict) else {})}
            result[key] |= source[key]
    return result


def _with_more(data: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    """Returns a scenario with the people and walls of another one added."""
    result = dict(data)
    humans = _list(data.get("humans"))
    more = [dict(it) for it in _list(other.get("humans")) if _is_dict(it)]
    if more:
        # (Other types are reported as faults.)
        names = {
            name for it in humans if isinstance(name := _of(it, "name"), str)
        }
        ids = {id_ for it in humans if isinstance(id_ := _of(it, "id"), int)}
        for human in more:
            _make_unique(human, names, ids)
        _make_groups_unique(more, humans)
        result["humans"] = [*humans, *more]
    old, new = data.get("world"), other.get("world")
    if _is_dict(new) and (old is None or _is_dict(old)):
        world = dict(old or {})
        for key in ("walls", "furniture", "models"):
            if added := _list(new.get(key)):
                world[key] = [*_list(world.get(key)), *added]
        if not same(world, old or {}):
            result["world"] = world
    return result


def _with_places(
    data: dict[str, Any], more: list[dict[str, Any]]
) -> dict[str, Any]:
    """Returns a scenario with places added, except those that it has.

    Trees know them by their numbers, so none gets another one; two different
    places of the same number are reported as a fault of the scenario.
    """
    old = _list(data.get("places"))
    added = [it for it in more if not any(same(it, have) for have in old)]
    return {**data, "places": [*old, *added]} if added else data


def _of(value: Any, key: str) -> Any:
    return value.get(key) if _is_dict(value) else None


def _make_unique(human: dict[str, Any], names: set[str], ids: set[int]) -> None:
    """Gives a person a unique name and number."""
    name = human.get("name")
    if isinstance(name, str) and name:
        stem, count = name, 2
        while human["name"] in names:
            human["name"] = f"{stem[:58]}_{count}"
            count += 1
        names.add(human["name"])
    if isinstance(human.get("id"), int):
        if human["id"] in ids:
            human["id"] = max(ids) + 1
        ids.add(human["id"])


def _make_groups_unique(more: list[dict[str, Any]], others: list[Any]) -> None:
    """Gives groups of people numbers that no group of others has."""
    taken, own = (
        {g for it in part if isinstance(g := _of(it, "group_id"), int)}
        for part in (others, more)
    )
    free = (n for n in itertools.count(1) if n not in taken | own)
    renamed = {n: next(free) for n in sorted(taken & own) if n >= 0}
    for human in more:
        if isinstance(number := human.get("group_id"), int):
            human["group_id"] = renamed.get(number, number)


def _is_dict(value: Any) -> TypeGuard[dict[str, Any]]:
    return isinstance(value, dict)


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []
