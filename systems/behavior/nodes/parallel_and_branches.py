"""Parallel, which ticks all children, and nodes that choose one of them.

Each function builds one node from its children; they work as in
BehaviorTree.CPP.
"""

from typing import Any

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
    halts_of,
    leftovers_of,
)
from hunav_drake.systems.behavior.nodes.port import UNSET, Port
from hunav_drake.systems.behavior.nodes.tick_context import TickContext


def _if_then_else(node: Node, children: tuple[Built, ...]) -> Built:
    ticks = tuple(child.tick for child in children)
    count = len(ticks)
    leftovers = leftovers_of(children)
    branch = node.slot("branch")

    def tick(memory: Memory, context: TickContext) -> NodeStatus:
        chosen = int(memory[branch])
        if chosen == 0:
            status = ticks[0](memory, context)
            if status is RUNNING:
                return RUNNING
            if status is SUCCESS:
                chosen = 1
            elif status is FAILURE and count == 3:
                chosen = 2
        if chosen:
            status = ticks[chosen](memory, context)
            if status is RUNNING:
                memory[branch] = chosen
                return RUNNING
        memory[branch] = 0.0
        for halt in leftovers:
            halt(memory)
        return status

    return compose(tick, children, (branch,))


def _while_do_else(node: Node, children: tuple[Built, ...]) -> Built:
    ticks = tuple(child.tick for child in children)
    count = len(ticks)
    halts = halts_of(children)
    own = tuple(child.halt for child in children)

    def tick(memory: Memory, context: TickContext) -> NodeStatus:
        status = ticks[0](memory, context)
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
            status = ticks[chosen](memory, context)
            if status is RUNNING:
                return RUNNING
        for halt in halts:
            halt(memory)
        return status

    return compose(tick, children)


def _switch(node: Node, children: tuple[Built, ...]) -> Built:
    ticks = tuple(child.tick for child in children)
    default = len(ticks) - 1
    leftovers = leftovers_of(children)
    own = tuple(child.halt for child in children)
    read = node.number_reader("variable")
    cases = [node.number_reader(f"case_{i + 1}") for i in range(default)]
    # The child that runs, counted from 1; else 0.
    running = node.slot("child")

    def choose(memory: Memory) -> int:
        value = read(memory)
        if value != UNSET:
            for i, case in enumerate(cases):
                if case(memory) == value:
                    return i
        return default

    def tick(memory: Memory, context: TickContext) -> NodeStatus:
        chosen = choose(memory)
        before = int(memory[running]) - 1
        if before not in (-1, chosen):
            left = own[before]
            if left:
                left(memory)
        status = ticks[chosen](memory, context)
        memory[running] = chosen + 1.0 if status is RUNNING else 0.0
        if status is not RUNNING and status is not SKIPPED:
            for halt in leftovers:
                halt(memory)
        return status

    # One child is ticked, whichever it is.
    work = 1 + max(child.work for child in children)
    return compose(tick, children, (running,))._replace(work=work)


def _ports(cases: int) -> dict[str, Port]:
    names = ["variable", *(f"case_{i + 1}" for i in range(cases))]
    return {name: Port(name, Any) for name in names}


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


PARALLEL_AND_BRANCHES = (
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
    *(
        NodeType(
            f"Switch{cases}",
            "Control",
            _switch,
            f"Ticks the child whose case equals the variable, else child"
            f" {cases + 1}.",
            ports=_ports(cases),
            slots={"child": 0.0},
            children=(cases + 1, cases + 1),
        )
        for cases in range(2, 7)
    ),
)
