"""The wires of a trial's diagram: ports find each other by their names."""

from collections.abc import Mapping

from pydrake.systems.framework import DiagramBuilder, OutputPort, System

# Output ports by the names of the inputs that they are for; None for a port
# that a trial does not have.
Ports = Mapping[str, OutputPort | None]


def ConnectByName(
    builder: DiagramBuilder, ports: Ports, *systems: System
) -> None:
    """Connects ports to the inputs of systems that have their names."""
    for system in systems:
        for name, port in ports.items():
            if port is not None and system.HasInputPort(name):
                builder.Connect(port, system.GetInputPort(name))
