"""The decorators: Inverter, ForceSuccess, Repeat, Delay, Timeout, ...

They work as in BehaviorTree.CPP. Times are simulated times, counted in ticks
from the first one.
"""

from collections.abc import Mapping
from typing import Annotated

from hunav_drake.systems.behavior.nodes.node import (
    FAILURE,
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
    halt_of,
)
from hunav_drake.systems.behavior.nodes.port import Port
from hunav_drake.systems.behavior.nodes.tick_context import TickContext
from hunav_drake.systems.common.schema import within

# The number of times that Repeat and RetryUntilSuccessful tick a child that
# completes at once, before they leave the rest to the next tick.
MAX_CYCLES_PER_TICK = 100

Milliseconds = Annotated[float, within(0, 1e9, "ms")]


def steps_reach(steps: float, time_step: float, seconds: float) -> bool:
    """Returns whether a number of steps lasts at least a duration.

    A multiple of the step that misses the duration by rounding alone has
    reached it.
    """
    return steps * time_step >= seconds * (1 - 1e-12)


def _mapped(results: Mapping[NodeStatus, NodeStatus]) -> BuildFunction:
    """Builds a decorator that maps the result of its child to another."""

    def build(node: Node, children: tuple[Built, ...]) -> Built:
        (child,) = children
        child_tick = child.tick

        def tick(memory: Memory, context: TickContext) -> NodeStatus:
            return results[child_tick(memory, context)]

        return compose(tick, children)

    return build


def _exchange(success: NodeStatus, failure: NodeStatus) -> BuildFunction:
    same = {RUNNING: RUNNING, SKIPPED: SKIPPED}
    return _mapped({**same, SUCCESS: success, FAILURE: failure})


def _keep_running(node: Node, children: tuple[Built, ...]) -> Built:
    results = dict.fromkeys((RUNNING, SUCCESS, SKIPPED), RUNNING)
    built = _mapped({**results, FAILURE: FAILURE})(node, children)
    return built._replace(may_skip=False)


def _again(port: str, again: NodeStatus, stops: NodeStatus) -> BuildFunction:
    """Builds Repeat (again at SUCCESS) or RetryUntilSuccessful (FAILURE)."""

    def build(node: Node, children: tuple[Built, ...]) -> Built:
        (child,) = children
        child_tick = child.tick
        read = node.reader(port)
        counter = node.slot("count")

        def tick(memory: Memory, context: TickContext) -> NodeStatus:
            limit = read(memory)
            count = int(memory[counter])
            # An endless loop over a child that completes at once has one
            # cycle in each tick.
            cycles = 1 if limit == -1 else MAX_CYCLES_PER_TICK
            while limit == -1 or count < limit:
                if cycles == 0:
                    memory[counter] = count
                    return RUNNING
                status = child_tick(memory, context)
                if status is stops:
                    memory[counter] = 0.0
                    return stops
                if status is not again:
                    memory[counter] = count
                    return status
                cycles -= 1
                # Endless loops do not count, so that nothing grows.
                if limit != -1:
                    count += 1
            memory[counter] = 0.0
            return again

        limit = node.constant(port)
        most = MAX_CYCLES_PER_TICK
        if limit is not None:
            most = 1 if limit == -1 else min(limit, most)
        work = 1 + most * child.work
        return compose(tick, children, (counter,))._replace(work=work)

    return build


def _run_once(node: Node, children: tuple[Built, ...]) -> Built:
    (child,) = children
    child_tick = child.tick
    read_then_skip = node.reader("then_skip")
    result = node.slot("result")

    def tick(memory: Memory, context: TickContext) -> NodeStatus:
        if memory[result]:
            if read_then_skip(memory):
                return SKIPPED
            return NodeStatus(int(memory[result]))
        status = child_tick(memory, context)
        if status is SUCCESS or status is FAILURE:
            memory[result] = float(status)
        return status

    may_skip = child.may_skip or node.constant("then_skip") is not False
    return compose(tick, children)._replace(may_skip=may_skip)


def _delay(node: Node, children: tuple[Built, ...]) -> Built:
    (child,) = children
    child_tick = child.tick
    read = node.reader("delay_msec")
    steps = node.slot("steps")

    def tick(memory: Memory, context: TickContext) -> NodeStatus:
        delay = read(memory) / 1000
        if not steps_reach(memory[steps], context.person.time_step, delay):
            memory[steps] += 1
            return RUNNING
        status = child_tick(memory, context)
        if status is SUCCESS or status is FAILURE:
            memory[steps] = 0.0
        return status

    return compose(tick, children, (steps,))


def _timeout(node: Node, children: tuple[Built, ...]) -> Built:
    (child,) = children
    child_tick = child.tick
    read = node.reader("msec")
    steps = node.slot("steps")
    halt = halt_of((steps,), children)

    def tick(memory: Memory, context: TickContext) -> NodeStatus:
        limit = read(memory) / 1000
        passed = memory[steps]
        time_step = context.person.time_step
        if limit and passed and steps_reach(passed, time_step, limit):
            halt(memory)
            return FAILURE
        status = child_tick(memory, context)
        if status is RUNNING:
            # Without a limit there is nothing to count.
            memory[steps] = passed + 1 if limit else 0.0
        elif status is not SKIPPED:
            memory[steps] = 0.0
        return status

    return compose(tick, children, (steps,))


def _decorator(
    name: str,
    build: BuildFunction,
    doc: str,
    port: Port | None = None,
    slot: str = "",
) -> NodeType:
    return NodeType(
        name,
        "Decorator",
        build,
        doc,
        ports={port.name: port} if port else {},
        slots={slot: 0.0} if slot else {},
        children=(1, 1),
    )


_CYCLES = Annotated[int, within(-1, 1e9)]

# The type of <SubTree>: the node shows where a subtree begins. Its ports are
# those of the subtree, so the parser handles it apart.
SUBTREE = _decorator(
    "SubTree", _exchange(SUCCESS, FAILURE), "Ticks another tree."
)

DECORATORS = (
    _decorator(
        "Inverter",
        _exchange(FAILURE, SUCCESS),
        "Exchanges success and failure.",
    ),
    _decorator(
        "ForceSuccess",
        _exchange(SUCCESS, SUCCESS),
        "Succeeds as soon as its child completes.",
    ),
    _decorator(
        "ForceFailure",
        _exchange(FAILURE, FAILURE),
        "Fails as soon as its child completes.",
    ),
    _decorator(
        "KeepRunningUntilFailure",
        _keep_running,
        "Ticks its child, tick after tick, until it fails.",
    ),
    _decorator(
        "Repeat",
        _again("num_cycles", SUCCESS, FAILURE),
        "Ticks its child again while it succeeds; -1 is for ever.",
        Port("num_cycles", _CYCLES),
        "count",
    ),
    _decorator(
        "RetryUntilSuccessful",
        _again("num_attempts", FAILURE, SUCCESS),
        "Ticks its child again while it fails; -1 is for ever.",
        Port("num_attempts", _CYCLES),
        "count",
    ),
    _decorator(
        "RunOnce",
        _run_once,
        "Ticks its child to completion once, and then skips it.",
        Port("then_skip", bool, True),
        "result",
    ),
    _decorator(
        "Delay",
        _delay,
        "Ticks its child after some simulated time.",
        Port("delay_msec", Milliseconds),
        "steps",
    ),
    _decorator(
        "Timeout",
        _timeout,
        "Fails if its child still runs after some simulated time.",
        Port("msec", Milliseconds),
        "steps",
    ),
)
