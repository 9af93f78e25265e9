"""Helpers that declare, find and check ports, and weak callbacks."""

from collections.abc import Callable, Mapping, Sequence
import math
from typing import Any
from weakref import ref

from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    InputPort,
    OutputPort,
    PortDataType,
    System,
)
from pydrake.systems.primitives import Multiplexer

from hunav_drake.systems.common.layout import STATE_SIZE


def DeclareRobotStates(system: Any, num_robots: int) -> InputPort | None:
    """Declares port ``robot_states`` of a system; none if there are no robots.

    It takes a row (x, y, yaw, vx, vy, omega, radius) of each.
    """
    if num_robots == 0:
        return None
    return system.DeclareVectorInputPort(
        "robot_states", num_robots * STATE_SIZE
    )


def RobotStatesOf(port: InputPort, context: Context) -> Any:
    """Returns the value of a port of `DeclareRobotStates`, not to be changed.

    Raises:
        RuntimeError: If nothing is connected to it.
    """
    try:
        return port.EvalBasicVector(context).value()
    except RuntimeError:
        if port.HasValue(context):
            raise
        raise RuntimeError(
            f"{port.get_system().GetSystemPathname()}: nothing is connected to"
            " its port robot_states; connect the state (x, y, yaw, vx, vy,"
            " omega, radius) of the robot to AddHumans(...).robot_states, or"
            " make the people with num_robots=0"
        ) from None


def CopyOf(port: InputPort, context: Context) -> Any:
    """Returns a new array with the value of a port, in half of Eval's time."""
    return port.EvalBasicVector(context).value().copy()


def GoalOf(
    port: InputPort, context: Context
) -> tuple[float, float, float] | None:
    """Returns the goal (x, y, yaw) at a port.

    None if nothing is connected, or a number is not finite: there is no goal.
    """
    if not port.HasValue(context):
        return None
    goal = port.EvalBasicVector(context)
    x, y, yaw = goal.GetAtIndex(0), goal.GetAtIndex(1), goal.GetAtIndex(2)
    return (x, y, yaw) if math.isfinite(x + y + yaw) else None


def JoinPorts(
    builder: DiagramBuilder, name: str, ports: Sequence[OutputPort]
) -> OutputPort:
    """Returns one port with the numbers of several, from a system `name`.

    Nothing is added for a single port, or for a single one with numbers.
    """
    if len(ports) > 1:
        ports = [port for port in ports if port.size()]
    if len(ports) == 1:
        return ports[0]
    joined = builder.AddNamedSystem(
        name, Multiplexer([port.size() for port in ports])
    )
    for i, port in enumerate(ports):
        builder.Connect(port, joined.get_input_port(i))
    return joined.get_output_port()


def RequirePort(
    system: Any, port: InputPort | None, name: str, made_with: str
) -> InputPort:
    """Returns a port, checked to exist.

    Raises:
        ValueError: If the system was made without it, by an argument of its
            constructor such as "num_robots=0".
    """
    if port is None:
        raise ValueError(
            f"{system.GetSystemPathname()} has no port {name}: it was made"
            f" with {made_with}"
        )
    return port


def CheckPorts(
    system: Any,
    what: str,
    *,
    inputs: Mapping[str, int],
    outputs: Mapping[str, int | None],
) -> None:
    """Checks that a system has the ports of its kind.

    Args:
        system: A LeafSystem or a Diagram.
        what: Its name in the message.
        inputs: The size of each input port by its name.
        outputs: The size of each output port; None for an abstract one.

    Raises:
        TypeError: If it is not a system, or if ports are missing or of another
            size. The message names them all.
    """
    if not isinstance(system, System):
        raise TypeError(f"{what} must make a System, got {system!r:.80}")
    faults = []
    for kind, ports, has, get in (
        ("input", inputs, system.HasInputPort, system.GetInputPort),
        ("output", outputs, system.HasOutputPort, system.GetOutputPort),
    ):
        for name, size in ports.items():
            wanted = "abstract" if size is None else f"a vector of size {size}"
            if not has(name):
                faults.append(f"{kind} port {name} ({wanted}) is missing")
                continue
            port = get(name)
            is_vector = port.get_data_type() == PortDataType.kVectorValued
            got = f"a vector of size {port.size()}" if is_vector else "abstract"
            if got != wanted:
                faults.append(f"{kind} port {name} must be {wanted}, is {got}")
    if faults:
        raise TypeError(f"{what} lacks ports of its kind: {'; '.join(faults)}")


def weakly(method: Any) -> Callable[..., Any]:
    """Returns a callback that does not keep the system of a method alive.

    pydrake keeps the callbacks of cache entries and of abstract output ports
    where Python's garbage collector does not see them: a bound method there
    would keep its system, and the whole diagram, alive for ever.
    """
    owner, function = ref(method.__self__), method.__func__

    def call(*arguments: Any) -> Any:
        # (Drake calls back only while it is alive.)
        return function(owner(), *arguments)

    return call
