"""Pre- and post-conditions: attributes that any node can have.

The pre-conditions, `_failureIf`, `_successIf`, `_skipIf` and `_while`, are
checked in this order when the node is to begin: the first that holds (or
`_while` that does not) gives the result instead of the node. While the node is
RUNNING only `_while` is checked, and halts it. (BehaviorTree.CPP does not check
the first child of a WhileDoElse again while another child runs; here it is a
node like any other.)

BehaviorTree.CPP differs where the children of a control node or decorator have
skipped: there it counts as RUNNING until its parent halts it. So it is not
asked again for its `_skipIf`, `_failureIf` and `_successIf`; and being halted,
for instance a ForceFailure, it runs its `_onHalted`. Here a node that was
skipped has not begun: the conditions are checked again in the next tick, and
there is nothing to halt.

The post-conditions, `_onHalted`, `_onFailure`, `_onSuccess` and `_post` (after
both), set blackboard entries.
"""

from collections.abc import Callable

from hunav_drake.systems.behavior.nodes.node import (
    FAILURE,
    RUNNING,
    SKIPPED,
    SUCCESS,
    Built,
    Conditions,
    Fixed,
    Memory,
    Node,
    NodeStatus,
    TickFunction,
    parts_of,
)
from hunav_drake.systems.behavior.nodes.tick_context import TickContext

BEFORE = ("_failureIf", "_successIf", "_skipIf", "_while")
AFTER = ("_onHalted", "_onFailure", "_onSuccess", "_post")

# The slot of a node with one of these conditions: 1 while it runs.
BEGUN_SLOT = "(runs)"
_NEED_MEMORY = frozenset({*BEFORE, "_onHalted"})
_RESULTS = {"_failureIf": FAILURE, "_successIf": SUCCESS, "_skipIf": SKIPPED}


def needs_memory(names: set[str]) -> bool:
    """Returns whether a node must remember that it is running."""
    return bool(_NEED_MEMORY & names)


def build_with_conditions(node: Node, children: tuple[Built, ...]) -> Built:
    """Builds a node, with its pre- and post-conditions if it has any."""
    built = node.type.build(node, children)
    return _conditional(built, node.conditions) if node.conditions else built


def _conditional(built: Built, conditions: Conditions) -> Built:
    own_tick, own_halt = built.tick, built.halt
    before, after = conditions.before, conditions.after
    slot = conditions.slot
    holds_while = before.get("_while")
    results = tuple(
        (before[name], result)
        for name, result in _RESULTS.items()
        if name in before and not _never(before[name])
    )
    effects = {
        SUCCESS: (*after.get("_onSuccess", ()), *after.get("_post", ())),
        FAILURE: (*after.get("_onFailure", ()), *after.get("_post", ())),
    }
    has_effects = any(effects.values())
    when_halted = after.get("_onHalted", ())

    def halt(memory: Memory) -> None:
        if own_halt:
            own_halt(memory)
        if slot is not None and memory[slot]:
            memory[slot] = 0.0
            for effect in when_halted:
                effect(memory)

    def enter(memory: Memory, context: TickContext) -> NodeStatus:
        for holds, result in results:
            if holds(memory):
                return result
        if holds_while and not holds_while(memory):
            return SKIPPED
        return own_tick(memory, context)

    def tick(memory: Memory, context: TickContext) -> NodeStatus:
        if slot is None or not memory[slot]:
            status = enter(memory, context)
        elif holds_while and not holds_while(memory):
            halt(memory)
            return SKIPPED
        else:
            status = own_tick(memory, context)
        if slot is not None:
            memory[slot] = 1.0 if status is RUNNING else 0.0
        if has_effects:
            for effect in effects.get(status, ()):
                effect(memory)
        return status

    chosen: TickFunction = tick
    if slot is not None and not holds_while:
        # Conditions that never change are not evaluated in each tick.
        if not results and not has_effects:
            chosen = _noted(own_tick, slot)
        elif results and results[0][1] is SKIPPED and _always(results[0][0]):
            chosen = _skipped(tick, slot)
    skips = holds_while or any(result is SKIPPED for _, result in results)
    conditional = Built(
        chosen,
        halt if own_halt or slot is not None else None,
        built.may_skip or bool(skips),
        built.work,
    )
    if when_halted:
        return conditional
    clears, halts = parts_of((built,))
    own = () if slot is None else (slot,)
    return conditional._replace(clears=(*own, *clears), halts=halts)


def _noted(tick: TickFunction, slot: int) -> TickFunction:
    """Returns the tick of a node, which notes whether it runs."""

    def noted(memory: Memory, context: TickContext) -> NodeStatus:
        status = tick(memory, context)
        memory[slot] = 1.0 if status is RUNNING else 0.0
        return status

    return noted


def _skipped(tick: TickFunction, slot: int) -> TickFunction:
    """Returns the tick of a node that is skipped unless it runs already."""

    def skipped(memory: Memory, context: TickContext) -> NodeStatus:
        return tick(memory, context) if memory[slot] else SKIPPED

    return skipped


def _never(holds: Callable[[Memory], float]) -> bool:
    """Returns whether a condition never holds."""
    return isinstance(holds, Fixed) and not holds.number


def _always(holds: Callable[[Memory], float]) -> bool:
    """Returns whether a condition always holds."""
    return isinstance(holds, Fixed) and bool(holds.number)
