"""AlwaysSuccess, AlwaysFailure and SetBlackboard, as in BehaviorTree.CPP."""

from typing import Any

from hunav_drake.systems.behavior.nodes.node import (
    FAILURE,
    SUCCESS,
    BuildFunction,
    Built,
    Memory,
    Node,
    NodeStatus,
    NodeType,
)
from hunav_drake.systems.behavior.nodes.port import UNSET, Port, Variable
from hunav_drake.systems.behavior.nodes.tick_context import TickContext


def _always(status: NodeStatus) -> BuildFunction:
    def build(node: Node, children: tuple[Built, ...]) -> Built:
        return Built(lambda memory, context: status)

    return build


def _set_blackboard(node: Node, children: tuple[Built, ...]) -> Built:
    target = node.ports["output_key"]
    if not isinstance(target, Variable):
        raise node.error("port output_key: must name a blackboard entry")
    slot = target.slot
    read = node.number_reader("value")

    def set_entry(memory: Memory, context: TickContext) -> NodeStatus:
        value = read(memory)
        if value == UNSET:
            return FAILURE
        memory[slot] = value
        return SUCCESS

    return Built(set_entry)


BUILTIN_ACTIONS = (
    NodeType("AlwaysSuccess", "Action", _always(SUCCESS), "Succeeds."),
    NodeType("AlwaysFailure", "Action", _always(FAILURE), "Fails."),
    NodeType(
        "SetBlackboard",
        "Action",
        _set_blackboard,
        "Sets a blackboard entry to a number, boolean, text or other entry.",
        ports={
            "value": Port("value", Any),
            "output_key": Port("output_key", Any, output=True),
        },
    ),
)
