"""Parallel: ticks all its children until enough succeed or fail."""

from hunav_drake.systems.behavior.nodes.node import (
    FAILURE,
    MANY,
    RUNNING,
    SKIPPED,
    SUCCESS,
    Built,
    Memory,
    Node,
    NodeStatus,
    NodeType,
    compose,
    halt_of,
)
from hunav_drake.systems.behavior.nodes.port import Port
from hunav_drake.systems.behavior.nodes.tick_context import TickContext


def _parallel(node: Node, children: tuple[Built, ...]) -> Built:
    ticks = tuple(child.tick for child in children)
    count = len(ticks)
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

    halt = halt_of(slots, children)

    def tick(memory: Memory, context: TickContext) -> NodeStatus:
        success_port = read_success(memory)
        needed = threshold(success_port, "success_count")
        allowed = threshold(read_failure(memory), "failure_count")
        done = [memory[slot] for slot in slots]
        successes, failures = done.count(SUCCESS), done.count(FAILURE)
        skipped = 0
        for i, slot in enumerate(slots):
            if not done[i]:
                status = ticks[i](memory, context)
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

    return compose(tick, children, slots, skips=all)


PARALLEL = NodeType(
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
)
