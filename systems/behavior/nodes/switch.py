"""Switch2 to Switch6: the child that belongs to a value."""

from typing import Any

from hunav_drake.systems.behavior.nodes.node import (
    UNSET,
    Built,
    Memory,
    Node,
    NodeType,
    Port,
)
from hunav_drake.systems.behavior.nodes.sequences import (
    RUNNING,
    SKIPPED,
    halts_of,
    leftovers_of,
)
from hunav_drake.systems.behavior.nodes.status import Status
from hunav_drake.systems.behavior.tick_context import Moment


def _switch(node: Node, children: tuple[Built, ...]) -> Built:
    ticks = tuple(child.tick for child in children)
    default = len(ticks) - 1
    halts, leftovers = halts_of(children), leftovers_of(children)
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

    def tick(memory: Memory, moment: Moment) -> Status:
        chosen = choose(memory)
        before = int(memory[running]) - 1
        if before not in (-1, chosen):
            left = own[before]
            if left:
                left(memory)
        status = ticks[chosen](memory, moment)
        memory[running] = chosen + 1.0 if status is RUNNING else 0.0
        if status is not RUNNING and status is not SKIPPED:
            for halt in leftovers:
                halt(memory)
        return status

    def halt(memory: Memory) -> None:
        memory[running] = 0.0
        for halt in halts:
            halt(memory)

    # One child is ticked, whichever it is.
    work = 1 + max(child.work for child in children)
    return Built(tick, halt, any(c.may_skip for c in children), work)


def _ports(cases: int) -> dict[str, Port]:
    names = ["variable", *(f"case_{i + 1}" for i in range(cases))]
    return {name: Port(name, Any) for name in names}


SWITCHES = tuple(
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
)
