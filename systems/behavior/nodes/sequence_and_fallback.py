"""Sequence and Fallback, with memory and reactive, as in BehaviorTree.CPP.

Each function builds one node from its children. A
node's memory is zero unless it is RUNNING, with the exceptions that
BehaviorTree.CPP makes.
"""

from hunav_drake.systems.behavior.nodes.node import (
    FAILURE,
    MANY,
    RUNNING,
    SKIPPED,
    SUCCESS,
    BuildFunction,
    Built,
    Memory,
    Node,
    NodeStatus,
    NodeType,
    halt_of,
    halts_of,
    leftovers_of,
    work_of,
)
from hunav_drake.systems.behavior.nodes.tick_context import TickContext


def _in_order(goes_on: NodeStatus, stops: NodeStatus) -> BuildFunction:
    """Builds Sequence (goes on at SUCCESS) or Fallback (at FAILURE)."""

    def build(node: Node, children: tuple[Built, ...]) -> Built:
        ticks = tuple(enumerate(child.tick for child in children))
        count = len(ticks)
        leftovers = leftovers_of(children)
        at, skips = node.slot("child"), node.slot("skipped")

        def tick(memory: Memory, context: TickContext) -> NodeStatus:
            first = int(memory[at])
            skipped = memory[skips]
            for i, child_tick in ticks[first:] if first else ticks:
                status = child_tick(memory, context)
                if status is goes_on:
                    continue
                if status is RUNNING:
                    memory[at] = i
                    memory[skips] = skipped
                    return RUNNING
                if status is stops:
                    break
                skipped += 1
            else:
                status = SKIPPED if skipped == count else goes_on
            if first:
                memory[at] = 0.0
                memory[skips] = 0.0
            for halt in leftovers:
                halt(memory)
            return status

        return Built(
            tick,
            halt_of((at, skips), children),
            all(c.may_skip for c in children),
            work_of(children),
        )

    return build


def _sequence_with_memory(node: Node, children: tuple[Built, ...]) -> Built:
    ticks = tuple(child.tick for child in children)
    count = len(ticks)
    leftovers = leftovers_of(children)
    at, skips = node.slot("child"), node.slot("skipped")

    def tick(memory: Memory, context: TickContext) -> NodeStatus:
        skipped = memory[skips]
        memory[skips] = 0.0
        for i in range(int(memory[at]), count):
            status = ticks[i](memory, context)
            if status is SUCCESS:
                continue
            if status is RUNNING:
                memory[at] = i
                memory[skips] = skipped
                return RUNNING
            if status is FAILURE:
                # It goes on from here, also after it was halted.
                memory[at] = i
                for halt in leftovers:
                    halt(memory)
                return FAILURE
            skipped += 1
        memory[at] = 0.0
        for halt in leftovers:
            halt(memory)
        return SKIPPED if skipped == count else SUCCESS

    return Built(
        tick,
        halt_of((skips,), children),
        all(c.may_skip for c in children),
        work_of(children),
    )


def _reactive(goes_on: NodeStatus, stops: NodeStatus) -> BuildFunction:
    """Builds ReactiveSequence or ReactiveFallback."""

    def build(node: Node, children: tuple[Built, ...]) -> Built:
        ticks = tuple(child.tick for child in children)
        count = len(ticks)
        halts = halts_of(children)
        own = tuple(child.halt for child in children)
        others = tuple(
            tuple(halt for j, halt in enumerate(own) if halt and j != i)
            for i in range(count)
        )

        def tick(memory: Memory, context: TickContext) -> NodeStatus:
            skipped = 0
            for i in range(count):
                status = ticks[i](memory, context)
                if status is goes_on:
                    continue
                if status is RUNNING:
                    for halt in others[i]:
                        halt(memory)
                    return RUNNING
                if status is stops:
                    break
                skipped += 1
                skipped_halt = own[i]
                if skipped_halt:
                    skipped_halt(memory)
            else:
                status = SKIPPED if skipped == count else goes_on
            for halt in halts:
                halt(memory)
            return status

        return Built(
            tick,
            halt_of((), children) if halts else None,
            all(c.may_skip for c in children),
            work_of(children),
        )

    return build


_ORDERED = {"child": 0.0, "skipped": 0.0}

SEQUENCES = (
    NodeType(
        "Sequence",
        "Control",
        _in_order(SUCCESS, FAILURE),
        "Ticks its children in order while they succeed.",
        slots=_ORDERED,
        children=MANY,
    ),
    NodeType(
        "Fallback",
        "Control",
        _in_order(FAILURE, SUCCESS),
        "Ticks its children in order until one succeeds.",
        slots=_ORDERED,
        children=MANY,
    ),
    NodeType(
        "SequenceWithMemory",
        "Control",
        _sequence_with_memory,
        "A Sequence that goes on at the child that failed.",
        slots=_ORDERED,
        children=MANY,
    ),
    NodeType(
        "ReactiveSequence",
        "Control",
        _reactive(SUCCESS, FAILURE),
        "A Sequence that starts at its first child in each tick.",
        children=MANY,
    ),
    NodeType(
        "ReactiveFallback",
        "Control",
        _reactive(FAILURE, SUCCESS),
        "A Fallback that starts at its first child in each tick.",
        children=MANY,
    ),
)
