"""Makes nodes of the functions that leaves are."""

from collections.abc import Callable
from typing import Any

import numpy as np

from hunav_drake.systems.behavior.errors import BehaviorTreeError
from hunav_drake.systems.behavior.nodes.node import (
    Built,
    Constant,
    HaltFunction,
    Memory,
    Node,
)
from hunav_drake.systems.behavior.nodes.sequences import (
    FAILURE,
    RUNNING,
    SUCCESS,
)
from hunav_drake.systems.behavior.nodes.status import Status
from hunav_drake.systems.behavior.tick_context import Moment

# The first slot of an action that remembers: whether it runs.
RUNNING_SLOT = "(running)"


def _is_plain(node: Node) -> bool:
    """Tells whether a leaf needs the moment only: the usual, fastest case."""
    return not node.slots and all(
        isinstance(value, Constant)
        and value.value == node.type.ports[name].default
        for name, value in node.ports.items()
    )


def build_leaf(
    function: Callable[..., Any], node: Node, children: tuple[Built, ...]
) -> Built:
    """Makes the functions of a leaf from the function that it is.

    Args:
        function: Takes the moment, its memory if it has one, and its ports.
        node: The leaf.
        children: None.
    """
    call = _with_ports(function, node)
    plain = _is_plain(node)
    if node.type.category == "Condition":

        def check(memory: Memory, moment: Moment) -> Status:
            try:
                holds = function(moment) if plain else call(memory, moment)
            except Exception as error:
                raise _located(error, node) from _cause(error)
            if holds is True:
                return SUCCESS
            return FAILURE if holds is False else _truth(holds, node)

        return Built(check)

    def act(memory: Memory, moment: Moment) -> Status:
        try:
            status = function(moment) if plain else call(memory, moment)
        except Exception as error:
            raise _located(error, node) from _cause(error)
        if status is None:
            return SUCCESS
        if status is SUCCESS or status is RUNNING or status is FAILURE:
            result: Status = status
            return result
        raise TypeError(
            f"{node.place}: action {node.type.name} must return"
            " Status.SUCCESS, FAILURE, RUNNING or None (which is SUCCESS), got"
            f" {status!r}"
        )

    if not node.slots:
        return Built(act)
    running = node.slot(RUNNING_SLOT)

    def note_running(memory: Memory, moment: Moment) -> Status:
        status = act(memory, moment)
        memory[running] = 1.0 if status is RUNNING else 0.0
        return status

    return Built(note_running, _leaf_halt(node, running))


def _truth(holds: Any, node: Node) -> Status:
    """Returns what a condition means that returns no plain truth.

    Raises:
        TypeError: If it returns none at all.
    """
    if isinstance(holds, np.bool_):
        return SUCCESS if holds else FAILURE
    if holds is SUCCESS or holds is FAILURE:
        result: Status = holds
        return result
    raise TypeError(
        f"{node.place}: condition {node.type.name} must return True, False,"
        f" Status.SUCCESS or FAILURE, got {holds!r}"
    )


def _located(error: Exception, node: Node) -> BehaviorTreeError:
    """Returns the error of a leaf with the leaf's place."""
    if isinstance(error, BehaviorTreeError):
        return error
    return node.error(f"{type(error).__name__}: {error}")


def _cause(error: Exception) -> BaseException | None:
    """Returns what an error with its place comes from."""
    return error.__cause__ if isinstance(error, BehaviorTreeError) else error


def _leaf_halt(node: Node, running: int) -> HaltFunction:
    begin, end = node.first, node.first + len(node.slots)
    initial = list(node.type.slots.values())

    def halt(memory: Memory) -> None:
        if memory[running]:
            memory[begin:end] = initial

    return halt


def _with_ports(
    function: Callable[..., Any], node: Node
) -> Callable[[Memory, Moment], Any]:
    """Returns the function with its memory and its ports put in."""
    ports = node.type.ports
    constants = {
        name: value.value
        for name, value in node.ports.items()
        if isinstance(value, Constant) and value.value != ports[name].default
    }
    variables = {
        name: node.reader(name)
        for name, value in node.ports.items()
        if not isinstance(value, Constant)
    }
    begin, end = node.first, node.first + len(node.slots)
    if node.slots[:1] == (RUNNING_SLOT,):
        begin += 1
    if begin == end:
        if not variables:
            return lambda memory, moment: function(moment, **constants)

        def call(memory: Memory, moment: Moment) -> Any:
            values = {name: read(memory) for name, read in variables.items()}
            return function(moment, **constants, **values)

        return call

    def call_with_memory(memory: Memory, moment: Moment) -> Any:
        values = constants
        if variables:
            values = dict(constants)
            for name, read in variables.items():
                values[name] = read(memory)
        own = memory[begin:end]
        result = function(moment, own, **values)
        if len(own) != end - begin:
            raise node.error(
                f"it must keep {end - begin} numbers of memory, left {len(own)}"
            )
        memory[begin:end] = own
        return result

    return call_with_memory
