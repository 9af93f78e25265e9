"""Transfers the state of a trial to the diagram of another one."""

from collections.abc import Iterator
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context, Diagram, InputPort, System

from hunav_drake.scenario.fleet import robot_parts
from hunav_drake.scenario.writer import plain
from hunav_drake.systems.common.suggest import shown
from hunav_drake.systems.people.profile import complete_people
from hunav_drake.systems.sensing.sensor_config import name_sensors
from hunav_drake.trial.context_layout import (
    Storable,
    abstract_states,
    free_ports,
    leaves,
    memory,
    vectors,
)
from hunav_drake.trial.seeds import CheckIsTrial, GetTrialSeed, SeededSystems

# What a system may become in a diagram whose people may leave.
_OPENED = {"HumanCrowd": "OpenCrowd", "BehaviorTree": "OpenBehaviorTree"}

_PARTS: "WeakKeyDictionary[Diagram, _Parts]" = WeakKeyDictionary()


def TransferContext(
    diagram: Diagram, context: Context, other: Diagram
) -> Context:
    """Returns a Context of another diagram at the same time.

    So a trial continues with another planner, other walls or another motion
    model, to answer "what if". People, robot, recording, goal and fixed values
    of input ports that are not connected keep their state, bit for bit.
    Planner, perception and sensors keep theirs if kind and parameters are the
    same, and a localization its error, if both diagrams have one. Otherwise
    they start anew, a planner with the last command to the robot.

    Args:
        diagram: The diagram of the trial, from `MakeTrialDiagram`.
        context: Its root Context; it is not changed.
        other: The diagram to continue with, from `MakeTrialDiagram`: of a
            scenario with the same people, robot, goal, evaluator and time
            step; its people may be such as may leave (`may_leave`).

    Returns:
        A root Context of `other`, with the time, state, parameters and fixed
        inputs of the systems that both have by name.

    Raises:
        ValueError: If the scenarios differ in one of these parts; if a system
            with a state, other than those of planner and sensors, exists in
            one diagram only, or differs so that its state has no meaning; if
            an input port with a fixed value does; or if `context` does not
            belong to `diagram`.
    """
    CheckIsTrial(diagram)
    CheckIsTrial(other)
    diagram.ValidateContext(context)
    was, now = _parts(diagram), _parts(other)
    same = was.given == now.given
    difference = "" if same else _first_difference(was.given, now.given, "")
    if difference:
        raise ValueError(
            f"{difference[1:]}; the state cannot be taken over. Make the other"
            " diagram of the same people, robot, goal, evaluator and time step;"
            " if walls affect the drawn people, list the people under humans."
        )
    result = other.CreateDefaultContext()
    result.SetTime(context.get_time())
    sources = {_path(system): system for _, system in leaves(diagram)}
    targets = {_path(system): system for _, system in leaves(other)}
    kept = set()
    for path in dict.fromkeys([*sources, *targets]):
        source, target = sources.get(path), targets.get(path)
        difference = ""
        if target is None:
            if _has_state(source, context):
                difference = (
                    f"it was a {type(source).__name__}, and no longer exists"
                )
        elif source is None:
            if _has_state(target, result):
                difference = (
                    f"it is a {type(target).__name__}, and did not exist"
                )
        else:
            old = source.GetMyContextFromRoot(context)
            new = target.GetMyMutableContextFromRoot(result)
            difference = _difference(source, old, target, new)
            part = path.split("/")[0]
            if not memory(source) and was.own.get(part) != now.own.get(part):
                difference = difference or "its parameters differ"
            if not difference:
                _copy(old, new)
                kept.add(path)
        if difference and not _begins_anew(path, other):
            raise ValueError(
                f"{path} cannot be taken over: {difference}. Make the other"
                " diagram of the same people, robot, goal and evaluator."
            )
    # What is new, and has noise, has that of the trial.
    seed = GetTrialSeed(diagram, context)
    for system in SeededSystems(other):
        if _path(system) not in kept:
            system.SetSeed(system.GetMyMutableContextFromRoot(result), seed)
    for prefix in other.prefixes.values():
        name = f"{prefix}planner"
        planner = other.GetSubsystemByName(name)
        if name not in kept and hasattr(planner, "SetCommand"):
            port = diagram.GetOutputPort(f"{prefix}velocity_command")
            own = planner.GetMyMutableContextFromRoot(result)
            planner.SetCommand(own, port.Eval(context))
    _fix_inputs(diagram, context, other, result)
    return result


class _Parts(NamedTuple):
    """The parts of a scenario as plain values.

    Attributes:
        given: Those whose state is transferred.
        own: The parameters of planners and sensors, by their systems.
    """

    given: dict[str, Any]
    own: dict[str, Any]


def _parts(diagram: Diagram) -> _Parts:
    """Returns the parts of a diagram's scenario, made once.

    (They take half of the time of a transfer, and branches begin with one.)
    """
    if diagram not in _PARTS:
        _PARTS[diagram] = _Parts(_given(diagram), _own_parameters(diagram))
    return _PARTS[diagram]


def _given(diagram: Diagram) -> dict[str, Any]:
    """Returns the parts of a scenario whose state is transferred."""
    scenario = diagram.scenario
    # (What the profile gives people, as their weights, is in the Context.)
    people = complete_people(diagram.humans, scenario.crowd.profile)
    return {
        "humans": plain(scenario.humans),
        "population": plain(scenario.population),
        "drawn": plain(diagram.humans[len(scenario.humans) :]),
        "people by crowd.profile": [
            {"cyclic": it.cyclic, "forces": plain(it.forces)} for it in people
        ],
        **{
            f"robot {it.name}".strip(): plain(it.scenario.robot)
            for it in robot_parts(scenario)
        },
        # (Who watches all robots has their states in this order.)
        "robots": [it.name for it in robot_parts(scenario)],
        "evaluator": plain(scenario.evaluator),
        "time_step": scenario.simulation.time_step,
    }


def _own_parameters(diagram: Diagram) -> dict[str, Any]:
    """Returns the parameters of planners and sensors, by their systems."""
    found = {}
    for part in robot_parts(diagram.scenario):
        planner = part.scenario.planner
        found[f"{part.prefix}planner"] = plain(planner)
        for name in ("perception", "perception_delay"):
            found[f"{part.prefix}{name}"] = plain(planner.sees)
        sensors = part.scenario.sensors
        for name, sensor in zip(name_sensors(sensors), sensors, strict=True):
            found[f"{part.prefix}sensor_{name}"] = plain(sensor)
    return found


def _first_difference(was: Any, now: Any, path: str) -> str:
    """Returns the first difference of plain values, and its place, or ""."""
    if isinstance(was, dict) and isinstance(now, dict):
        keys = dict.fromkeys([*was, *now])
        pairs = [(f".{key}", was.get(key), now.get(key)) for key in keys]
    elif isinstance(was, list) and isinstance(now, list):
        if len(was) != len(now):
            return f"{path}: there were {len(was)}, and are {len(now)}"
        pairs = [
            (f"[{i}]", *pair)
            for i, pair in enumerate(zip(was, now, strict=True))
        ]
    else:
        told = f"{path}: it was {shown(was)}, and is {shown(now)}"
        return "" if was == now else told
    found = (_first_difference(a, b, path + key) for key, a, b in pairs)
    return next(filter(None, found), "")


def _begins_anew(path: str, diagram: Diagram) -> bool:
    """Returns whether a system may differ and start anew."""
    part = path.split("/")[0]
    names = ("planner", "perception", "perception_delay", "localization")
    return any(
        part.removeprefix(prefix) in names
        or part.removeprefix(prefix).startswith("sensor_")
        for prefix in ("", *diagram.prefixes.values())
    )


def _path(system: System) -> str:
    """Returns the path of a system below the root, as "humans/crowd"."""
    return str(system.GetSystemPathname()).split("::", 2)[-1].replace("::", "/")


def _difference(
    source: System, old: Context, target: System, new: Context
) -> str:
    """Returns why a state does not fit another system, or "" if it does."""
    kinds = type(source).__name__, type(target).__name__
    opened = _OPENED.get(kinds[0]) == kinds[1]
    if kinds[0] != kinds[1] and not opened:
        return f"it was a {kinds[0]}, and is a {kinds[1]}"
    for was, now in zip(memory(source), memory(target), strict=False):
        if was != now:
            return f"it was {was}, and is {now}"
    if _joints(source) != _joints(target):
        return "its bodies move by other joints"
    sizes = [
        {name: vector.size() for name, vector in vectors(context)}
        for context in (old, new)
    ]
    if opened:
        # What it has besides is as at the start.
        sizes[1] = {name: sizes[1].get(name, 0) for name in sizes[0]}
    if sizes[0] != sizes[1]:
        return f"its numbers were {sizes[0]}, and are {sizes[1]}"
    if old.num_abstract_states() != new.num_abstract_states():
        return "it remembers other things"
    return ""


def _has_state(system: System, root_context: Context) -> bool:
    """Returns whether a leaf has a state or parameters."""
    context = system.GetMyContextFromRoot(root_context)
    numbers = any(True for _ in vectors(context))
    return numbers or context.num_abstract_states() > 0


def _joints(system: System) -> list[str]:
    """Returns the names of a plant's coordinates; none for other systems."""
    if not isinstance(system, MultibodyPlant):
        return []
    return [*system.GetPositionNames(), *system.GetVelocityNames()]


def _copy(old: Context, new: Context) -> None:
    """Copies the state and the parameters of a leaf's Context."""
    values = dict(vectors(old))
    for name, vector in vectors(new, mutable=True):
        if name in values:
            vector.SetFromVector(values[name].CopyToVector())
    for i, value in abstract_states(old):
        if isinstance(value, Storable):
            new.SetAbstractState(i, value)
        else:
            # (A copy, as in a clone.)
            part = new.get_mutable_abstract_state(i)
            part.SetFrom(old.get_abstract_state(i))


def _fix_inputs(
    diagram: Diagram, context: Context, other: Diagram, result: Context
) -> None:
    """Copies the fixed values of input ports to the other diagram."""
    targets = dict(_ports(other))
    for name, port in _ports(diagram):
        own = port.get_system().GetMyContextFromRoot(context)
        if not port.HasValue(own) or _begins_anew(name, diagram):
            continue
        target = targets.get(name)
        if target is None or (
            (target.get_data_type(), target.size())
            != (port.get_data_type(), port.size())
        ):
            raise ValueError(
                f"the input {name} has a fixed value, and the other diagram no"
                " such input; make it alike, or do not fix the input"
            )
        target.FixValue(
            target.get_system().GetMyMutableContextFromRoot(result),
            port.Eval(own),
        )


def _ports(diagram: Diagram) -> Iterator[tuple[str, InputPort]]:
    """Yields the input ports that may have fixed values, with their paths.

    Inputs of the diagram itself have their bare names.
    """
    for _, port in free_ports(diagram):
        system = port.get_system()
        prefix = "" if system is diagram else f"{_path(system)}/"
        yield prefix + port.get_name(), port
