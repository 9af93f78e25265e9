"""What people do: behavior trees, their language, and their nodes."""

from hunav_drake.systems.behavior.behavior_tree import BehaviorTree
from hunav_drake.systems.behavior.errors import BehaviorTreeError
from hunav_drake.systems.behavior.library import BEHAVIORS, LoadTree, ParseTree
from hunav_drake.systems.behavior.person import Moment, Person
from hunav_drake.systems.behavior.registry import (
    NODE_TYPES,
    register_action,
    register_condition,
)
from hunav_drake.systems.behavior.status import Status
from hunav_drake.systems.behavior.tree import Outcome, Tree

__all__ = [
    "BEHAVIORS",
    "NODE_TYPES",
    "BehaviorTree",
    "BehaviorTreeError",
    "LoadTree",
    "Moment",
    "Outcome",
    "ParseTree",
    "Person",
    "Status",
    "Tree",
    "register_action",
    "register_condition",
]
