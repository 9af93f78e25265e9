"""Builds the tick function of a leaf from its Python function."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from hunav_drake.systems.behavior.nodes.errors import BehaviorTreeError
from hunav_drake.systems.behavior.nodes.node import (
    FAILURE,
    RUNNING,
    SUCCESS,
    Built,
    HaltFunction,
    Memory,
    Node,
    NodeStatus,
)
from hunav_drake.systems.behavior.nodes.port import Constant
from hunav_drake.systems.behavior.nodes.tick_context import TickContext

# The first slot of an action that remembers: 1 while it runs.
RUNNING_SLOT = "(running)"


def _bound(function: Callable[..., Any], node: Node) -> Callable[..., Any]:
    """Returns a leaf's function with the ports that are constants."""
    constants = {
        name: value.value
        for name, value in node.ports.items()
        if isinstance(value, Constant)
        and value.value != node.type.ports[name].default
    }
    return partial(function, **constants) if constants else function


def _failed(node: Node, error: Exception) -> BehaviorTreeError:
    """Returns the error for one that a leaf's function raised."""
    return node.error(f"{type(error).__name__}: {error}")


def build_leaf(
    function: Callable[..., Any], node: Node, children: tuple[Built, ...]
) -> Built:
    """Builds a leaf from its Python function.

    The function takes the tick context, its memory if it has one, and its
    ports. There are no children.
    """
    bound = _bound(function, node)
    call = _with_memory(bound, node)

    if node.type.category == "Condition":

        def check(memory: Memory, context: TickContext) -> NodeStatus:
            try:
                holds = call(memory, context) if call else bound(context)
            except BehaviorTreeError:
                raise
            except Exception as error:
                raise _failed(node, error) from error
            if holds is True:
                return SUCCESS
            return FAILURE if holds is False else _condition_status(holds, node)

        return Built(check)

    def act(memory: Memory, context: TickContext) -> NodeStatus:
        try:
            status = call(memory, context) if call else bound(context)
        except BehaviorTreeError:
            raise
        except Exception as error:
            raise _failed(node, error) from error
        if status is None:
            return SUCCESS
        if status is SUCCESS or status is RUNNING or status is FAILURE:
            result: NodeStatus = status
            return result
        raise TypeError(
            f"{node.place}: action {node.type.name} must return"
            " NodeStatus.SUCCESS, FAILURE, RUNNING or None (which is SUCCESS),"
            f" got {status!r}"
        )

    if not node.slots:
        return Built(act)
    running = node.slot(RUNNING_SLOT)

    def note_running(memory: Memory, context: TickContext) -> NodeStatus:
        status = act(memory, context)
        memory[running] = 1.0 if status is RUNNING else 0.0
        return status

    return Built(note_running, _leaf_halt(node, running))


def _condition_status(holds: Any, node: Node) -> NodeStatus:
    """Returns the status for a condition's result that is not True or False."""
    if isinstance(holds, np.bool_):
        return SUCCESS if holds else FAILURE
    if holds is SUCCESS or holds is FAILURE:
        result: NodeStatus = holds
        return result
    raise TypeError(
        f"{node.place}: condition {node.type.name} must return True, False,"
        f" NodeStatus.SUCCESS or FAILURE, got {holds!r}"
    )


def _leaf_halt(node: Node, running: int) -> HaltFunction:
    begin, end = node.first, node.first + len(node.slots)
    initial = list(node.type.slots.values())

    def halt(memory: Memory) -> None:
        if memory[running]:
            memory[begin:end] = initial

    return halt


def _with_memory(
    function: Callable[..., Any], node: Node
) -> Callable[[Memory, TickContext], Any] | None:
    """Returns a leaf's function with its memory and the variable ports.

    None if it has neither: the function takes the context only.
    """
    variables = {
        name: node.reader(name)
        for name, value in node.ports.items()
        if not isinstance(value, Constant)
    }
    begin, end = node.first, node.first + len(node.slots)
    if node.slots[:1] == (RUNNING_SLOT,):
        begin += 1
    if begin == end and not variables:
        return None

    nothing: dict[str, Any] = {}

    def call(memory: Memory, context: TickContext) -> Any:
        values = nothing
        if variables:
            values = {name: read(memory) for name, read in variables.items()}
        if begin == end:
            return function(context, **values)
        own = memory[begin:end]
        result = function(context, own, **values)
        if len(own) != end - begin:
            raise node.error(
                f"it must keep {end - begin} numbers of memory, left {len(own)}"
            )
        memory[begin:end] = own
        return result

    return call
