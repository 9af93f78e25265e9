"""The nodes of the language: controls, decorators and the simplest actions.

They are those of BehaviorTree.CPP; `control_flow` has what they do. Times are
simulated times, counted in ticks from the first one.
"""

from typing import Annotated, Any

from hunav_drake.systems.behavior.nodes import operations as op
from hunav_drake.systems.behavior.nodes.node import (
    MANY,
    Category,
    Node,
    NodeType,
)
from hunav_drake.systems.behavior.nodes.operations import Operation
from hunav_drake.systems.behavior.nodes.port import Meaning, Port
from hunav_drake.systems.behavior.nodes.status import (
    FAILURE,
    RUNNING,
    SKIPPED,
    SUCCESS,
)
from hunav_drake.systems.common.schema import within

_MILLISECONDS = Annotated[float, within(0, 1e9, "ms")]
_SECONDS = Annotated[float, within(0, 1e9, "s")]
_CYCLES = Annotated[int, within(-1, 1e9)]
_NEED = Annotated[str, Meaning.NEED]
_AMOUNT = Annotated[float, within(0, 100)]
_WEIGHT = Annotated[float, within(0, 1e9)]
_PLACE = {"child": 0.0, "skipped": 0.0}


def _node(
    category: Category,
    name: str,
    doc: str,
    code: int,
    *numbers: int,
    ports: tuple[Port, ...] = (),
    **more: Any,
) -> NodeType:
    by_name = {port.name: port for port in ports}
    operation = Operation(code, numbers)
    return NodeType(name, category, operation, doc, ports=by_name, **more)


def _control(*what: Any, **more: Any) -> NodeType:
    return _node("Control", *what, **{"children": MANY, **more})


def _decorator(*what: Any, slot: str = "", **more: Any) -> NodeType:
    slots = {slot: 0.0} if slot else {}
    return _node("Decorator", *what, children=(1, 1), slots=slots, **more)


def _mapped(name: str, doc: str, success: int, failure: int) -> NodeType:
    # What the node is while its child runs, succeeds, fails, or skips.
    return _decorator(name, doc, op.MAPPED, RUNNING, success, failure, SKIPPED)


# The type of <SubTree>: the node shows where a subtree begins. Its ports are
# those of the subtree, so the parser handles it apart.
SUBTREE = _mapped("SubTree", "Ticks another tree.", SUCCESS, FAILURE)

LANGUAGE_NODES = (
    _control(
        *("Sequence", "Ticks its children in order while they succeed."),
        *(op.ORDERED, SUCCESS, False),
        slots=_PLACE,
    ),
    _control(
        *("Fallback", "Ticks its children in order until one succeeds."),
        *(op.ORDERED, FAILURE, False),
        slots=_PLACE,
    ),
    _control(
        "SequenceWithMemory",
        "A Sequence that goes on at the child that failed.",
        *(op.ORDERED, SUCCESS, True),
        slots=_PLACE,
        kept=("child",),
    ),
    _control(
        "ReactiveSequence",
        "A Sequence that starts at its first child in each tick.",
        *(op.REACTIVE, SUCCESS),
    ),
    _control(
        "ReactiveFallback",
        "A Fallback that starts at its first child in each tick.",
        *(op.REACTIVE, FAILURE),
    ),
    _control(
        *("Parallel", "Ticks all its children until enough succeed or fail."),
        op.PARALLEL,
        ports=(Port("success_count", int, -1), Port("failure_count", int, 1)),
        slots_per_child=("status of child",),
    ),
    _control(
        "IfThenElse",
        "Ticks the second child if the first succeeds, else the third.",
        op.IF,
        slots={"branch": 0.0},
        children=(2, 3),
    ),
    _control(
        "WhileDoElse",
        "An IfThenElse that checks its condition in each tick.",
        op.WHILE,
        children=(2, 3),
    ),
    *(
        _control(
            f"Switch{cases}",
            f"Ticks the child whose case equals the variable, else child"
            f" {cases + 1}.",
            op.SWITCH,
            ports=(
                Port("variable", Any),
                *(Port(f"case_{i + 1}", Any) for i in range(cases)),
            ),
            slots={"child": 0.0},
            children=(cases + 1, cases + 1),
        )
        for cases in range(2, 7)
    ),
    _mapped("Inverter", "Exchanges success and failure.", FAILURE, SUCCESS),
    _mapped(
        *("ForceSuccess", "Succeeds as soon as its child completes."),
        *(SUCCESS, SUCCESS),
    ),
    _mapped(
        *("ForceFailure", "Fails as soon as its child completes."),
        *(FAILURE, FAILURE),
    ),
    _decorator(
        "KeepRunningUntilFailure",
        "Ticks its child, tick after tick, until it fails.",
        *(op.MAPPED, RUNNING, RUNNING, FAILURE, RUNNING),
    ),
    _decorator(
        "Repeat",
        "Ticks its child again while it succeeds; -1 is for ever.",
        *(op.AGAIN, SUCCESS, FAILURE),
        ports=(Port("num_cycles", _CYCLES),),
        slot="count",
    ),
    _decorator(
        "RetryUntilSuccessful",
        "Ticks its child again while it fails; -1 is for ever.",
        *(op.AGAIN, FAILURE, SUCCESS),
        ports=(Port("num_attempts", _CYCLES),),
        slot="count",
    ),
    _decorator(
        *("RunOnce", "Ticks its child to completion once, and then skips it."),
        op.RUN_ONCE,
        ports=(Port("then_skip", bool, True),),
        slot="result",
        kept=("result",),
    ),
    _decorator(
        *("Delay", "Ticks its child after some simulated time."),
        op.DELAY,
        ports=(Port("delay_msec", _MILLISECONDS),),
        slot="steps",
    ),
    _decorator(
        *(
            "Timeout",
            "Fails if its child still runs after some simulated time.",
        ),
        op.TIMEOUT,
        ports=(Port("msec", _MILLISECONDS),),
        slot="steps",
    ),
    _decorator(
        "TimeDelay",
        "Fails for some simulated time, then ticks its child; of HuNavSim 2.",
        op.TIME_DELAY,
        ports=(Port("delay", _SECONDS, 1.0), Port("again", bool, False)),
        slot="steps",
        kept=("steps",),
    ),
    _node(
        *("Decorator", "Cooldown"),
        "Fails for some simulated time after its child succeeds or gives up.",
        op.COOLDOWN,
        ports=(Port("seconds", _SECONDS),),
        slots={"steps left": 0.0, "runs": 0.0},
        kept=("steps left",),
        children=(1, 1),
    ),
    _control(
        "NeedsSelector",
        "Ticks the child that is worth most for the person's needs.",
        op.NEEDS,
        slots={"child": 0.0},
        is_social=True,
    ),
    _node(
        *("Decorator", "Satisfies"),
        "Raises the level of a need when its child succeeds.",
        op.SATISFIES,
        ports=(
            Port("need", _NEED),
            Port("amount", _AMOUNT),
            Port("weight", _WEIGHT, 1.0),
            Port("place", Annotated[str, Meaning.PLACE], ""),
        ),
        children=(1, 1),
        is_social=True,
    ),
    _node("Action", "AlwaysSuccess", "Succeeds.", op.GIVE, SUCCESS),
    _node("Action", "AlwaysFailure", "Fails.", op.GIVE, FAILURE),
    _node(
        *("Action", "SetBlackboard"),
        "Sets a blackboard entry to a number, boolean, text or other entry.",
        op.SET,
        ports=(Port("value", Any), Port("output_key", Any, output=True)),
    ),
)


# Those that BehaviorTree.CPP does not have.
FURTHER_NODES = ("TimeDelay", "Cooldown", "NeedsSelector", "Satisfies")


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


def check_needs(node: Node) -> None:
    """Checks what is under NeedsSelector, if the node is one.

    Raises:
        BehaviorTreeError: If a child is no Satisfies, or has a place that is
            set later.
    """
    if node.type.operation.code != op.NEEDS:
        return
    for child in node.children:
        if child.type.operation.code != op.SATISFIES:
            raise child.error(
                "a child of NeedsSelector must be a Satisfies, got"
                f" {child.type.name}; write Satisfies around it"
            )
        if child.constant("place") is None:
            raise child.error(
                "port place: must be the name of a place, not an entry that is"
                " set later; write the name"
            )
