"""Builds what ticks a leaf in Python from its function."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from hunav_drake.systems.behavior.nodes.errors import BehaviorTreeError
from hunav_drake.systems.behavior.nodes.node import LeafFunction, Memory, Node
from hunav_drake.systems.behavior.nodes.port import Constant
from hunav_drake.systems.behavior.nodes.program import RUNNING_SLOT
from hunav_drake.systems.behavior.nodes.status import (
    FAILURE,
    RUNNING,
    SUCCESS,
    NodeStatus,
)
from hunav_drake.systems.behavior.nodes.tick_context import TickContext


def build_leaf(function: Callable[..., Any], node: Node) -> LeafFunction:
    """Builds a leaf from its Python function.

    The function takes the tick context, its memory if it has one, and its
    ports.
    """
    is_condition = node.type.category == "Condition"
    status_of = _condition_status if is_condition else _action_status
    constants = {
        name: value.value
        for name, value in node.ports.items()
        if isinstance(value, Constant)
    }
    variables = [name for name in node.ports if name not in constants]
    bound = partial(function, **constants)
    begin, end = node.first, node.first + len(node.slots)
    begin += node.slots[:1] == (RUNNING_SLOT,)

    def tick(context: TickContext, memory: Memory) -> NodeStatus:
        values = {name: node.read(name, memory) for name in variables}
        own = memory[begin:end]
        try:
            remembered = (own,) if own else ()
            result = bound(context, *remembered, **values)
        except BehaviorTreeError:
            raise
        except Exception as error:
            raise node.error(f"{type(error).__name__}: {error}") from error
        if len(own) != end - begin:
            raise node.error(
                f"it must keep {end - begin} numbers of memory, left {len(own)}"
            )
        memory[begin:end] = own
        return status_of(result, node)

    return tick


def _action_status(result: Any, node: Node) -> NodeStatus:
    if result is None:
        return SUCCESS
    if result is SUCCESS or result is RUNNING or result is FAILURE:
        status: NodeStatus = result
        return status
    raise TypeError(
        f"{node.place}: action {node.type.name} must return"
        " NodeStatus.SUCCESS, FAILURE, RUNNING or None (which is SUCCESS),"
        f" got {result!r}"
    )


def _condition_status(result: Any, node: Node) -> NodeStatus:
    if isinstance(result, bool | np.bool_):
        return SUCCESS if result else FAILURE
    if result is SUCCESS or result is FAILURE:
        status: NodeStatus = result
        return status
    raise TypeError(
        f"{node.place}: condition {node.type.name} must return True, False,"
        f" NodeStatus.SUCCESS or FAILURE, got {result!r}"
    )
