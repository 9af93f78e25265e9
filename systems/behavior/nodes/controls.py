"""The other control nodes: Parallel, IfThenElse, WhileDoElse.

Each function makes the functions of one node from those of its children, with
the meaning that BehaviorTree.CPP gives the node.
"""

from hunav_drake.systems.behavior.nodes.node import (
    Built,
    Memory,
    Node,
    NodeType,
    Port,
)
from hunav_drake.systems.behavior.nodes.sequences import (
    FAILURE,
    MANY,
    RUNNING,
    SKIPPED,
    SUCCESS,
    halts_of,
    leftovers_of,
    work_of,
)
from hunav_drake.systems.behavior.nodes.status import Status
from hunav_drake.systems.behavior.tick_context import Moment


def _parallel(node: Node, children: tuple[Built, ...]) -> Built:
    ticks = tuple(child.tick for child in children)
    count = len(ticks)
    halts = halts_of(children)
    slots = range(node.first, node.first + count)
    read_success = node.reader("success_count")
    read_failure = node.reader("failure_count")

    def threshold(value: int, port: str) -> int:
        if value > count:
            raise node.error(
                f"port {port}: must be at most {count}, the number of"
                f" children, got {value}"
            )
        return value if value >= 0 else max(count + value + 1, 0)

    for port in ("success_count", "failure_count"):
        constant = node.constant(port)
        if constant is not None:
            threshold(constant, port)

    def halt(memory: Memory) -> None:
        for slot in slots:
            memory[slot] = 0.0
        for halt in halts:
            halt(memory)

    def tick(memory: Memory, moment: Moment) -> Status:
        success_port = read_success(memory)
        needed = threshold(success_port, "success_count")
        allowed = threshold(read_failure(memory), "failure_count")
        done = [memory[slot] for slot in slots]
        successes, failures = done.count(SUCCESS), done.count(FAILURE)
        skipped = 0
        for i, slot in enumerate(slots):
            if not done[i]:
                status = ticks[i](memory, moment)
                if status is SUCCESS:
                    successes += 1
                    memory[slot] = float(SUCCESS)
                elif status is FAILURE:
                    failures += 1
                    memory[slot] = float(FAILURE)
                elif status is SKIPPED:
                    skipped += 1
            # A threshold counted from the end counts skipped children in.
            reached = successes + (skipped if success_port < 0 else 0)
            if reached >= needed:
                halt(memory)
                return SUCCESS
            if count - failures < needed or failures == allowed:
                halt(memory)
                return FAILURE
        return SKIPPED if skipped == count else RUNNING

    return Built(
        tick, halt, all(c.may_skip for c in children), work_of(children)
    )


def _if_then_else(node: Node, children: tuple[Built, ...]) -> Built:
    ticks = tuple(child.tick for child in children)
    count = len(ticks)
    halts, leftovers = halts_of(children), leftovers_of(children)
    branch = node.slot("branch")

    def tick(memory: Memory, moment: Moment) -> Status:
        chosen = int(memory[branch])
        if chosen == 0:
            status = ticks[0](memory, moment)
            if status is RUNNING:
                return RUNNING
            if status is SUCCESS:
                chosen = 1
            elif status is FAILURE and count == 3:
                chosen = 2
        if chosen:
            status = ticks[chosen](memory, moment)
            if status is RUNNING:
                memory[branch] = chosen
                return RUNNING
        memory[branch] = 0.0
        for halt in leftovers:
            halt(memory)
        return status

    def halt(memory: Memory) -> None:
        memory[branch] = 0.0
        for halt in halts:
            halt(memory)

    return Built(
        tick, halt, any(c.may_skip for c in children), work_of(children)
    )


def _while_do_else(node: Node, children: tuple[Built, ...]) -> Built:
    ticks = tuple(child.tick for child in children)
    count = len(ticks)
    halts = halts_of(children)
    own = tuple(child.halt for child in children)

    def tick(memory: Memory, moment: Moment) -> Status:
        status = ticks[0](memory, moment)
        if status is RUNNING:
            return RUNNING
        if status is SUCCESS:
            chosen, other = 1, 2
        elif status is FAILURE:
            chosen, other = 2, 1
        else:
            chosen = other = count
        if chosen < count:
            left = own[other] if other < count else None
            if left:
                left(memory)
            status = ticks[chosen](memory, moment)
            if status is RUNNING:
                return RUNNING
        for halt in halts:
            halt(memory)
        return status

    def halt(memory: Memory) -> None:
        for halt in halts:
            halt(memory)

    return Built(
        tick,
        halt if halts else None,
        any(c.may_skip for c in children),
        work_of(children),
    )


CONTROLS = (
    NodeType(
        "Parallel",
        "Control",
        _parallel,
        "Ticks all its children until enough succeed or fail.",
        ports={
            "success_count": Port("success_count", int, -1),
            "failure_count": Port("failure_count", int, 1),
        },
        slots_per_child=("status of child",),
        children=MANY,
    ),
    NodeType(
        "IfThenElse",
        "Control",
        _if_then_else,
        "Ticks the second child if the first succeeds, else the third.",
        slots={"branch": 0.0},
        children=(2, 3),
    ),
    NodeType(
        "WhileDoElse",
        "Control",
        _while_do_else,
        "An IfThenElse that checks its condition in each tick.",
        children=(2, 3),
    ),
)
