"""What nodes do when they are ticked, and when a child has been; compiled.

They work as in BehaviorTree.CPP. A node's memory is zero unless it is RUNNING,
with the exceptions that BehaviorTree.CPP makes. Each function returns the row
of the child to tick, or the status of the node with a minus, or 0 if the walk
is interrupted.
"""

from numba import void
import numpy as np

from hunav_drake.systems.behavior.nodes import operations as op
from hunav_drake.systems.behavior.nodes.pointers import (
    call_leaf,
    integers_at,
    numbers_at,
    record_at,
)
from hunav_drake.systems.behavior.nodes.port import UNSET
from hunav_drake.systems.behavior.nodes.scripts import (
    COMPILE_LEAF,
    READ_PORTS,
    RUN_LEAF,
    halt,
    interrupt,
    row_at,
)
from hunav_drake.systems.behavior.nodes.social import queue_length
from hunav_drake.systems.behavior.nodes.status import NodeStatus
from hunav_drake.systems.behavior.nodes.table import PORT
from hunav_drake.systems.behavior.nodes.tick import TICK_RECORD
from hunav_drake.systems.common.kernels import INTEGER, jit_part, part_as

# (Compiled code knows them as numbers.)
IDLE, RUNNING, SUCCESS, FAILURE, SKIPPED = map(int, NodeStatus)

# The number of times that Repeat and RetryUntilSuccessful tick a child that
# completes at once, before they leave the rest to the next tick.
MAX_CYCLES_PER_TICK = 100

# The numbers that each node keeps for the time of a tick.
SCRATCH_SIZE = 4


@jit_part
def steps_reach(steps, time_step, seconds):
    """Returns whether a number of steps lasts at least a duration.

    A multiple of the step that misses the duration by rounding alone has
    reached it.
    """
    return steps * time_step >= seconds * (1 - 1e-12)


@jit_part
def steps_of(seconds, time_step):
    """Returns the least number of steps that lasts at least a duration."""
    steps = np.int64(seconds / time_step)
    while not steps_reach(steps, time_step, seconds):
        steps += 1
    return steps


@part_as(INTEGER, TICK_RECORD, INTEGER, INTEGER)
def _child(tick, row, index):
    """Returns the row of a child; 0 after the last one."""
    if index >= row_at(tick, row).children:
        return 0
    child = row + 1
    for _ in range(index):
        child = row_at(tick, child).end
    return child


@jit_part
def _following(tick, node, child):
    """Returns the row of the child after one; 0 after the last one."""
    following = row_at(tick, child).end
    return following if following < node.end else 0


@jit_part
def _scratch(tick, row):
    return integers_at(tick.scratch + 8 * SCRATCH_SIZE * row)


@jit_part
def _tidy(tick, row):
    """Halts the children of a node that completes while none runs.

    Only nodes that count can have left something, when they were skipped.
    """
    node = row_at(tick, row)
    if node.counts:
        halt(tick, row + 1, node.end)


@jit_part
def _number(tick, node, port):
    """Returns the number of a port that takes any entry, perhaps UNSET."""
    slot = record_at(tick.ports, node.first_port + port, PORT).slot
    if slot >= 0:
        return numbers_at(tick.memory)[slot]
    return numbers_at(tick.numbers)[node.first_port + port]


@jit_part
def _read_ports(tick, node):
    """Reads the ports; returns whether all that are entries surely fit."""
    values = numbers_at(tick.values)
    for i in range(node.num_ports):
        port = record_at(tick.ports, node.first_port + i, PORT)
        value = _number(tick, node, i)
        if port.slot >= 0:
            if not port.low <= value <= port.high:
                return False
            if port.is_whole and value % 1 != 0:
                return False
        values[i] = value
    return True


@jit_part
def _call(tick, node, ports):
    """Calls a compiled leaf."""
    own = numbers_at(tick.memory + 8 * node.first)
    remembers = np.int64(node.size > 0)
    return call_leaf(node.leaf, node.num_ports, remembers, tick, own, ports)


@part_as(void, TICK_RECORD, INTEGER, INTEGER)
def _call_after(tick, row, status):
    """Tells the leaf of `AROUND` the status of the child."""
    values = numbers_at(tick.values)
    values[0] = status
    _call(tick, row_at(tick, row), values)


@jit_part
def enter(tick, row, has_read):
    """Ticks a node, whose ports Python may have read."""
    node = row_at(tick, row)
    memory = numbers_at(tick.memory)
    scratch = _scratch(tick, row)
    operation = node.operation
    at = tick.numbers + 8 * node.first_port
    if node.is_checked:
        if not has_read and not _read_ports(tick, node):
            interrupt(tick, row, READ_PORTS, 0)
            return 0
        at = tick.values
    ports = numbers_at(at)
    if operation <= op.AROUND:
        if node.leaf == 0:
            interrupt(tick, row, COMPILE_LEAF, 0)
            return 0
        tick.row = row
        result = _call(tick, node, ports)
        if operation == op.CONDITION:
            return -SUCCESS if result else -FAILURE
        return -result if operation == op.ACTION else row + 1
    if operation == op.PYTHON:
        interrupt(tick, row, RUN_LEAF, 0)
        return 0
    if operation == op.ORDERED:
        scratch[0] = min(max(memory[node.first], 0.0), node.children)
        scratch[1] = np.int64(memory[node.first + 1])
        child = _child(tick, row, scratch[0])
        return child if child else -node.a
    if operation == op.REACTIVE:
        scratch[1] = 0
        return row + 1
    if operation == op.GIVE:
        return -node.a
    if operation == op.SET:
        value = _number(tick, node, 0)
        if value == UNSET:
            return -FAILURE
        slot = record_at(tick.ports, node.first_port + 1, PORT).slot
        memory[slot] = value
        return -SUCCESS
    if operation == op.AGAIN:
        scratch[0] = np.int64(ports[0])
        scratch[1] = np.int64(memory[node.first])
        # An endless loop over a child that completes at once has one cycle in
        # each tick.
        scratch[2] = 1 if scratch[0] == -1 else MAX_CYCLES_PER_TICK
        return _tick_again(tick, row)
    if operation == op.RUN_ONCE:
        if memory[node.first] == 0:
            return row + 1
        if ports[0] or not RUNNING < memory[node.first] < SKIPPED:
            return -SKIPPED
        return -np.int64(memory[node.first])
    if operation == op.DELAY:
        if not steps_reach(memory[node.first], tick.time_step, ports[0] / 1000):
            memory[node.first] += 1
            return -RUNNING
        return row + 1
    if operation == op.TIMEOUT:
        limit = ports[0] / 1000
        passed = memory[node.first]
        scratch[0] = limit != 0
        if limit and passed and steps_reach(passed, tick.time_step, limit):
            memory[node.first] = 0.0
            halt(tick, row + 1, node.end)
            return -FAILURE
        return row + 1
    if operation == op.TIME_DELAY:
        if not steps_reach(memory[node.first], tick.time_step, ports[0]):
            memory[node.first] += 1
            return -FAILURE
        scratch[0] = ports[1] != 0
        return row + 1
    if operation == op.COOLDOWN:
        if memory[node.first] > 0:
            memory[node.first] -= 1
            return -FAILURE
        scratch[0] = steps_of(ports[0], tick.time_step)
        return row + 1
    if operation == op.NEEDS:
        if memory[node.first] > 0:
            child = _child(tick, row, np.int64(memory[node.first]) - 1)
        else:
            child = _most_wanted(tick, row)
        return child if child else -FAILURE
    if operation == op.IF:
        return max(_child(tick, row, np.int64(memory[node.first])), row + 1)
    if operation in (op.WHILE, op.MAPPED, op.SATISFIES):
        return row + 1
    if operation == op.SWITCH:
        chosen = 0
        value = _number(tick, node, 0)
        while chosen < node.num_ports - 1 and (
            value == UNSET or _number(tick, node, chosen + 1) != value
        ):
            chosen += 1
        before = np.int64(memory[node.first]) - 1
        if before >= 0 and before != chosen:
            child = _child(tick, row, before)
            if child:
                halt(tick, child, row_at(tick, child).end)
        return _child(tick, row, chosen)
    # PARALLEL
    scratch[0] = _threshold(ports[0], node.children)
    scratch[1] = _threshold(ports[1], node.children)
    scratch[2] = 0
    scratch[3] = ports[0] < 0
    return _tick_rest(tick, row, row + 1, False)


@jit_part
def resume(tick, row, child, status):
    """Goes on with a node after its child was ticked."""
    node = row_at(tick, row)
    memory = numbers_at(tick.memory)
    scratch = _scratch(tick, row)
    operation = node.operation
    if operation == op.ORDERED:
        following = 0
        if status == node.a or status == SKIPPED:
            scratch[1] += status == SKIPPED
            after = _following(tick, node, child)
            if after:
                return after
            status = SKIPPED if scratch[1] == node.children else node.a
        elif status == RUNNING:
            memory[node.first] = row_at(tick, child).index
            memory[node.first + 1] = scratch[1]
            return -RUNNING
        elif node.b:
            following = row_at(tick, child).index
        memory[node.first] = following
        memory[node.first + 1] = 0.0
        _tidy(tick, row)
        return -status
    if operation == op.REACTIVE:
        if status == RUNNING:
            halt(tick, row + 1, child)
            halt(tick, row_at(tick, child).end, node.end)
            return -RUNNING
        if status == node.a or status == SKIPPED:
            if status == SKIPPED:
                scratch[1] += 1
                halt(tick, child, row_at(tick, child).end)
            after = _following(tick, node, child)
            if after:
                return after
            status = SKIPPED if scratch[1] == node.children else node.a
        halt(tick, row + 1, node.end)
        return -status
    if operation == op.MAPPED:
        if status == RUNNING:
            return -node.a
        if status == SUCCESS:
            return -node.b
        return -(node.c if status == FAILURE else node.d)
    if operation == op.AROUND:
        _call_after(tick, row, status)
        return -status
    if operation == op.AGAIN:
        if status == node.a:
            scratch[2] -= 1
            # Endless loops do not count, so that nothing grows.
            scratch[1] += scratch[0] != -1
            return _tick_again(tick, row)
        memory[node.first] = 0.0 if status == node.b else scratch[1]
        return -status
    if operation == op.RUN_ONCE:
        if status in (SUCCESS, FAILURE):
            memory[node.first] = status
        return -status
    if operation == op.DELAY:
        if status in (SUCCESS, FAILURE):
            memory[node.first] = 0.0
        return -status
    if operation == op.TIMEOUT:
        if status == RUNNING and scratch[0]:
            memory[node.first] += 1
        elif status != SKIPPED:
            memory[node.first] = 0.0
        return -status
    if operation == op.TIME_DELAY:
        if scratch[0] and status in (SUCCESS, FAILURE):
            memory[node.first] = 0.0
        return -status
    if operation == op.COOLDOWN:
        gives_up = status == FAILURE and memory[node.first + 1] != 0
        if status == SUCCESS or gives_up:
            memory[node.first] = scratch[0]
        memory[node.first + 1] = status == RUNNING
        return -status
    if operation == op.NEEDS:
        index = row_at(tick, child).index
        memory[node.first] = index + 1 if status == RUNNING else 0
        return -status
    if operation == op.SATISFIES:
        if status == SUCCESS:
            need = np.int64(_number(tick, node, 0))
            level = memory[need] + _number(tick, node, 1)
            memory[need] = min(max(level, 0.0), 100.0)
        return -status
    if operation in (op.IF, op.WHILE):
        return _branch(tick, row, child, status)
    if operation == op.SWITCH:
        index = row_at(tick, child).index
        memory[node.first] = index + 1 if status == RUNNING else 0
        if status != RUNNING and status != SKIPPED:
            halt(tick, row + 1, node.end)
        return -status
    # PARALLEL
    if status == SKIPPED:
        scratch[2] += 1
    elif status != RUNNING:
        memory[node.first + row_at(tick, child).index] = status
    return _tick_rest(tick, row, child, True)


@jit_part
def _most_wanted(tick, row):
    """Returns the row of the Satisfies that is worth most to the person, or 0.

    People in the queue at its place make it worth less.
    """
    node = row_at(tick, row)
    child, most, chosen = row + 1, 0.0, 0
    while child:
        at = row_at(tick, child)
        level = numbers_at(tick.memory)[np.int64(_number(tick, at, 0))]
        worth = _number(tick, at, 1) / 100 * _number(tick, at, 2)
        queue = queue_length(tick, _number(tick, at, 3))
        worth *= (100 - level) / 100 * max(0.2, 1 - 0.05 * queue)
        if worth > most:
            most, chosen = worth, child
        child = _following(tick, node, child)
    return chosen


@part_as(INTEGER, TICK_RECORD, INTEGER)
def _tick_again(tick, row):
    """Ticks the child of Repeat or RetryUntilSuccessful, if it is due."""
    node = row_at(tick, row)
    scratch = _scratch(tick, row)
    memory = numbers_at(tick.memory)
    if scratch[0] != -1 and scratch[1] >= scratch[0]:
        memory[node.first] = 0.0
        return -node.a
    if scratch[2] == 0:
        memory[node.first] = scratch[1]
        return -RUNNING
    return row + 1


@part_as(INTEGER, TICK_RECORD, INTEGER, INTEGER, INTEGER)
def _branch(tick, row, child, status):
    """Goes on with IfThenElse or WhileDoElse after its child was ticked."""
    node = row_at(tick, row)
    memory = numbers_at(tick.memory)
    is_if = node.operation == op.IF
    index = row_at(tick, child).index
    if status == RUNNING:
        if is_if:
            memory[node.first] = index
        return -RUNNING
    if index == 0 and (status in (SUCCESS, FAILURE)):
        index = 1 if status == SUCCESS else 2
        if not is_if:
            other = _child(tick, row, 3 - index)
            if other:
                halt(tick, other, row_at(tick, other).end)
        chosen = _child(tick, row, index)
        if chosen:
            return chosen
    if is_if:
        memory[node.first] = 0.0
        _tidy(tick, row)
    else:
        halt(tick, row + 1, node.end)
    return -status


@jit_part
def _threshold(port, count):
    """Returns how many children a port of Parallel means."""
    return np.int64(port) if port >= 0 else max(count + np.int64(port) + 1, 0)


@part_as(INTEGER, TICK_RECORD, INTEGER, INTEGER, INTEGER)
def _tick_rest(tick, row, child, ticked):
    """Ticks the children of Parallel that are not done.

    They are those from one on, or from the one after if it has just been
    ticked.
    """
    node = row_at(tick, row)
    scratch = _scratch(tick, row)
    done = numbers_at(tick.memory + 8 * node.first)
    while child:
        if done[row_at(tick, child).index] == 0 and not ticked:
            return child
        ticked = False
        successes, failures = 0, 0
        for i in range(node.children):
            successes += done[i] == SUCCESS
            failures += done[i] == FAILURE
        # A threshold counted from the end counts skipped children in.
        if scratch[3]:
            successes += scratch[2]
        is_won = successes >= scratch[0]
        is_lost = node.children - failures < scratch[0]
        if is_won or is_lost or failures == scratch[1]:
            for i in range(node.children):
                done[i] = 0.0
            halt(tick, row + 1, node.end)
            return -SUCCESS if is_won else -FAILURE
        child = _following(tick, node, child)
    return -SKIPPED if scratch[2] == node.children else -RUNNING
