"""The choices of a scenario, for the forms of the editor."""

import inspect
import shutil
from typing import Any

from hunav_drake.report.plots.style import PALETTE, robot_styles
from hunav_drake.scenario.json_schema import (
    described_schema,
    scenario_json_schema,
)
from hunav_drake.systems.behavior import (
    ACTIVITIES,
    BEHAVIORS,
    LoadTree,
    RenderBehaviorTree,
)
from hunav_drake.systems.behavior.port_words import port_entries
from hunav_drake.systems.behavior.tree import Tree
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.crowd.motion_model import MotionModel
from hunav_drake.systems.evaluation.metrics import METRICS, select_metrics
from hunav_drake.systems.planning.planner import PlannerConfig
from hunav_drake.systems.robot.robot_config import RobotConfig
from hunav_drake.systems.scene.palette import ROBOT_ACCENTS

# The color of each behavior: those of the plots, but grays instead of black,
# which would be invisible on a dark map.
_COLORS = dict(
    zip(BEHAVIORS, (*PALETTE[:6], "#6b6b6b", "#a3a3a3"), strict=True)
)
_GRAY = "#7f7f7f"


def make_catalog() -> dict[str, Any]:
    """Returns the message with all choices, including those of users."""
    return {
        "kind": "catalog",
        "schema": scenario_json_schema(),
        "behaviors": behavior_entries(),
        "planners": _choices(PlannerConfig),
        "models": _choices(MotionModel),
        "robots": _choices(RobotConfig),
        "robot_colors": [
            it["color"] for it in robot_styles(len(ROBOT_ACCENTS))
        ],
        "metrics": metric_entries(),
        "ready": True,
    }


def behavior_entries() -> list[dict[str, Any]]:
    """Returns the behaviors of people."""
    return [
        behavior_entry(name, LoadTree(name), _COLORS.get(name, _GRAY))
        for name in (*BEHAVIORS, *ACTIVITIES)
    ]


def behavior_entry(name: str, tree: Tree, color: str) -> dict[str, Any]:
    """Returns a behavior: its description, its ports and its picture.

    Args:
        name: Its name in scenarios.
        tree: Its tree.
        color: The color of people with this behavior.
    """
    drawing = RenderBehaviorTree(tree)
    picture = None
    if shutil.which("dot") is not None:
        svg = drawing.graph().create(format="svg", encoding="utf-8")
        text = svg.decode()
        # Without the header of Graphviz.
        picture = text[text.index("<svg") :]
    return {
        "name": name,
        "help": " ".join(" ".join(tree.documents.comments[:1]).split()),
        "letter": _letters(name),
        "color": color,
        "ports": port_entries(tree),
        "picture": picture,
        "drawing": drawing.text,
    }


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
            "parameters": described_schema(choice),
        }
        for name, choice in registry.items()
    ]


def _letters(name: str) -> str:
    """Returns one letter, or two if another behavior has the same."""
    others = [it for it in (*BEHAVIORS, *ACTIVITIES) if it != name]
    is_first = any(other[:1] == name[:1] for other in others)
    return name[: 1 + is_first].capitalize()
