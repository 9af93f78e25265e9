"""Saves a Context to a file, and loads it."""

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import Context, Diagram, PortDataType, System

from hunav_drake.systems.behavior import BehaviorTree
from hunav_drake.systems.common.files import atomic_write, read_arrays
from hunav_drake.systems.common.suggest import shown
from hunav_drake.systems.evaluation.recording_checks import LARGEST
from hunav_drake.trial.context_layout import (
    Checking,
    free_ports,
    layout,
    leaves,
    misfit,
    stored_states,
    vectors,
)

_FORMAT = "hunav_drake context 4"

# The part of the state of a behavior tree that is its memory.
_MEMORY = "discrete/0"

# Modules of systems whose numbers are in SI units, within a recording's limits.
_OWN = ("hunav_drake.", "pydrake.systems.primitives")

Array = NDArray[Any]


def SaveContext(
    diagram: Diagram, context: Context, filename: str | Path
) -> Path:
    """Writes a Context to a file, bit for bit.

    The file (.npz) holds the time, the state and the numeric parameters of all
    systems, including the recording of an Evaluator, and the fixed values of
    input ports that are not connected (Drake does not tell values that are
    fixed in place of a connection, so they are lost). It does not hold the
    diagram: keep the scenario, or the code, with it. It does not hold abstract
    parameters, such as the geometry of a scene, or the outputs of a discrete
    MultibodyPlant on its last step, such as contacts, which are available again
    after the next step.

    Args:
        diagram: The root diagram.
        context: Its Context.
        filename: The file to write.

    Returns:
        The file.

    Raises:
        ValueError: If a system has an abstract state that is not `Storable`,
            an input port has a fixed abstract value, or a number of the state
            or a parameter is not finite although its default is.
        OSError: If the file cannot be written.
    """
    arrays = _arrays(diagram, context)
    arrays["sha256"] = np.array(_digest(arrays))
    path = Path(filename)
    with atomic_write(path) as file:
        # (Older NumPy would write `allow_pickle` as an array, if given; mypy
        # takes the arrays for it.)
        np.savez(file, **arrays)  # type: ignore[arg-type]
    return path


def ContextDigest(diagram: Diagram, context: Context) -> str:
    """Returns the SHA-256 hash of what `SaveContext` would write.

    Raises:
        ValueError: If it cannot be saved.
    """
    return _digest(_arrays(diagram, context))


def _arrays(diagram: Diagram, context: Context) -> dict[str, Array]:
    """Returns the content of a file."""
    arrays = {
        "format": np.array(_FORMAT),
        "time": np.array(context.get_time()),
        "systems": np.array(json.dumps(layout(diagram, context))),
    }
    for key, port in free_ports(diagram):
        own = port.get_system().GetMyContextFromRoot(context)
        if port.HasValue(own):
            if port.get_data_type() == PortDataType.kAbstractValued:
                raise ValueError(
                    f"{port.GetFullDescription()} has a fixed value that is"
                    " abstract, which cannot be saved"
                )
            arrays[key] = port.Eval(own)
    default = diagram.CreateDefaultContext()
    for key, system in leaves(diagram):
        own = system.GetMyContextFromRoot(context)
        defaults = dict(vectors(system.GetMyContextFromRoot(default)))
        for name, vector in vectors(own):
            values = vector.CopyToVector()
            _check_values(system, name, values, defaults[name].CopyToVector())
            arrays[f"{key}/{name}"] = values
        for i, value in stored_states(system, own):
            for name, array in value.to_arrays().items():
                arrays[f"{key}/abstract/{i}/{name}"] = array
    return arrays


def LoadContext(diagram: Diagram, filename: str | Path) -> Context:
    """Reads a Context that `SaveContext` wrote.

    State and parameters, such as the goal of a trial, come from the file. All
    else comes from the diagram: a trial can continue with other walls or
    another motion model. Planners and behavior trees must be the saved ones,
    because no others can use their memory.

    Args:
        diagram: A diagram of the same systems as the saved one: for a trial,
            from `MakeTrialDiagram` with the same scenario.
        filename: The file.

    Returns:
        A Context of the diagram, equal to the saved one.

    Raises:
        ValueError: If the file is not a saved Context, its systems are not
            those of the diagram, or it is damaged.
        OSError: If the file cannot be read.
    """
    path = Path(filename)
    arrays = read_arrays(path, "a Context written by SaveContext")
    known = str(arrays.get("format"))
    if known != _FORMAT:
        raise ValueError(
            f"{path}: is not a Context written by SaveContext of this version:"
            f" the format must be {_FORMAT!r}, got {shown(known)}"
        )
    context = diagram.CreateDefaultContext()
    intact = str(arrays.pop("sha256", "")) == _digest(arrays)
    if intact:
        try:
            saved = json.loads(str(arrays["systems"]))
        except (LookupError, ValueError, RecursionError):
            saved = None
        found = misfit(saved, layout(diagram, context))
        if found:
            raise ValueError(
                f"{filename}: {found}. Make the diagram as it was made when"
                " the Context was saved."
            )
    remedy = "Save the Context once more, or take a copy of the file."
    try:
        _fill(diagram, context, arrays)
    except ValueError as error:
        raise ValueError(
            f"{filename}: is damaged: {error}. {remedy}"
        ) from error
    if not intact:
        raise ValueError(
            f"{filename}: is damaged: its content is not what SaveContext"
            f" wrote. {remedy}"
        )
    return context


def _fill(diagram: Diagram, context: Context, arrays: dict[str, Array]) -> None:
    """Sets a Context to the content of a file; a ValueError has the fault."""
    time = _numbers(arrays, "time", ())
    if not np.isfinite(time):
        raise ValueError(f"the time must be finite, got {time} s")
    if abs(time) > LARGEST:
        raise ValueError(f"the time must be at most {LARGEST:g} s, got {time}")
    context.SetTime(float(time))
    for key, port in free_ports(diagram):
        if key in arrays:
            own = port.get_system().GetMyMutableContextFromRoot(context)
            port.FixValue(own, _numbers(arrays, key, (port.size(),)))
    for key, system in leaves(diagram):
        own = system.GetMyMutableContextFromRoot(context)
        for name, vector in vectors(own, mutable=True):
            values = _numbers(arrays, f"{key}/{name}", (vector.size(),))
            _check_values(system, name, values, vector.CopyToVector())
            vector.SetFromVector(values)
        place = system.GetSystemPathname()
        if isinstance(system, Checking):
            try:
                system.CheckContext(own)
            except ValueError as error:
                raise ValueError(f"{place}: {error}") from error
        for i, value in stored_states(system, own):
            head = f"{key}/abstract/{i}/"
            stored = {
                name.removeprefix(head): array
                for name, array in arrays.items()
                if name.startswith(head)
            }
            try:
                state = value.from_arrays(stored)
            except (LookupError, TypeError, ValueError) as error:
                raise ValueError(f"{place}: {error}") from error
            own.SetAbstractState(i, state)
    for _, system in leaves(diagram):
        if isinstance(system, BehaviorTree):
            _check_tick(system, system.GetMyContextFromRoot(context))


def _check_tick(system: BehaviorTree, context: Context) -> None:
    """Checks that a tree can use its memory, which only its leaves know."""
    inputs = map(system.get_input_port, range(system.num_input_ports()))
    needed = (it for it in inputs if it.get_name() != "robot_signals")
    if not all(port.HasValue(context) for port in needed):
        return
    try:
        for i in range(system.num_output_ports()):
            system.get_output_port(i).Eval(context)
    except Exception as error:
        raise ValueError(
            f"{system.GetSystemPathname()}: a tick with its memory fails:"
            f" {type(error).__name__}: {error}"
        ) from error


def _numbers(
    arrays: dict[str, Array], key: str, shape: tuple[int, ...]
) -> Array:
    """Returns a float64 array of the file; checks its shape."""
    array = arrays.get(key)
    if array is None:
        raise ValueError(f"it has no entry {key!r}")
    if array.shape != shape or array.dtype != np.float64:
        raise ValueError(
            f"the entry {key!r} must be float64 of shape {shape}, got"
            f" {array.dtype} of shape {array.shape}"
        )
    return array


def _check_values(
    system: System, name: str, values: Array, default: Array
) -> None:
    """Checks that numbers are finite where their defaults are.

    Behavior trees have their own rule.
    """
    try:
        if isinstance(system, BehaviorTree):
            # (They may count more ticks than the limit below.)
            if name == _MEMORY:
                system.CheckMemory(values)
            else:
                system.CheckSignals(values)
            return
        bad = np.flatnonzero(~np.isfinite(values) & np.isfinite(default))
        if bad.size:
            raise ValueError(
                f"must be finite, but number {bad[0]} is {values[bad[0]]}"
            )
        # There is no limit for numbers of user-defined systems.
        if type(system).__module__.startswith(_OWN):
            known = np.isfinite(values) & ~(np.abs(default) > LARGEST)
            bad = np.flatnonzero(known & (np.abs(values) > LARGEST))
            if bad.size:
                raise ValueError(
                    f"must be at most {LARGEST:g} in size, but number {bad[0]}"
                    f" is {values[bad[0]]}"
                )
    except ValueError as error:
        raise ValueError(
            f"{system.GetSystemPathname()}: {name}: {error}"
        ) from error


def _digest(arrays: dict[str, Array]) -> str:
    """Returns a hash of the content of a file."""
    digest = hashlib.sha256()
    for name, array in sorted(arrays.items()):
        head = f"{name} {array.dtype.str} {array.shape}\n"
        digest.update(head.encode() + array.tobytes())
    return digest.hexdigest()
