"""The actions of the tree language itself: they do not concern the person."""

from typing import Annotated

from pydantic import BeforeValidator

from hunav_drake.systems.behavior.node import (
    UNSET,
    BuildFunction,
    Built,
    Constant,
    Memory,
    Node,
    NodeType,
    Port,
    Variable,
)
from hunav_drake.systems.behavior.person import Moment
from hunav_drake.systems.behavior.sequences import FAILURE, SUCCESS
from hunav_drake.systems.behavior.status import Status

_TRUTHS = {"true": 1.0, "false": 0.0}


def _number(value: object) -> object:
    """Takes the words for truth for the numbers that stand for them."""
    if isinstance(value, str):
        return _TRUTHS.get(value.strip().lower(), value)
    return value


Number = Annotated[float, BeforeValidator(_number)]


def _always(status: Status) -> BuildFunction:
    def build(node: Node, children: tuple[Built, ...]) -> Built:
        return Built(lambda memory, moment: status)

    return build


def _set_blackboard(node: Node, children: tuple[Built, ...]) -> Built:
    target = node.ports["output_key"]
    if not isinstance(target, Variable):
        raise node.error("port output_key: must name a blackboard entry")
    slot = target.slot
    source = node.ports["value"]
    if isinstance(source, Constant):
        number = float(source.value)

        def set_constant(memory: Memory, moment: Moment) -> Status:
            memory[slot] = number
            return SUCCESS

        return Built(set_constant)
    source_slot = source.slot

    def copy(memory: Memory, moment: Moment) -> Status:
        if memory[source_slot] == UNSET:
            return FAILURE
        memory[slot] = memory[source_slot]
        return SUCCESS

    return Built(copy)


LANGUAGE_ACTIONS = (
    NodeType("AlwaysSuccess", "Action", _always(SUCCESS), "Succeeds."),
    NodeType("AlwaysFailure", "Action", _always(FAILURE), "Fails."),
    NodeType(
        "SetBlackboard",
        "Action",
        _set_blackboard,
        "Sets a blackboard entry to a number, a truth or another entry.",
        ports={
            "value": Port("value", Number),
            "output_key": Port("output_key", Number, output=True),
        },
    ),
)
