"""Scripts, and what halting a node does; compiled by numba."""

from numba import void
import numpy as np

from hunav_drake.systems.behavior.nodes.operations import (
    AND,
    ASSIGN,
    AT_LEAST,
    AT_MOST,
    ENTRY,
    EQUAL,
    GREATER,
    LESS,
    NOT,
    NUMBER,
    OR,
    TRUTH,
)
from hunav_drake.systems.behavior.nodes.pointers import array_at
from hunav_drake.systems.behavior.nodes.port import UNSET
from hunav_drake.systems.behavior.nodes.table import ROW, SLOT, STEP
from hunav_drake.systems.behavior.nodes.tick import TICK_RECORD
from hunav_drake.systems.common.kernels import INTEGER, REAL, jit_as, jit_inline

# The largest number of values on the stack of a script, which may be nested
# 20 deep.
STACK_SIZE = 64

# Why a walk was interrupted: to run a leaf in Python; to read ports in Python;
# to compile a leaf; and because a script reads an entry that nothing has set.
RUN_LEAF, READ_PORTS, COMPILE_LEAF, UNSET_ENTRY = 1, 2, 3, 4

_REAL = np.dtype(np.float64)
_INTEGER = np.dtype(np.int64)


@jit_inline
def rows_of(tick):
    """Returns the rows of the tree, and one more: see `Row`."""
    return array_at(tick.rows, tick.num_rows + 1, ROW)


@jit_inline
def memory_of(tick):
    """Returns the person's memory."""
    return array_at(tick.memory, tick.num_slots, _REAL)


@jit_as(void, TICK_RECORD, INTEGER, INTEGER, INTEGER)
def interrupt(tick, row, code, slot):
    """Notes why, and at which node and slot, the walk cannot go on."""
    if tick.code == 0:
        tick.code = code
        tick.row = row
        tick.slot = slot


@jit_as(REAL, TICK_RECORD, INTEGER, INTEGER)
def run_script(tick, row, script):
    """Runs a script of a node, and returns its last value.

    If an entry is not set, it interrupts the walk.
    """
    memory = memory_of(tick)
    steps = array_at(tick.steps, tick.num_steps, STEP)
    stack = array_at(tick.stack, STACK_SIZE, _REAL)
    # The place of the last value on the stack.
    top = -1
    at = script
    while steps[at].code >= 0:
        code = steps[at].code
        value = steps[at].value
        at += 1
        if code == NUMBER:
            top += 1
            stack[top] = value
        elif code == ENTRY:
            top += 1
            stack[top] = memory[np.int64(value)]
            if stack[top] == UNSET:
                interrupt(tick, row, UNSET_ENTRY, np.int64(value))
                return 0.0
        elif code == NOT:
            stack[top] = stack[top] == 0
        elif code == TRUTH:
            stack[top] = stack[top] != 0
        elif code in (AND, OR):
            if (stack[top] != 0) == (code == OR):
                at += np.int64(value)
            else:
                top -= 1
        elif code == ASSIGN:
            memory[np.int64(value)] = stack[top]
            top -= 1
        else:
            left = stack[top - 1]
            right = stack[top]
            top -= 1
            if code == LESS:
                stack[top] = left < right
            elif code == AT_MOST:
                stack[top] = left <= right
            elif code == GREATER:
                stack[top] = left > right
            elif code == AT_LEAST:
                stack[top] = left >= right
            elif code == EQUAL:
                stack[top] = left == right
            else:
                stack[top] = left != right
    return stack[top] if top >= 0 else 0.0


@jit_as(void, TICK_RECORD, INTEGER, INTEGER)
def halt(tick, begin, end):
    """Halts the nodes from one row up to another, as far as they run.

    It runs the scripts `_onHalted`, first those of the nodes below, and resets
    the numbers that do not outlive a halt.
    """
    rows = rows_of(tick)
    memory = memory_of(tick)
    for row in array_at(tick.halted, tick.num_halted, _INTEGER):
        begun = rows[row].begun
        if begin <= row < end and memory[begun] != 0:
            memory[begun] = 0.0
            run_script(tick, row, rows[row].on_halted)
    slots = array_at(tick.slots, tick.num_slots, SLOT)
    # (Backwards: the flag of a leaf is the first of its numbers.)
    for i in range(rows[end].slots - 1, rows[begin].slots - 1, -1):
        flag = slots[i].flag
        if flag >= 0 and memory[flag] != 0:
            memory[i] = slots[i].initial
