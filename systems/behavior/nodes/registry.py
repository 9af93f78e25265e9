"""The registered node types, and the registration of users' leaves.

A leaf is a function. Its first parameter is the `TickContext`; its keyword-only
parameters are the ports, with their types and defaults; a leaf that remembers
takes its own numbers as a list in a second parameter::

    @register_condition("IsLate", memory={"ticks": 0.0})
    def is_late(context, own, *, seconds: float = 10.0) -> bool:
        own[0] += 1
        return own[0] * context.person.time_step >= seconds

A condition returns whether it holds, as a bool or as SUCCESS or FAILURE; an
action returns a `NodeStatus`, or nothing for SUCCESS. A leaf can also be an
object with a method `__call__`, its class, of which one object is made, or a
`functools.partial`, whose keywords are then no ports. A leaf must keep nothing
elsewhere, so that a tick depends only on the state and the inputs.
"""

from collections.abc import Callable, Iterable, Mapping
import dataclasses
import functools
import inspect
import math
from numbers import Real
import re
from types import MappingProxyType
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from hunav_drake.systems.behavior.nodes.compiled_leaf import CompiledLeaf
from hunav_drake.systems.behavior.nodes.language_nodes import LANGUAGE_NODES
from hunav_drake.systems.behavior.nodes.leaf import build_leaf
from hunav_drake.systems.behavior.nodes.node import Category, NodeType
from hunav_drake.systems.behavior.nodes.operations import (
    ACTION,
    CONDITION,
    PYTHON,
    Operation,
)
from hunav_drake.systems.behavior.nodes.port import Meaning, Port
from hunav_drake.systems.behavior.nodes.program import RUNNING_SLOT

F = TypeVar("F", bound=Callable[..., Any])

_TYPES: dict[str, NodeType] = {it.name: it for it in LANGUAGE_NODES}
# All registered node types, read-only.
NODE_TYPES: Mapping[str, NodeType] = MappingProxyType(_TYPES)

# Other spellings in files of BehaviorTree.CPP 3.
ALIASES: Mapping[str, str] = MappingProxyType(
    {
        "SequenceStar": "SequenceWithMemory",
        "RetryUntilSuccesful": "RetryUntilSuccessful",
    }
)

# Ports that have other names in BehaviorTree.CPP 3, or in HuNavSim 2.
PORT_ALIASES: Mapping[tuple[str, str], str] = MappingProxyType(
    {
        ("Parallel", "success_threshold"): "success_count",
        ("Parallel", "failure_threshold"): "failure_count",
        ("StopAndWaitTimerAction", "time_duration"): "wait_duration",
        ("ScaredNav", "runaway_vel"): "speed",
        ("ScaredNav", "scary_force_factor"): "push",
        ("CuriousNav", "agent_vel"): "speed",
        ("ThreateningNav", "goal_dist"): "goal_distance",
        # (No parameter of a function can have the first of these names.)
        ("TimeOfTrial", "from"): "start",
        ("TimeOfTrial", "to"): "end",
    }
)

# Nodes that are others in HuNavSim 2, which their attributes tell.
NODES_BY_PORT: Mapping[tuple[str, str], str] = MappingProxyType(
    dict.fromkeys(
        (
            ("BlockRobot", "front_dist"),
            ("BlockRobot", "max_vel"),
            ("BlockRobot", "duration"),
        ),
        "StayInFrontOfRobot",
    )
)

# Elements whose attribute ID names the node, and those that tick a tree.
GENERIC_TAGS = ("Action", "Condition", "Control", "Decorator")
SUBTREE_TAGS = ("SubTree", "SubTreePlus")

# The words of the tree language itself.
RESERVED = frozenset(
    ("root", "Root", "BehaviorTree", "TreeNodesModel", "include")
).union(GENERIC_TAGS, SUBTREE_TAGS)


# Attributes that no port can have.
_TAKEN = ("name", "ID")


def register_condition(
    name: str,
    *,
    memory: Mapping[str, float] | None = None,
    ignored: Iterable[str] = (),
    social: bool = False,
    replace: bool = False,
) -> Callable[[F], F]:
    """Registers a function as a condition.

    Args:
        name: The name of the XML element.
        memory: The names and initial values of the numbers that the condition
            remembers for as long as the tree lives.
        ignored: Attributes that are accepted and have no effect.
        social: Whether it takes notice of what people show each other: see
            `nodes.social`. Only compiled leaves can.
        replace: Whether the name may be that of another leaf, which is then
            forgotten; trees that are loaded already keep it. It is not needed
            for code that runs again: a function of the same module and name,
            or of a cell of a notebook.

    Raises:
        ValueError: If the name is that of another leaf, without `replace`, or
            that of a node of the language; or if the name, a parameter or the
            memory is invalid.
    """
    return _decorator(name, "Condition", memory, ignored, social, replace)


def register_action(
    name: str,
    *,
    memory: Mapping[str, float] | None = None,
    ignored: Iterable[str] = (),
    social: bool = False,
    replace: bool = False,
) -> Callable[[F], F]:
    """Registers a function as an action.

    Args:
        name: The name of the XML element.
        memory: The names and initial values of the numbers that the action
            remembers. They are reset when the action is halted while RUNNING.
        ignored: Attributes that are accepted and have no effect.
        social: As for `register_condition`.
        replace: As for `register_condition`.

    Raises:
        ValueError: As for `register_condition`.
    """
    return _decorator(name, "Action", memory, ignored, social, replace)


def _decorator(
    name: str,
    category: Category,
    memory: Mapping[str, float] | None,
    ignored: Iterable[str],
    social: bool,
    replace: bool,
) -> Callable[[F], F]:
    if not isinstance(name, str):
        raise ValueError(
            f"the name of a leaf is a text, got {name!r:.80}; write"
            f' @register_{category.lower()}("Name") above it'
        )
    if isinstance(ignored, str):
        raise ValueError(
            f"{name}: ignored must be several names, got the text {ignored!r};"
            f" write [{ignored!r}]"
        )
    if not isinstance(memory or {}, Mapping) or not all(
        isinstance(it, Real) and not math.isnan(it)
        for it in (memory or {}).values()
    ):
        raise ValueError(
            f"{name}: memory must be names with their initial numbers, as"
            f" {{'seconds': 0.0}}, got {memory!r:.80}"
        )

    def register(function: F) -> F:
        node_type = make_leaf_type(
            name, category, function, dict(memory or {}), frozenset(ignored)
        )
        node_type = dataclasses.replace(node_type, is_social=social)
        existing = _TYPES.get(name)
        is_language = existing is not None and existing.function is None
        if is_language or name in RESERVED or name in ALIASES:
            raise ValueError(f"the node name {name!r} is taken; choose another")
        if existing and not replace:
            _check_runs_again(name, existing.function, function)
        _TYPES[name] = node_type
        return function

    return register


def _check_runs_again(name: str, old: Any, new: Any) -> None:
    """Checks that a leaf is the registered one, from code that runs again."""
    if new is old:
        return

    def taken(by: str) -> ValueError:
        return ValueError(
            f"the node name {name!r} is taken by {by}; choose another, or pass"
            " replace=True"
        )

    before, after = _original(old), _original(new)
    if after.__module__ != before.__module__:
        raise taken(f"a leaf of {before.__module__}")
    # Code that runs again creates new objects.
    if _code(new) is _code(old):
        raise taken("another leaf of the same function or class")
    if _definition(after) == _definition(before):
        return
    # A changed cell has another file; typed code has a name such as <stdin>.
    file = _file(before)
    typed_in = file.startswith("<") or file != _file(after)
    if before.__module__ != "__main__" or not typed_in:
        raise taken(f"{before.__qualname__} of {before.__module__}")


def _definition(original: Any) -> tuple[str, int]:
    """Returns the name and, for a lambda, the line of a definition."""
    name: str = original.__qualname__
    # (Functions without a name all have the same.)
    nameless = name.endswith("<lambda>")
    return name, original.__code__.co_firstlineno if nameless else 0


def _file(original: Any) -> str:
    """Returns the file that defines a function or class."""
    function = original.__call__ if isinstance(original, type) else original
    code = getattr(function, "__code__", None)
    return code.co_filename if code else "<unknown>"


def _original(function: Any) -> Any:
    """Returns the function or class that defines a leaf."""
    while isinstance(function, functools.partial):
        function = function.func
    return function if hasattr(function, "__qualname__") else type(function)


def _code(function: Any) -> Any:
    """Returns an object that is created anew when the code runs again."""
    original = _original(function)
    return getattr(original, "__code__", original)


def make_leaf_type(
    name: str,
    category: Category,
    function: Callable[..., Any],
    memory: dict[str, float],
    ignored: frozenset[str],
) -> NodeType:
    """Returns the node type of a leaf, without registering it.

    Args:
        name: The name of the XML element.
        category: "Action" or "Condition".
        function: The function of the leaf: see `register_action`.
        memory: The names and initial values of the numbers it remembers.
        ignored: Attributes that are accepted and have no effect.

    Raises:
        ValueError: If the name or a parameter is invalid.
    """
    if not re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII):
        raise ValueError(f"a node name is letters and digits, got {name!r}")
    if not callable(function):
        raise ValueError(
            f"{name}: a leaf is a function, or an object that can be called,"
            f" got {function!r}"
        )
    original = _original(function)
    leaf = function
    if isinstance(function, type):
        # The leaf is an object of the class.
        try:
            leaf = function()
        except TypeError as error:
            raise ValueError(
                f"{name}: no object of {function.__name__} can be made without"
                f" arguments ({error}); register one that you make"
            ) from error
    hints = get_type_hints(
        original.__call__ if isinstance(original, type) else original,
        include_extras=True,
    )
    fixed = leaf.keywords if isinstance(leaf, functools.partial) else {}
    # (Compiled functions have no parameters by keyword only.)
    is_compiled = hasattr(function, "py_func")
    expected = 2 if memory else 1
    positional = 0
    ports = {}
    for parameter in inspect.signature(leaf).parameters.values():
        if parameter.name in fixed:
            continue
        if is_compiled and positional == expected:
            ports[parameter.name] = _port(name, parameter, hints)
            continue
        match parameter.kind:
            case parameter.POSITIONAL_ONLY | parameter.POSITIONAL_OR_KEYWORD:
                positional += 1
            case parameter.KEYWORD_ONLY:
                ports[parameter.name] = _port(name, parameter, hints)
            case _:
                raise ValueError(
                    f"{name}: *{parameter.name} cannot be a port; name each"
                    " port"
                )
    if positional != expected:
        raise ValueError(
            f"{name}: the function must take {expected} positional"
            f" parameters (the tick context{', its memory' if memory else ''})"
            f" and its ports after a *, got {positional} positional"
        )
    both = sorted(ignored & ports.keys())
    if both:
        raise ValueError(
            f"{name}: {both[0]} is a port, and cannot be ignored as well"
        )
    if memory and category == "Action":
        memory = {RUNNING_SLOT: 0.0, **memory}
    code = ACTION if category == "Action" else CONDITION
    return NodeType(
        name,
        category,
        Operation(code if is_compiled else PYTHON),
        (inspect.getdoc(original) or "").partition("\n")[0],
        ports=ports,
        ignored=ignored,
        slots=memory,
        kept=() if category == "Action" else tuple(memory),
        source=f"{original.__module__}.{original.__qualname__}",
        function=function,
        leaf=CompiledLeaf(function, len(ports), expected == 2)
        if is_compiled
        else None,
        build=None if is_compiled else functools.partial(build_leaf, leaf),
    )


def _port(
    name: str, parameter: inspect.Parameter, hints: Mapping[str, Any]
) -> Port:
    if parameter.name in _TAKEN or parameter.name.startswith("_"):
        raise ValueError(
            f"{name}: no port can be called {parameter.name!r}: the attributes"
            f" {' and '.join(_TAKEN)} of a node, and those that begin with _,"
            " have meanings of their own; choose another name"
        )
    annotation = hints.get(parameter.name)
    is_annotated = hasattr(annotation, "__metadata__")
    base = get_args(annotation)[0] if is_annotated else annotation
    literal = get_origin(base) is Literal and all(
        isinstance(choice, str) for choice in get_args(base)
    )
    if base not in (float, int, bool, str) and not literal:
        raise ValueError(
            f"{name}: port {parameter.name} must be annotated as float, int,"
            f" bool, str or a Literal of texts, got {annotation}"
        )
    port = Port(parameter.name, annotation)
    if parameter.default is parameter.empty:
        return port
    return dataclasses.replace(
        port,
        default=port.check(parameter.default),
        output=port.meaning is Meaning.RESULT,
    )
