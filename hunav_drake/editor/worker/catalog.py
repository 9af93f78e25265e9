"""What a scenario can choose from, as the editor shows it."""

from collections.abc import Iterator
import inspect
import json
import re
import shutil
from typing import Any

from pydantic import TypeAdapter

from hunav_drake.plots.style import PALETTE
from hunav_drake.scenario.json_schema import scenario_json_schema
from hunav_drake.systems.behavior import BEHAVIORS, LoadTree, RenderBehaviorTree
from hunav_drake.systems.behavior.language.documents import Documents
from hunav_drake.systems.behavior.language.xml_source import XmlElement
from hunav_drake.systems.behavior.nodes.node import NodeType
from hunav_drake.systems.behavior.profiles import behavior_set
from hunav_drake.systems.behavior.tree import Tree
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.crowd.motion_model import MotionModel
from hunav_drake.systems.evaluation.metrics import METRICS, select_metrics
from hunav_drake.systems.planning.planner import PlannerConfig
from hunav_drake.systems.robot.robot_config import RobotConfig

# A color of its own for each behavior: those of the plots, but two grays for
# black, which cannot be seen on a dark map.
_COLORS = dict(
    zip(BEHAVIORS, (*PALETTE[:6], "#6b6b6b", "#a3a3a3"), strict=True)
)
_GRAY = "#7f7f7f"

# Trees in trees beyond this are not looked at for help.
_DEEPEST = 5

# The words of ports that say nothing by themselves.
_TYPES = {
    "double": "number",
    "float": "number",
    "int": "integer",
    "bool": "boolean",
    "std::string": "string",
}


def make_catalog() -> dict[str, Any]:
    """Returns the message with all choices, those of users among them."""
    return {
        "kind": "catalog",
        "schema": scenario_json_schema(),
        "behaviors": behavior_entries(),
        "planners": _choices(PlannerConfig),
        "models": _choices(MotionModel),
        "robots": _choices(RobotConfig),
        "metrics": metric_entries(),
        "ready": True,
    }


def behavior_entries() -> list[dict[str, Any]]:
    """Returns the behaviors that a person can have."""
    return [
        behavior_entry(name, LoadTree(name), _COLORS.get(name, _GRAY))
        for name in BEHAVIORS
    ]


def behavior_entry(name: str, tree: Tree, color: str) -> dict[str, Any]:
    """Returns a behavior: its words, its ports and its picture.

    Args:
        name: What a scenario calls it.
        tree: What it is.
        color: That of people who have it.
    """
    drawing = RenderBehaviorTree(tree)
    picture = None
    if shutil.which("dot") is not None:
        svg = drawing.graph().create(format="svg", encoding="utf-8")
        picture = _whole_picture(svg.decode())
    return {
        "name": name,
        "help": _sentence(tree.documents.comments),
        "letter": _letters(name),
        "color": color,
        "ports": port_entries(tree),
        "picture": picture,
        "drawing": drawing.text,
    }


def port_entries(tree: Tree) -> list[dict[str, Any]]:
    """Returns the ports of a tree that a scenario can set.

    A port is as the first leaf that takes it: its schema has range and unit.
    """
    entries = []
    for port in tree.documents.main_ports().values():
        kind = _TYPES.get(port.type, "string")
        entry: dict[str, Any] = {
            "name": port.name,
            "type": kind,
            "default": _value(kind, port.default),
            "required": port.default is None,
            "help": "",
            "schema": {},
        }
        taker = _taker(tree.documents, tree.name, port.name)
        if taker is not None:
            leaf, name = taker
            entry["schema"] = leaf.ports[name].adapter.json_schema()
            words = _words_about(name, leaf.function) or leaf.doc
            entry["help"] = f"{leaf.name}: {words}"
        elif part := _part_switched(tree.documents, tree.name, port.name):
            entry["help"] = f"Switches the part {part} on or off."
        entries.append(entry)
    return entries


def _taker(
    documents: Documents, tree: str, port: str, depth: int = 0
) -> tuple[NodeType, str] | None:
    """Returns the first leaf that takes a port of a tree, and as which one."""
    if tree not in documents.trees or depth > _DEEPEST:
        return None
    types = behavior_set("default").node_types()
    for element in _elements(documents.trees[tree].element):
        for name, value in element.attributes.items():
            if value != f"{{{port}}}":
                continue
            kind = element.attributes.get("ID", element.tag)
            if element.tag == "SubTree":
                taker = _taker(documents, kind, name, depth + 1)
                if taker is not None:
                    return taker
            leaf = types.get(element.tag) or types.get(kind)
            if leaf is not None and name in leaf.ports:
                return leaf, name
    return None


def _part_switched(documents: Documents, tree: str, port: str) -> str:
    """Returns the part of a tree that a port lets be skipped, or nothing."""
    for element in _elements(documents.trees[tree].element):
        condition = element.attributes.get("_skipIf", "")
        if re.search(rf"\b{re.escape(port)}\b", condition):
            return element.attributes.get("ID", element.tag)
    return ""


def _elements(element: XmlElement) -> Iterator[XmlElement]:
    yield element
    for child in element.children:
        yield from _elements(child)


def metric_entries() -> list[dict[str, Any]]:
    """Returns the metrics, those of Table I of HuNavSim first."""
    paper = {metric.name for metric in select_metrics(["paper"])}
    return [
        {
            "name": metric.name,
            "family": metric.family,
            "unit": metric.unit,
            "direction": metric.direction,
            "source": metric.source,
            "definition": metric.definition,
            "aliases": list(metric.aliases),
            "paper": metric.name in paper,
        }
        for metric in select_metrics(["all"])
        if metric.name in METRICS
    ]


def _choices(base: Any) -> list[dict[str, Any]]:
    """Returns the registered choices of a kind."""
    registry: Registry = base.__registry__
    return [
        {
            "name": name,
            "help": (inspect.getdoc(choice) or "").partition("\n")[0],
            "parameters": TypeAdapter(choice).json_schema(),
        }
        for name, choice in registry.items()
    ]


def _letters(name: str) -> str:
    """Returns one letter, or two where others begin with it, too."""
    others = [other for other in BEHAVIORS if other != name]
    is_first = any(other[:1] == name[:1] for other in others)
    return name[: 1 + is_first].capitalize()


def _sentence(comments: list[str]) -> str:
    """Returns the comment at the head of a file, in one line."""
    return " ".join(comments[0].split()) if comments else ""


def _value(kind: str, text: str | None) -> Any:
    """Returns the default of a port as a scenario would give it."""
    if text is None or kind == "string":
        return text
    try:
        return json.loads(text)
    except ValueError:
        return text


def _words_about(port: str, function: Any) -> str:
    """Returns the sentence of a leaf's documentation that names a port."""
    text = " ".join((inspect.getdoc(function) or "").split())
    for sentence in re.split(r"(?<=[.;]) ", text):
        if f"`{port}`" in sentence:
            return sentence.replace("`", "")
    return ""


def _whole_picture(svg: str) -> str:
    """Returns an SVG of Graphviz without what comes before its element."""
    return svg[svg.index("<svg") :]
