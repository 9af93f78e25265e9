"""Writes a scenario as readable YAML."""

import dataclasses as dc
from pathlib import Path
from typing import Any

import yaml

from hunav_drake.scenario.file_paths import relate_files
from hunav_drake.scenario.schema import Scenario
from hunav_drake.scenario.yaml_source import resolve
from hunav_drake.systems.common.files import atomic_write
from hunav_drake.systems.common.old_words import TAG
from hunav_drake.systems.common.registry import known_name
from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.evaluation.evaluator_config import EvaluatorConfig
from hunav_drake.systems.people.behavior_choice import BehaviorConfig
from hunav_drake.systems.people.human_config import STAND_IN


def SaveScenario(scenario: Scenario, filename: str | Path | None = None) -> str:
    """Writes a scenario as YAML.

    LoadScenario() reads an equal scenario from it. Only values that differ
    from the defaults are written.

    Args:
        scenario: The scenario; it is not checked.
        filename: The file to write, if any. An existing file is replaced
            atomically. Paths in it are relative to its folder, except for
            those that have no folder in common with it.

    Returns:
        The text.

    Raises:
        OSError: If the file cannot be written.
        ValueError: If parameters of a choice, or ports of a behavior, hold
            something other than numbers, texts, flags, lists and mappings.
    """
    data = plain(scenario, whole=False)
    if filename is not None:
        relate_files(data, Path(filename).absolute().parent)
    try:
        text: str = yaml.dump(
            data, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=80
        )
    except yaml.YAMLError as error:
        raise ValueError(
            "parameters of choices and ports of behaviors must hold numbers,"
            " texts, flags, lists and mappings, to be written:"
            f" {error.args[0]}, got {type(error.args[-1]).__name__}"
        ) from error
    if filename is not None:
        with atomic_write(filename) as file:
            file.write(text.encode())
    return text


def yaml_text(
    data: Any, *, indented: bool = False, flow: bool = False, width: int = 80
) -> str:
    """Returns plain data as YAML, in the style of `SaveScenario`.

    Args:
        data: Numbers, texts, flags, lists and mappings.
        indented: Whether to indent lists below their keys.
        flow: Whether to write one line with braces and brackets.
        width: The line length at which long texts break, in characters.
    """
    text: str = yaml.dump(
        data,
        Dumper=_FlowDumper
        if flow
        else _IndentedDumper
        if indented
        else _Dumper,
        sort_keys=False,
        allow_unicode=True,
        width=2**30 if flow else width,
    )
    return text.removesuffix("...\n").removesuffix("\n") if flow else text


def plain(value: Any, *, whole: bool = True) -> Any:
    """Returns a scenario or a part of it as lists, mappings and scalars.

    Default values are left out unless `whole` is set.
    """
    if isinstance(value, list | tuple):
        return [plain(item, whole=whole) for item in value]
    if isinstance(value, dict):
        return {key: plain(item, whole=whole) for key, item in value.items()}
    name = known_name(value)
    # A class that is not registered has no form as data.
    nameless = hasattr(type(value), "__registry__") and name is None
    if not dc.is_dataclass(value) or nameless:
        return value
    if isinstance(value, BehaviorConfig) and not (
        {TAG, "ports", "tree"} & set(value.ports)
    ):
        return {TAG: value.type, **value.ports}
    result: dict[str, Any] = {TAG: name} if name else {}
    # Defaults may depend on a profile.
    defaults = (
        value.defaults()
        if isinstance(value, CrowdConfig | EvaluatorConfig)
        else None
    )
    for field in dc.fields(value):
        item = getattr(value, field.name)
        default = field.default
        if field.default_factory is not dc.MISSING:
            default = field.default_factory()
        if defaults is not None and field.name != "profile":
            default = getattr(defaults, field.name)
        if field.name == "pose" and getattr(value, "track", None):
            default = STAND_IN
        if whole or item != default:
            result[field.name] = plain(item, whole=whole)
    return result


class _Dumper(yaml.SafeDumper):
    """Writes points in one line, and quotes text that reads as a number."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


class _IndentedDumper(_Dumper):
    """Indents lists below their keys."""

    # (PyYAML's stubs leave the method without types.)
    def increase_indent(self, flow: bool = False, indentless: bool = False):  # type: ignore[no-untyped-def]
        del indentless
        return super().increase_indent(flow, False)


class _FlowDumper(_Dumper):
    """Writes one line with braces and brackets."""

    def serialize_node(self, node: Any, parent: Any, index: Any) -> Any:
        if isinstance(node, yaml.CollectionNode):
            node.flow_style = True
        elif "\n" in node.value:
            node.style = '"'
        return super().serialize_node(node, parent, index)


def _represent_list(dumper: Any, items: list[Any]) -> Any:
    flow = not any(isinstance(item, list | tuple | dict) for item in items)
    return dumper.represent_sequence(
        "tag:yaml.org,2002:seq", items, flow_style=flow
    )


def _represent_text(dumper: Any, text: str) -> Any:
    # PyYAML follows YAML 1.1, in which 1e3, for instance, is text; and it reads
    # rare line ends back as spaces unless they are escaped.
    style = None if isinstance(resolve(text), str) else "'"
    lines = text.split("\n")
    if len(lines) > 1 and all(line.isprintable() for line in lines):
        style = "|"
    elif not text.isprintable():
        style = '"'
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


def _represent_mapping(dumper: Any, items: dict[str, Any]) -> Any:
    return dumper.represent_mapping(
        "tag:yaml.org,2002:map", items.items(), flow_style=not items
    )


_Dumper.add_representer(list, _represent_list)
_Dumper.add_representer(tuple, _represent_list)
_Dumper.add_representer(str, _represent_text)
_Dumper.add_representer(dict, _represent_mapping)
