"""The parts of a Context that are saved and transferred."""

from collections.abc import Iterator
import itertools
import re
from typing import Any, Protocol, runtime_checkable

from numpy.typing import NDArray
from pydrake.systems.framework import (
    Context,
    Diagram,
    InputPort,
    InputPortIndex,
    System,
)


@runtime_checkable
class Storable(Protocol):
    """An abstract state that can be converted to arrays and back."""

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Returns the whole state as named arrays."""

    def from_arrays(self, arrays: dict[str, NDArray[Any]]) -> Any:
        """Returns the state of such arrays; `self` does not change.

        Raises:
            LookupError: If an array is missing.
            ValueError: If they cannot be a result of `to_arrays`.
        """


@runtime_checkable
class Remembering(Protocol):
    """A system or diagram whose state only an equal one can use."""

    def DescribeMemory(self) -> list[str]:
        """Returns what the meaning of the state depends on, in words."""


@runtime_checkable
class Checking(Protocol):
    """A system that can check the numbers of its Context."""

    def CheckContext(self, context: Context) -> None:
        """Checks the numbers of a Context of this system.

        Raises:
            ValueError: If they are impossible.
        """


def abstract_states(context: Context) -> Iterator[tuple[int, Any]]:
    """Yields the abstract states of a leaf with their indices.

    The value is None for one without a Python type.
    """
    for i in range(context.num_abstract_states()):
        try:
            value = context.get_abstract_state(i).get_value()
        except RuntimeError as error:
            # A plant's memory of its last step, for its outputs: the next
            # step does not depend on it.
            if "DiscreteStepMemory" in str(error):
                continue
            value = None
        yield i, value


def stored_states(
    system: System, context: Context
) -> Iterator[tuple[int, Storable]]:
    """Yields the saved abstract states of a leaf with their indices.

    Raises:
        ValueError: If a state cannot be saved.
    """
    for i, value in abstract_states(context):
        if not isinstance(value, Storable):
            raise ValueError(
                f"{system.GetSystemPathname()} has an abstract state of type"
                f" {type(value).__name__}, which cannot be saved: it lacks"
                " to_arrays() and from_arrays()"
            )
        yield i, value


def free_ports(
    diagram: Diagram, prefix: str = ""
) -> Iterator[tuple[str, InputPort]]:
    """Yields the input ports that may have fixed values, each with a key."""
    taken = set(diagram.connection_map())
    for i in range(diagram.num_input_ports()):
        # Inputs of an inner diagram are inputs of its systems.
        if not prefix:
            yield f"input/{i}", diagram.get_input_port(i)
        taken |= set(diagram.GetInputPortLocators(InputPortIndex(i)))
    for i, system in enumerate(diagram.GetSystems()):
        for k in range(system.num_input_ports()):
            if (system, InputPortIndex(k)) not in taken:
                yield f"{prefix}{i}/input/{k}", system.get_input_port(k)
        if isinstance(system, Diagram):
            yield from free_ports(system, f"{prefix}{i}.")


def leaves(diagram: Diagram, prefix: str = "") -> Iterator[tuple[str, System]]:
    """Yields the leaf systems, each with its path of indices as key."""
    for i, system in enumerate(diagram.GetSystems()):
        if isinstance(system, Diagram):
            yield from leaves(system, f"{prefix}{i}.")
        else:
            yield f"{prefix}{i}", system


def vectors(
    context: Context, *, mutable: bool = False
) -> Iterator[tuple[str, Any]]:
    """Yields the vectors of state and parameters of a leaf, with names."""

    def get(what: str, *index: int) -> Any:
        prefix = "get_mutable_" if mutable else "get_"
        return getattr(context, prefix + what)(*index)

    if context.num_continuous_states():
        yield "continuous", get("continuous_state_vector")
    for i in range(context.num_discrete_state_groups()):
        yield f"discrete/{i}", get("discrete_state", i)
    for i in range(context.num_numeric_parameter_groups()):
        yield f"parameter/{i}", get("numeric_parameter", i)


def layout(diagram: Diagram, context: Context) -> list[dict[str, Any]]:
    """Returns the type and the layout of state of each leaf system.

    The first part is the diagram itself, for the memory that it describes.

    Raises:
        TypeError: If it is no Diagram.
    """
    if not isinstance(diagram, Diagram):
        raise TypeError(
            "the Context must be of a Diagram, got a"
            f" {type(diagram).__name__}; put the system into a Diagram by a"
            " DiagramBuilder"
        )
    parts: list[dict[str, Any]] = []
    for key, system in [("", diagram), *leaves(diagram)]:
        is_leaf = system is not diagram
        own = system.GetMyContextFromRoot(context)
        sizes = (
            {name: it.size() for name, it in vectors(own)} if is_leaf else {}
        )
        part = {
            "key": key,
            "type": type(system).__name__,
            # (A system without a name has one of module and address.)
            "path": re.sub("[^:]*@[0-9a-f]+", "", system.GetSystemPathname()),
            "sizes": sizes,
            "abstract": own.num_abstract_states() if is_leaf else 0,
            "memory": memory(system),
        }
        parts.append(part)
    return parts


def memory(system: System) -> list[str]:
    """Returns what the meaning of a system's state depends on, in words."""
    if isinstance(system, Remembering):
        return system.DescribeMemory()
    return []


def misfit(saved: Any, present: list[dict[str, Any]]) -> str:
    """Returns the first difference of a file from a diagram, or ""."""
    keys = {"key", "type", "path", "sizes", "abstract", "memory"}
    if not isinstance(saved, list) or not all(
        isinstance(old, dict)
        and old.keys() >= keys
        and isinstance(old["memory"], list)
        for old in saved
    ):
        return "its list of systems is none"
    for old, new in zip(saved, present, strict=False):
        for what in ("key", "type", "path", "memory", "sizes", "abstract"):
            differing = (old[what], new[what])
            if what == "memory":
                # The first of many trees that differs.
                pairs = itertools.zip_longest(*differing, fillvalue="none")
                differing = next((p for p in pairs if p[0] != p[1]), ("", ""))
            if differing[0] != differing[1]:
                return (
                    f"does not fit the diagram at {new['path']}: {what}"
                    f" {differing[0]} in the file, {differing[1]} in the"
                    " diagram"
                )
    if len(saved) != len(present):
        return (
            f"does not fit the diagram: {len(saved)} systems in the file,"
            f" {len(present)} in the diagram"
        )
    return ""
