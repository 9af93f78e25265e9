"""The nodes of the language: controls, decorators and the simplest actions.

They are those of BehaviorTree.CPP; `control_flow` has what they do. Times are
simulated times, counted in ticks from the first one.
"""

from typing import Annotated, Any

from hunav_drake.systems.behavior.nodes import operations as op
from hunav_drake.systems.behavior.nodes.node import MANY, Node, NodeType
from hunav_drake.systems.behavior.nodes.operations import Operation
from hunav_drake.systems.behavior.nodes.port import Port
from hunav_drake.systems.behavior.nodes.status import (
    FAILURE,
    RUNNING,
    SKIPPED,
    SUCCESS,
)
from hunav_drake.systems.common.schema import within

Milliseconds = Annotated[float, within(0, 1e9, "ms")]
_CYCLES = Annotated[int, within(-1, 1e9)]

_PLACE = {"child": 0.0, "skipped": 0.0}


def _control(
    name: str, doc: str, operation: Operation, **more: Any
) -> NodeType:
    return NodeType(name, "Control", operation, doc, **more)


def _decorator(
    name: str,
    doc: str,
    operation: Operation,
    port: Port | None = None,
    slot: str = "",
    kept: tuple[str, ...] = (),
) -> NodeType:
    return NodeType(
        name,
        "Decorator",
        operation,
        doc,
        ports={port.name: port} if port else {},
        slots={slot: 0.0} if slot else {},
        kept=kept,
        children=(1, 1),
    )


def _mapped(success: int, failure: int, skipped: int = SKIPPED) -> Operation:
    return Operation(op.MAPPED, (RUNNING, success, failure, skipped))


# The type of <SubTree>: the node shows where a subtree begins. Its ports are
# those of the subtree, so the parser handles it apart.
SUBTREE = _decorator(
    "SubTree", "Ticks another tree.", _mapped(SUCCESS, FAILURE)
)

_SEQUENCES = (
    _control(
        "Sequence",
        "Ticks its children in order while they succeed.",
        Operation(op.ORDERED, (SUCCESS, False)),
        slots=_PLACE,
        children=MANY,
    ),
    _control(
        "Fallback",
        "Ticks its children in order until one succeeds.",
        Operation(op.ORDERED, (FAILURE, False)),
        slots=_PLACE,
        children=MANY,
    ),
    _control(
        "SequenceWithMemory",
        "A Sequence that goes on at the child that failed.",
        Operation(op.ORDERED, (SUCCESS, True)),
        slots=_PLACE,
        kept=("child",),
        children=MANY,
    ),
    _control(
        "ReactiveSequence",
        "A Sequence that starts at its first child in each tick.",
        Operation(op.REACTIVE, (SUCCESS,)),
        children=MANY,
    ),
    _control(
        "ReactiveFallback",
        "A Fallback that starts at its first child in each tick.",
        Operation(op.REACTIVE, (FAILURE,)),
        children=MANY,
    ),
)

_BRANCHES = (
    _control(
        "Parallel",
        "Ticks all its children until enough succeed or fail.",
        Operation(op.PARALLEL),
        ports={
            "success_count": Port("success_count", int, -1),
            "failure_count": Port("failure_count", int, 1),
        },
        slots_per_child=("status of child",),
        children=MANY,
    ),
    _control(
        "IfThenElse",
        "Ticks the second child if the first succeeds, else the third.",
        Operation(op.IF),
        slots={"branch": 0.0},
        children=(2, 3),
    ),
    _control(
        "WhileDoElse",
        "An IfThenElse that checks its condition in each tick.",
        Operation(op.WHILE),
        children=(2, 3),
    ),
    *(
        _control(
            f"Switch{cases}",
            f"Ticks the child whose case equals the variable, else child"
            f" {cases + 1}.",
            Operation(op.SWITCH),
            ports={
                name: Port(name, Any)
                for name in (
                    "variable",
                    *(f"case_{i + 1}" for i in range(cases)),
                )
            },
            slots={"child": 0.0},
            children=(cases + 1, cases + 1),
        )
        for cases in range(2, 7)
    ),
)

_DECORATORS = (
    _decorator(
        "Inverter", "Exchanges success and failure.", _mapped(FAILURE, SUCCESS)
    ),
    _decorator(
        "ForceSuccess",
        "Succeeds as soon as its child completes.",
        _mapped(SUCCESS, SUCCESS),
    ),
    _decorator(
        "ForceFailure",
        "Fails as soon as its child completes.",
        _mapped(FAILURE, FAILURE),
    ),
    _decorator(
        "KeepRunningUntilFailure",
        "Ticks its child, tick after tick, until it fails.",
        _mapped(RUNNING, FAILURE, RUNNING),
    ),
    _decorator(
        "Repeat",
        "Ticks its child again while it succeeds; -1 is for ever.",
        Operation(op.AGAIN, (SUCCESS, FAILURE)),
        Port("num_cycles", _CYCLES),
        "count",
    ),
    _decorator(
        "RetryUntilSuccessful",
        "Ticks its child again while it fails; -1 is for ever.",
        Operation(op.AGAIN, (FAILURE, SUCCESS)),
        Port("num_attempts", _CYCLES),
        "count",
    ),
    _decorator(
        "RunOnce",
        "Ticks its child to completion once, and then skips it.",
        Operation(op.RUN_ONCE),
        Port("then_skip", bool, True),
        "result",
        kept=("result",),
    ),
    _decorator(
        "Delay",
        "Ticks its child after some simulated time.",
        Operation(op.DELAY),
        Port("delay_msec", Milliseconds),
        "steps",
    ),
    _decorator(
        "Timeout",
        "Fails if its child still runs after some simulated time.",
        Operation(op.TIMEOUT),
        Port("msec", Milliseconds),
        "steps",
    ),
)

_ACTIONS = (
    NodeType(
        "AlwaysSuccess", "Action", Operation(op.GIVE, (SUCCESS,)), "Succeeds."
    ),
    NodeType(
        "AlwaysFailure", "Action", Operation(op.GIVE, (FAILURE,)), "Fails."
    ),
    NodeType(
        "SetBlackboard",
        "Action",
        Operation(op.SET),
        "Sets a blackboard entry to a number, boolean, text or other entry.",
        ports={
            "value": Port("value", Any),
            "output_key": Port("output_key", Any, output=True),
        },
    ),
)

LANGUAGE_NODES = (*_SEQUENCES, *_BRANCHES, *_DECORATORS, *_ACTIONS)


def check_thresholds(node: Node, values: dict[str, Any]) -> None:
    """Checks the ports of Parallel, if the node is one.

    Raises:
        BehaviorTreeError: If one is larger than the number of children.
    """
    count = len(node.children)
    if node.type.operation.code != op.PARALLEL:
        return
    for port, value in values.items():
        if value is not None and value > count:
            raise node.error(
                f"port {port}: must be at most {count}, the number of"
                f" children, got {value}"
            )
