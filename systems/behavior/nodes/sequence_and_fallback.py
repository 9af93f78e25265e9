"""Sequence and Fallback, with memory and reactive, as in BehaviorTree.CPP.

Each function builds one node from its children. A node's memory is
zero unless it is RUNNING, with the exceptions that BehaviorTree.CPP makes.
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
    compose,
    halts_of,
    leftovers_of,
)
from hunav_drake.systems.behavior.nodes.tick_context import TickContext


def _in_order(
    goes_on: NodeStatus, stops: NodeStatus, *, stays: bool = False
) -> BuildFunction:
    """Builds Sequence (goes on at SUCCESS) or Fallback (at FAILURE).

    With `stays` it begins again at the child that stopped it, also after it
    was halted.
    """

    def build(node: Node, children: tuple[Built, ...]) -> Built:
        ticks = tuple(enumerate(child.tick for child in children))
        count = len(ticks)
        leftovers = leftovers_of(children)
        at, skips = node.slot("child"), node.slot("skipped")

        def tick(memory: Memory, context: TickContext) -> NodeStatus:
            first = int(memory[at])
            skipped = memory[skips]
            following = 0
            for i, child_tick in ticks[first:] if first else ticks:
                status = child_tick(memory, context)
                if status is goes_on:
                    continue
                if status is RUNNING:
                    memory[at] = i
                    memory[skips] = skipped
                    return RUNNING
                if status is stops:
                    following = i if stays else 0
                    break
                skipped += 1
            else:
                status = SKIPPED if skipped == count else goes_on
            if first or following:
                memory[at] = following
                memory[skips] = 0.0
            for halt in leftovers:
                halt(memory)
            return status

        slots = (skips,) if stays else (at, skips)
        return compose(tick, children, slots, skips=all)

    return build


def _reactive(goes_on: NodeStatus, stops: NodeStatus) -> BuildFunction:
    """Builds ReactiveSequence or ReactiveFallback."""

    def build(node: Node, children: tuple[Built, ...]) -> Built:
        ticks = tuple(enumerate(child.tick for child in children))
        count = len(ticks)
        halts = halts_of(children)
        own = tuple(child.halt for child in children)
        others = tuple(
            halts_of((*children[:i], *children[i + 1 :])) for i in range(count)
        )

        def tick(memory: Memory, context: TickContext) -> NodeStatus:
            skipped = 0
            for i, child_tick in ticks:
                status = child_tick(memory, context)
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

        return compose(tick, children, skips=all)

    return build


_ORDERED = {"child": 0.0, "skipped": 0.0}

SEQUENCES = tuple(
    NodeType(name, "Control", build, doc, slots=slots, children=MANY)
    for name, build, slots, doc in (
        (
            "Sequence",
            _in_order(SUCCESS, FAILURE),
            _ORDERED,
            "Ticks its children in order while they succeed.",
        ),
        (
            "Fallback",
            _in_order(FAILURE, SUCCESS),
            _ORDERED,
            "Ticks its children in order until one succeeds.",
        ),
        (
            "SequenceWithMemory",
            _in_order(SUCCESS, FAILURE, stays=True),
            _ORDERED,
            "A Sequence that goes on at the child that failed.",
        ),
        (
            "ReactiveSequence",
            _reactive(SUCCESS, FAILURE),
            {},
            "A Sequence that starts at its first child in each tick.",
        ),
        (
            "ReactiveFallback",
            _reactive(FAILURE, SUCCESS),
            {},
            "A Fallback that starts at its first child in each tick.",
        ),
    )
)
