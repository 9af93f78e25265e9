"""Behavior trees of people: their language, and their nodes."""

from hunav_drake.systems.behavior.behavior_tree import BehaviorTree
from hunav_drake.systems.behavior.fingerprint import tree_fingerprint
from hunav_drake.systems.behavior.language.tree_ports import (
    TreePort,
    TreePortError,
)
from hunav_drake.systems.behavior.library import (
    ACTIVITIES,
    BEHAVIORS,
    CheckBehavior,
    LoadBehavior,
    LoadBehaviors,
    LoadTree,
    ParseTree,
)
from hunav_drake.systems.behavior.nodes.errors import BehaviorTreeError
from hunav_drake.systems.behavior.nodes.port import Meaning
from hunav_drake.systems.behavior.nodes.registry import (
    NODE_TYPES,
    register_action,
    register_condition,
)
from hunav_drake.systems.behavior.nodes.status import NodeStatus
from hunav_drake.systems.behavior.nodes.texts import text_code
from hunav_drake.systems.behavior.nodes.tick_context import Person, TickContext
from hunav_drake.systems.behavior.render import RenderBehaviorTree, TreeDrawing
from hunav_drake.systems.behavior.society import SocialOptions
from hunav_drake.systems.behavior.tree import Outcome, Tree
from hunav_drake.systems.behavior.writer import ConvertTree, WriteTree
from hunav_drake.systems.people.behavior_choice import BehaviorConfig

__all__ = [
    "ACTIVITIES",
    "BEHAVIORS",
    "NODE_TYPES",
    "BehaviorConfig",
    "BehaviorTree",
    "BehaviorTreeError",
    "CheckBehavior",
    "ConvertTree",
    "LoadBehavior",
    "LoadBehaviors",
    "LoadTree",
    "Meaning",
    "NodeStatus",
    "Outcome",
    "ParseTree",
    "Person",
    "RenderBehaviorTree",
    "SocialOptions",
    "TickContext",
    "Tree",
    "TreeDrawing",
    "TreePort",
    "TreePortError",
    "WriteTree",
    "register_action",
    "register_condition",
    "text_code",
    "tree_fingerprint",
]
