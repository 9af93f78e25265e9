"""Checks that a leaf in Python has written valid numbers."""

from collections.abc import Sequence
import math
import numbers
from typing import Any

import numpy as np

from hunav_drake.systems.behavior.nodes.node import Node
from hunav_drake.systems.behavior.nodes.tick_context import (
    MAX_BEHAVIOR_STATUS,
    TickContext,
)
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    Command,
    Hold,
    RobotRole,
)

_NOT_NEGATIVE = (
    Command.DESIRED_SPEED,
    Command.MAX_SPEED,
    Command.GOAL_RADIUS,
    Command.TURN_RATE,
)
_ROLES = frozenset(float(role) for role in RobotRole)
_HOLDS = frozenset(float(hold) for hold in Hold)


def check_written(
    node: Node,
    context: TickContext,
    memory: Sequence[float],
    before: tuple[list[float], int],
) -> None:
    """Checks what a leaf in Python has written.

    Args:
        node: The leaf.
        context: Its tick context.
        memory: The memory of the tree.
        before: The command and the behavior status before it.

    Raises:
        BehaviorTreeError: At the first number that is invalid.
    """
    own = slice(node.first, node.first + len(node.slots))
    names = [f"{node.name}: {slot}" for slot in node.slots]
    written = context.command, context.behavior_status
    if not names and _are_equal(written, before):
        return
    fault = _find_fault(context, memory[own], names)
    if fault:
        raise node.error(fault)


def _are_equal(one: Any, other: Any) -> bool:
    try:
        return bool(one == other)
    except ValueError:
        # Arrays of several numbers.
        return False


def _find_fault(
    context: TickContext, memory: Sequence[float], slots: Sequence[str]
) -> str:
    """Returns a message about the first invalid number that a tick left.

    It is empty if there is none. The slots name the numbers of the memory.
    """
    command = context.command
    if len(command) != COMMAND_SIZE:
        return f"a command has {COMMAND_SIZE} numbers, got {len(command)}"
    for name, value in zip(Command, command, strict=True):
        what = f"command[Command.{name.name}]"
        if not _is_number(value) or not math.isfinite(value):
            return f"{what} must be a finite number, got {value!r}"
        if name in _NOT_NEGATIVE and value < 0:
            return f"{what} must be at least 0, got {value!r}"
        if name is Command.ROBOT_ROLE and value not in _ROLES:
            return f"{what} must be a RobotRole, got {value!r}"
        if name is Command.HAS_GOAL and value not in (0, 1):
            return f"{what} must be 0 or 1, got {value!r}"
        if name is Command.HOLD and value not in _HOLDS:
            return f"{what} must be a Hold, got {value!r}"
        if name is Command.GROUP_ID and value % 1 != 0:
            return f"{what} must be a whole number, got {value!r}"
    status = context.behavior_status
    if (
        not _is_number(status)
        or not 0 <= status <= MAX_BEHAVIOR_STATUS
        or status % 1 != 0
    ):
        return (
            f"behavior_status must be in [0, {MAX_BEHAVIOR_STATUS}], a whole"
            f" number, got {status!r}"
        )
    # (Infinity may mean "nothing yet" to a leaf, and does to the blackboard.)
    for slot, value in zip(slots, memory, strict=False):
        if not _is_number(value) or math.isnan(value):
            return f"memory {slot!r} must be a number, got {value!r}"
    return ""


def _is_number(value: Any) -> bool:
    return isinstance(value, numbers.Real | np.bool_)
