"""Checks after each tick that leaves have written valid numbers."""

from collections.abc import Iterable, Sequence
import math
import numbers
from typing import Any

import numpy as np

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

# The usual types of numbers; others are checked in detail.
_PLAIN = frozenset({float, int, bool, np.float64})


def is_sound(context: TickContext, memory: Sequence[float]) -> bool:
    """Returns quickly whether a tick left all valid; else see `find_fault`."""
    command = context.command
    try:
        # Nothing adds up to a finite number with infinity or NaN in it.
        total = sum(command)
        kept = sum(memory)
        return (
            len(command) == COMMAND_SIZE
            and _are_plain(command)
            and _are_plain(memory)
            and total - total == 0
            and kept == kept
            and command[Command.ROBOT_ROLE] in _ROLES
            and command[Command.DESIRED_SPEED] >= 0
            and command[Command.MAX_SPEED] >= 0
            and command[Command.GOAL_RADIUS] >= 0
            and command[Command.TURN_RATE] >= 0
            and command[Command.HAS_GOAL] in (0, 1)
            and command[Command.HOLD] in _HOLDS
            and command[Command.GROUP_ID] % 1 == 0
            and type(context.behavior_status) in _PLAIN
            and 0 <= context.behavior_status <= MAX_BEHAVIOR_STATUS
            and context.behavior_status % 1 == 0
        )
    except (TypeError, ValueError):
        return False


def find_fault(
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


def _are_plain(values: Iterable[Any]) -> bool:
    return _PLAIN.issuperset(map(type, values))


def _is_number(value: Any) -> bool:
    return isinstance(value, numbers.Real | np.bool_)
