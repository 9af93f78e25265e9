"""Takes the state of one trial over into the diagram of another."""

from pydrake.systems.framework import Context, Diagram, System

from hunav_drake.context_layout import (
    Remembering,
    abstract_states,
    leaves,
    vectors,
)


def TransferContext(
    diagram: Diagram, context: Context, other: Diagram
) -> Context:
    """Returns a Context of another diagram, at the same instant.

    So a trial goes on with another planner, other walls or another motion
    model: what if? People, robot, recording and goal are as they were, bit for
    bit. A planner of the same kind and parameters goes on as it was; another
    one begins anew, with the command that the robot has just got.

    Args:
        diagram: The diagram of the trial, by `MakeTrialDiagram`.
        context: Its root Context; it is not changed.
        other: The diagram to go on with: of the same people, robot and
            evaluator.

    Returns:
        A root Context of `other`, with the time, state and parameters of the
        systems that both have by name.

    Raises:
        ValueError: If a system of both, but for the planner, is another one,
            so that its state has no meaning there, or if `context` is not of
            `diagram`.
    """
    diagram.ValidateContext(context)
    result = other.CreateDefaultContext()
    result.SetTime(context.get_time())
    known = {_path(system): system for _, system in leaves(diagram)}
    for _, target in leaves(other):
        path = _path(target)
        source = known.get(path)
        if source is None:
            continue
        old = source.GetMyContextFromRoot(context)
        new = target.GetMyMutableContextFromRoot(result)
        difference = _difference(source, old, target, new)
        if not difference:
            _copy(source, old, new)
        elif path.split("/")[0] == "planner":
            _take_over_command(old, new)
        else:
            raise ValueError(
                f"{path} cannot be taken over: {difference}. Make the other"
                " diagram of the same people, robot and evaluator."
            )
    return result


def _path(system: System) -> str:
    """Returns where a system is, below the root, as "humans/crowd"."""
    return str(system.GetSystemPathname()).split("::", 2)[-1].replace("::", "/")


def _difference(
    source: System, old: Context, target: System, new: Context
) -> str:
    """Returns how two systems differ, or nothing: then states fit."""
    kinds = type(source).__name__, type(target).__name__
    if kinds[0] != kinds[1]:
        return f"it was a {kinds[0]}, and is a {kinds[1]}"
    if isinstance(source, Remembering) and isinstance(target, Remembering):
        for was, now in zip(
            source.DescribeMemory(), target.DescribeMemory(), strict=False
        ):
            if was != now:
                return f"it was {was}, and is {now}"
    sizes = [
        {name: vector.size() for name, vector in vectors(context)}
        for context in (old, new)
    ]
    if sizes[0] != sizes[1]:
        return f"its numbers were {sizes[0]}, and are {sizes[1]}"
    if old.num_abstract_states() != new.num_abstract_states():
        return "it remembers other things"
    return ""


def _copy(source: System, old: Context, new: Context) -> None:
    """Copies what `SaveContext` keeps of a leaf."""
    values = dict(vectors(old))
    for name, vector in vectors(new, mutable=True):
        vector.SetFromVector(values[name].CopyToVector())
    for i, value in abstract_states(source, old):
        new.SetAbstractState(i, value)


def _take_over_command(old: Context, new: Context) -> None:
    """Lets a planner begin with the command (v, omega) of the one before."""
    groups = [
        context.num_discrete_state_groups()
        and context.get_discrete_state(0).size() == 3
        for context in (old, new)
    ]
    if all(groups):
        command = old.get_discrete_state(0).value()[:2]
        new.get_mutable_discrete_state(0).get_mutable_value()[:2] = command
