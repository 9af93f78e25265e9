"""Ticks the trees of people: one walk over the tables of all, compiled.

The walk goes from node to node without a function for each, so that it can
stop at any: a leaf in Python runs between two calls, and the walk goes on with
its status.
"""

from numba import void

from hunav_drake.systems.behavior.nodes.control_flow import (
    FAILURE,
    IDLE,
    RUNNING,
    SKIPPED,
    SUCCESS,
    enter,
    resume,
)
from hunav_drake.systems.behavior.nodes.pointers import numbers_at, record_at
from hunav_drake.systems.behavior.nodes.scripts import halt, row_at, run_script
from hunav_drake.systems.behavior.nodes.social import begin_signal, end_signal
from hunav_drake.systems.behavior.nodes.tick import (
    COMMAND_AT,
    STATE_AT,
    TICK,
    TICK_RECORD,
    TICK_SIZE,
    command_to,
)
from hunav_drake.systems.behavior.nodes.tick_context import SEED, TICKS
from hunav_drake.systems.common.kernels import (
    CHANGED_VECTOR,
    INTEGER,
    VECTOR,
    jit_as,
    jit_part,
    part_as,
)
from hunav_drake.systems.common.layout import COMMAND_SIZE, OUTSIDE, STATE_SIZE
from hunav_drake.systems.people.standing import find_standing

# In place of a status: the ports of the node have been read.
PORTS_READ = -1


@part_as(INTEGER, TICK_RECORD, INTEGER)
def _asked(tick, row):
    """Returns the status that the conditions before a node give, or IDLE."""
    node = row_at(tick, row)
    if node.begun >= 0 and numbers_at(tick.memory)[node.begun] != 0:
        if (
            node.holds_while >= 0
            and run_script(tick, row, node.holds_while) == 0
        ):
            halt(tick, row, node.end)
            return SKIPPED
        return IDLE
    if node.failure_if >= 0 and run_script(tick, row, node.failure_if) != 0:
        return FAILURE
    if node.success_if >= 0 and run_script(tick, row, node.success_if) != 0:
        return SUCCESS
    if node.skip_if >= 0 and run_script(tick, row, node.skip_if) != 0:
        return SKIPPED
    if node.holds_while >= 0 and run_script(tick, row, node.holds_while) == 0:
        return SKIPPED
    return IDLE


@jit_part
def _note(tick, row, status):
    """Notes the status of a node, and runs the scripts after it."""
    numbers_at(tick.statuses)[row] = status
    node = row_at(tick, row)
    if node.running >= 0:
        numbers_at(tick.memory)[node.running] = status == RUNNING
    if node.begun >= 0:
        numbers_at(tick.memory)[node.begun] = status == RUNNING
    script = -1
    if status == SUCCESS:
        script = node.on_success
    elif status == FAILURE:
        script = node.on_failure
    if script >= 0:
        run_script(tick, row, script)


@part_as(void, TICK_RECORD, INTEGER, INTEGER)
def _walk_tree(tick, row, status):
    """Ticks a tree from its top, or goes on from a node with its status."""
    while True:
        if status == IDLE and row_at(tick, row).asks:
            status = _asked(tick, row)
        result = -status
        if status in (IDLE, PORTS_READ):
            result = enter(tick, row, status == PORTS_READ)
        # (A row above 0 is to be ticked, a number below is a status.)
        while result < 0:
            status = -result
            _note(tick, row, status)
            if row == 0 or tick.code != 0:
                return
            child, row = row, row_at(tick, row).parent
            result = resume(tick, row, child, status)
        if tick.code != 0:
            return
        row, status = result, IDLE


@jit_part
def _begin(tick, words, memory, humans, robots, signals):
    """Prepares the tick of a person; returns whether the person is outside."""
    tick.signals = signals.ctypes.data if len(signals) else 0
    tick.humans = humans.ctypes.data
    tick.num_humans = len(humans) // STATE_SIZE
    tick.robots = robots.ctypes.data
    tick.num_robots = len(robots) // STATE_SIZE
    own = STATE_SIZE * tick.index
    for i in range(STATE_SIZE):
        words[STATE_AT + i] = humans[own + i]
    is_outside = tick.initial != 0 and tick.x == OUTSIDE
    after = numbers_at(tick.memory)
    for i in range(tick.num_slots):
        after[i] = memory[tick.first_slot + i]
    if is_outside:
        initial = numbers_at(tick.initial)
        for i in range(tick.num_slots):
            after[i] = initial[i]
        if tick.social != 0:
            # (Ticks of all people are counted alike; the seed is the trial's.)
            first = tick.first_slot + 1
            after[1 + TICKS] = memory[first + TICKS] + 1
            for i in (SEED, SEED + 1):
                after[1 + i] = memory[first + i]
    tick.goal = min(max(after[0], 0.0), tick.num_goals)
    command = command_to(tick, tick.num_goals if is_outside else tick.goal)
    for i in range(COMMAND_SIZE):
        words[COMMAND_AT + i] = command[i]
    statuses = numbers_at(tick.statuses)
    for i in range(tick.num_rows):
        statuses[i] = IDLE
    if tick.signals != 0:
        begin_signal(tick, is_outside)
    return is_outside


@jit_as(
    INTEGER, INTEGER, INTEGER, *[VECTOR] * 4, CHANGED_VECTOR, *[INTEGER] * 3
)
def walk(
    people, count, memory, humans, robots, signals, work, person, row, status
):
    """Ticks the trees of people.

    Args:
        people: The address of a record `TICK` for each person, with all that
            does not change; addresses in `work` are counted from its begin.
        count: The number of people.
        memory: The memories of all people.
        humans: See `layout`.
        robots: See `layout`.
        signals: Rows of `layout.Signal` of all people, then of all robots; or
            empty.
        work: The numbers of the tick, laid out as by `Walk`. It is changed.
        person: The number of the person to begin with.
        row: The row of the node where the walk was interrupted; or -1.
        status: The status of that node, or `PORTS_READ`.

    Returns:
        0, or why the walk was interrupted, and must be called again.
    """
    base = work.ctypes.data
    tick = record_at(base, 0, TICK)
    standing = len(work) - 3 * (len(humans) // STATE_SIZE)
    num_standing = find_standing(humans, work[standing:])
    for i in range(person, count):
        if row < 0:
            template = numbers_at(people)
            for k in range(TICK_SIZE):
                work[k] = template[i * TICK_SIZE + k]
            tick.memory += base
            tick.statuses += base
            tick.scratch += base
            tick.values += base
            tick.stack += base
            tick.distances += base
            tick.signal += base
            if tick.social != 0:
                # (After the index of the goal.)
                tick.social = tick.memory + 8
            tick.standing = base + 8 * standing
            tick.num_standing = num_standing
            tick.person = i
            if not _begin(tick, work, memory, humans, robots, signals):
                _walk_tree(tick, 0, IDLE)
        else:
            tick.code = 0
            _walk_tree(tick, row, status)
            row = -1
        if tick.code != 0:
            return tick.code
        if tick.signals != 0 and (tick.initial == 0 or tick.x != OUTSIDE):
            end_signal(tick)
        numbers_at(tick.memory)[0] = tick.goal
        commands = TICK_SIZE + len(memory)
        for k in range(COMMAND_SIZE):
            work[commands + COMMAND_SIZE * i + k] = work[COMMAND_AT + k]
        work[commands + COMMAND_SIZE * count + i] = tick.behavior_status
    return 0
