"""A Context in a file: to stop a trial today and to go on tomorrow."""

from collections.abc import Iterator
import hashlib
import json
from pathlib import Path
from typing import Any, Protocol, runtime_checkable
import zipfile

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import (
    Context,
    Diagram,
    InputPort,
    InputPortIndex,
    PortDataType,
    System,
)

from hunav_drake.systems.behavior import BehaviorTree, Tree
from hunav_drake.systems.common.files import atomic_write

_FORMAT = "hunav_drake context 1"


@runtime_checkable
class Storable(Protocol):
    """An abstract state that can be written as arrays, and read back."""

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Returns all that the state is made of, by name."""

    def from_arrays(self, arrays: dict[str, NDArray[Any]]) -> Any:
        """Returns the state that arrays were made of; `self` stays."""


def SaveContext(
    diagram: Diagram, context: Context, filename: str | Path
) -> Path:
    """Writes a Context to a file, bit for bit.

    The file (.npz) holds the time, the state and the numeric parameters of all
    systems, among them the recording of an Evaluator, and the fixed values of
    input ports. It does not hold the diagram: keep the scenario, or the code,
    beside it. Nor does it hold abstract parameters, such as the geometry of a
    scene, nor what the output ports of a discrete MultibodyPlant tell of its
    last step, such as contacts, which they tell again after the next one.

    Args:
        diagram: The root diagram.
        context: Its Context.
        filename: The file to write.

    Returns:
        The file.

    Raises:
        ValueError: If a system has an abstract state that is not `Storable`,
            or an input port has a fixed value that is abstract.
        OSError: If the file cannot be written.
    """
    arrays = {
        "format": np.array(_FORMAT),
        "time": np.array(context.get_time()),
        "systems": np.array(json.dumps(_layout(diagram, context))),
    }
    for key, port in _free_ports(diagram):
        own = port.get_system().GetMyContextFromRoot(context)
        if port.HasValue(own):
            if port.get_data_type() == PortDataType.kAbstractValued:
                raise ValueError(
                    f"{port.GetFullDescription()} has a fixed value that is"
                    " abstract, which cannot be saved"
                )
            arrays[key] = port.Eval(own)
    for key, system in _leaves(diagram):
        own = system.GetMyContextFromRoot(context)
        for name, vector in _vectors(own):
            arrays[f"{key}/{name}"] = vector.value()
        for i, value in _abstract_states(system, own):
            for name, array in value.to_arrays().items():
                arrays[f"{key}/abstract/{i}/{name}"] = array
    path = Path(filename)
    with atomic_write(path) as file:
        np.savez(file, allow_pickle=False, **arrays)
    return path


def LoadContext(diagram: Diagram, filename: str | Path) -> Context:
    """Reads a Context that `SaveContext` wrote.

    What is in the file counts, as the goal of a trial, which is a parameter;
    whatever else is different in the diagram is as it is there: a trial can go
    on among other walls, or with another model of motion.

    Args:
        diagram: A diagram of the same systems as the one that was saved: for a
            trial, by `MakeTrialDiagram` from the same scenario.
        filename: The file.

    Returns:
        A Context of the diagram, equal to the one that was saved.

    Raises:
        ValueError: If the file is not of that kind, or its systems are not
            those of the diagram.
        OSError: If the file cannot be read.
    """
    arrays = _read(Path(filename))
    context = diagram.CreateDefaultContext()
    try:
        saved = json.loads(str(arrays["systems"]))
        misfit = _misfit(saved, _layout(diagram, context))
        if not misfit:
            _fill(diagram, context, arrays)
    except (LookupError, TypeError, ValueError) as error:
        raise ValueError(f"{filename}: is damaged: {error!r}") from error
    if misfit:
        raise ValueError(
            f"{filename}: {misfit}. Make the diagram as it was made when the"
            " Context was saved."
        )
    return context


def _fill(
    diagram: Diagram, context: Context, arrays: dict[str, NDArray[Any]]
) -> None:
    """Sets all of a Context that a file holds.

    Raises:
        LookupError: If something is missing or too short.
    """
    context.SetTime(float(arrays["time"]))
    for key, port in _free_ports(diagram):
        if key in arrays:
            own = port.get_system().GetMyMutableContextFromRoot(context)
            port.FixValue(own, arrays[key])
    for key, system in _leaves(diagram):
        own = system.GetMyMutableContextFromRoot(context)
        for name, vector in _vectors(own, mutable=True):
            vector.SetFromVector(arrays[f"{key}/{name}"])
        for i, value in _abstract_states(system, own):
            head = f"{key}/abstract/{i}/"
            stored = {
                name.removeprefix(head): array
                for name, array in arrays.items()
                if name.startswith(head)
            }
            own.SetAbstractState(i, value.from_arrays(stored))


def _read(path: Path) -> dict[str, NDArray[Any]]:
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = dict(file)
        known = str(arrays.get("format")) == _FORMAT
    except (ValueError, EOFError, zipfile.BadZipFile, AttributeError):
        known = False
    if not known:
        raise ValueError(
            f"{path}: is not a Context written by SaveContext, or is damaged"
        )
    return arrays


def _abstract_states(
    system: System, context: Context
) -> Iterator[tuple[int, Storable]]:
    """Yields the abstract states of a leaf that are kept, by their index.

    Raises:
        ValueError: If there is one that cannot be.
    """
    for i in range(context.num_abstract_states()):
        try:
            value = context.get_abstract_state(i).get_value()
        except RuntimeError as error:
            # What a plant's output ports tell of its last step; the next step
            # does not depend on it.
            if "DiscreteStepMemory" in str(error):
                continue
            value = None
        if not isinstance(value, Storable):
            raise ValueError(
                f"{system.GetSystemPathname()} has an abstract state of type"
                f" {type(value).__name__}, which cannot be saved: it lacks"
                " to_arrays() and from_arrays()"
            )
        yield i, value


def _free_ports(diagram: Diagram) -> Iterator[tuple[str, InputPort]]:
    """Yields the input ports that may have a fixed value, each with a key."""
    for i in range(diagram.num_input_ports()):
        yield f"input/{i}", diagram.get_input_port(i)
    yield from _free_inner_ports(diagram, "")


def _free_inner_ports(
    diagram: Diagram, prefix: str
) -> Iterator[tuple[str, InputPort]]:
    taken = set(diagram.connection_map())
    for i in range(diagram.num_input_ports()):
        taken |= set(diagram.GetInputPortLocators(InputPortIndex(i)))
    for i, system in enumerate(diagram.GetSystems()):
        for k in range(system.num_input_ports()):
            if (system, InputPortIndex(k)) not in taken:
                yield f"{prefix}{i}/input/{k}", system.get_input_port(k)
        if isinstance(system, Diagram):
            yield from _free_inner_ports(system, f"{prefix}{i}.")


def _leaves(diagram: Diagram, prefix: str = "") -> Iterator[tuple[str, System]]:
    """Yields the leaf systems, each with a key that is its place."""
    for i, system in enumerate(diagram.GetSystems()):
        if isinstance(system, Diagram):
            yield from _leaves(system, f"{prefix}{i}.")
        else:
            yield f"{prefix}{i}", system


def _vectors(
    context: Context, *, mutable: bool = False
) -> Iterator[tuple[str, Any]]:
    """Yields the vectors of a leaf's context that have numbers, by name."""
    if context.num_continuous_states():
        state = (
            context.get_mutable_continuous_state_vector()
            if mutable
            else context.get_continuous_state_vector()
        )
        yield "continuous", state
    for i in range(context.num_discrete_state_groups()):
        get = (
            context.get_mutable_discrete_state
            if mutable
            else context.get_discrete_state
        )
        yield f"discrete/{i}", get(i)
    for i in range(context.num_numeric_parameter_groups()):
        get = (
            context.get_mutable_numeric_parameter
            if mutable
            else context.get_numeric_parameter
        )
        yield f"parameter/{i}", get(i)


def _layout(diagram: Diagram, context: Context) -> list[dict[str, Any]]:
    """Returns what each leaf system is, and how many numbers it has."""
    layout = []
    for key, system in _leaves(diagram):
        own = system.GetMyContextFromRoot(context)
        sizes = {name: vector.size() for name, vector in _vectors(own)}
        layout.append(
            {
                "key": key,
                "type": type(system).__name__,
                "path": system.GetSystemPathname(),
                "sizes": sizes,
                "abstract": own.num_abstract_states(),
                "trees": [_tree_layout(tree) for tree in _trees(system)],
            }
        )
    return layout


def _trees(system: System) -> list[Tree]:
    return system.trees() if isinstance(system, BehaviorTree) else []


def _tree_layout(tree: Tree) -> str:
    """Returns which tree it is; equal ones have the same memory."""
    slots = hashlib.sha256("\n".join(tree.slots).encode()).hexdigest()
    return f"{tree.name} ({len(tree.slots)} numbers, {slots[:8]})"


def _misfit(saved: list[dict[str, Any]], present: list[dict[str, Any]]) -> str:
    """Returns what does not fit of a file and a diagram, or nothing."""
    for old, new in zip(saved, present, strict=False):
        for what in ("key", "type", "sizes", "abstract", "trees"):
            if old[what] != new[what]:
                return (
                    f"does not fit the diagram at {new['path']}: {what}"
                    f" {old[what]} in the file, {new[what]} in the diagram"
                )
    if len(saved) != len(present):
        return (
            f"does not fit the diagram: {len(saved)} systems in the file,"
            f" {len(present)} in the diagram"
        )
    return ""
