"""Helpers that declare and find ports."""

from typing import Any

from pydrake.systems.framework import InputPort

from hunav_drake.systems.common.layout import STATE_SIZE


def DeclareRobotState(system: Any, num_robots: int) -> InputPort | None:
    """Declares port ``robot_state`` of a system; none if there are no robots.

    Args:
        system: Changed.
        num_robots: How many rows (x, y, yaw, vx, vy, omega, radius) it takes.
    """
    if num_robots == 0:
        return None
    return system.DeclareVectorInputPort("robot_state", num_robots * STATE_SIZE)


def RequirePort(
    system: Any, port: InputPort | None, name: str, made_with: str
) -> InputPort:
    """Returns a port that a system has.

    Args:
        system: Whose port it is.
        port: The port, or None if the system was made without.
        name: The name of the port.
        made_with: The argument of the system's constructor that decides so,
            as in "num_robots=0".

    Raises:
        ValueError: If the system was made without.
    """
    if port is None:
        raise ValueError(
            f"{system.GetSystemPathname()} has no port {name}: it was made"
            f" with {made_with}"
        )
    return port
