"""The parts of a Context that a file of it holds."""

from collections.abc import Iterator
import itertools
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
    """An abstract state that can be written as arrays, and read back."""

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Returns all that the state is made of, by name."""

    def from_arrays(self, arrays: dict[str, NDArray[Any]]) -> Any:
        """Returns the state that arrays were made of; `self` stays.

        Raises:
            LookupError: If an array is missing.
            ValueError: If they cannot be what `to_arrays` gave.
        """


@runtime_checkable
class Remembering(Protocol):
    """A system, or a diagram, whose state only one made alike can use."""

    def DescribeMemory(self) -> list[str]:
        """Returns all that the meaning of the state depends on, in words."""


@runtime_checkable
class Checking(Protocol):
    """A system that knows which numbers its Context may have."""

    def CheckContext(self, context: Context) -> None:
        """Checks the numbers of a Context of this system.

        Raises:
            ValueError: If they cannot be.
        """


def abstract_states(
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


def free_ports(
    diagram: Diagram, prefix: str = ""
) -> Iterator[tuple[str, InputPort]]:
    """Yields the input ports that may have a fixed value, each with a key."""
    taken = set(diagram.connection_map())
    for i in range(diagram.num_input_ports()):
        # Inputs of an inner diagram are inputs of the systems in it.
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
    """Yields the leaf systems, each with a key that is its place."""
    for i, system in enumerate(diagram.GetSystems()):
        if isinstance(system, Diagram):
            yield from leaves(system, f"{prefix}{i}.")
        else:
            yield f"{prefix}{i}", system


def vectors(
    context: Context, *, mutable: bool = False
) -> Iterator[tuple[str, Any]]:
    """Yields the vectors of a leaf's context that have numbers, by name."""

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
    """Returns what each leaf system is, and what its numbers mean.

    First comes the diagram itself, which may tell what it was made of.
    """
    parts: list[dict[str, Any]] = [
        {
            "key": "",
            "type": type(diagram).__name__,
            "path": diagram.GetSystemPathname(),
            "sizes": {},
            "abstract": 0,
            "memory": memory(diagram),
        }
    ]
    for key, system in leaves(diagram):
        own = system.GetMyContextFromRoot(context)
        sizes = {name: vector.size() for name, vector in vectors(own)}
        part = {
            "key": key,
            "type": type(system).__name__,
            "path": system.GetSystemPathname(),
            "sizes": sizes,
            "abstract": own.num_abstract_states(),
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
    """Returns how a file and a diagram differ, or an empty text."""
    keys = {"key", "type", "path", "sizes", "abstract", "memory"}
    if not isinstance(saved, list) or not all(
        isinstance(old, dict)
        and old.keys() >= keys
        and isinstance(old["memory"], list)
        for old in saved
    ):
        return "its list of systems is none"
    for old, new in zip(saved, present, strict=False):
        for what in ("key", "type", "memory", "sizes", "abstract"):
            differing = (old[what], new[what])
            if what == "memory":
                # Of many trees, the first that is another one.
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
