"""Scripts, and what halting a node does; compiled by numba."""

from numba import void
import numpy as np

from hunav_drake.systems.behavior.nodes import operations as op
from hunav_drake.systems.behavior.nodes.pointers import (
    integers_at,
    numbers_at,
    record_at,
)
from hunav_drake.systems.behavior.nodes.port import UNSET
from hunav_drake.systems.behavior.nodes.table import ROW, SLOT, STEP
from hunav_drake.systems.behavior.nodes.tick import TICK_RECORD
from hunav_drake.systems.common.kernels import INTEGER, REAL, jit_part, part_as

# The largest number of values on the stack of a script, which may be nested
# 20 deep.
STACK_SIZE = 64

# Why a walk was interrupted: to run a leaf in Python; to read ports in Python;
# to compile a leaf; and because a script reads an entry that nothing has set.
RUN_LEAF, READ_PORTS, COMPILE_LEAF, UNSET_ENTRY = 1, 2, 3, 4


@jit_part
def row_at(tick, row):
    """Returns a row of the tree, perhaps the one after the last: see `Row`."""
    return record_at(tick.rows, row, ROW)


@part_as(void, TICK_RECORD, INTEGER, INTEGER, INTEGER)
def interrupt(tick, row, code, slot):
    """Notes why, and at which node and slot, the walk cannot go on."""
    if tick.code == 0:
        tick.code = code
        tick.row = row
        tick.slot = slot


@part_as(REAL, TICK_RECORD, INTEGER, INTEGER)
def run_script(tick, row, script):
    """Runs a script of a node, and returns its last value.

    If an entry is not set, it interrupts the walk.
    """
    memory = numbers_at(tick.memory)
    stack = numbers_at(tick.stack)
    # The place of the last value on the stack.
    top = -1
    at = script
    while True:
        step = record_at(tick.steps, at, STEP)
        code, value = step.code, step.value
        at += 1
        if code < 0:
            break
        if code == op.NUMBER:
            top += 1
            stack[top] = value
        elif code == op.ENTRY:
            top += 1
            stack[top] = memory[np.int64(value)]
            if stack[top] == UNSET:
                interrupt(tick, row, UNSET_ENTRY, np.int64(value))
                return 0.0
        elif code == op.NOT:
            stack[top] = stack[top] == 0
        elif code == op.TRUTH:
            stack[top] = stack[top] != 0
        elif code in (op.AND, op.OR):
            if (stack[top] != 0) == (code == op.OR):
                at += np.int64(value)
            else:
                top -= 1
        elif code == op.ASSIGN:
            memory[np.int64(value)] = stack[top]
            top -= 1
        else:
            left = stack[top - 1]
            right = stack[top]
            top -= 1
            if code == op.LESS:
                stack[top] = left < right
            elif code == op.AT_MOST:
                stack[top] = left <= right
            elif code == op.GREATER:
                stack[top] = left > right
            elif code == op.AT_LEAST:
                stack[top] = left >= right
            elif code == op.EQUAL:
                stack[top] = left == right
            else:
                stack[top] = left != right
    return stack[top] if top >= 0 else 0.0


@part_as(void, TICK_RECORD, INTEGER, INTEGER)
def halt(tick, begin, end):
    """Halts the nodes from one row up to another, as far as they run.

    It runs the scripts `_onHalted`, first those of the nodes below, and resets
    the numbers that do not outlive a halt.
    """
    memory = numbers_at(tick.memory)
    for i in range(tick.num_halted):
        row = integers_at(tick.halted)[i]
        node = row_at(tick, row)
        if begin <= row < end and memory[node.begun] != 0:
            memory[node.begun] = 0.0
            run_script(tick, row, node.on_halted)
    # (Backwards: the flag of a leaf is the first of its numbers.)
    first = row_at(tick, begin).slots
    for i in range(row_at(tick, end).slots - 1, first - 1, -1):
        slot = record_at(tick.slots, i, SLOT)
        if slot.flag >= 0 and memory[slot.flag] != 0:
            memory[i] = slot.initial
