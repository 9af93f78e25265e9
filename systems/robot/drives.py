"""The drives of robot models: choices of a scenario's robot."""

from typing import Annotated, Any

from pydantic import StrictFloat, StrictStr
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.common.schema import CONFIG, within

Name = StrictStr
Size = Annotated[StrictFloat, within(0, 100, "m", low_open=True)]
Torque = Annotated[StrictFloat, within(0, 1e5, "N m", low_open=True)]
Force = Annotated[StrictFloat, within(0, 1e6, "N", low_open=True)]
WheelSpeed = Annotated[StrictFloat, within(0, 1e4, "rad/s", low_open=True)]


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class DriveConfig:
    """Base class of the two drives."""

    def __init_subclass__(cls, **options: Any) -> None:
        """Refuses user-defined drives, which plants do not support."""
        super().__init_subclass__(**options)
        if not cls.__module__.startswith("hunav_drake."):
            raise TypeError(
                f"{cls.__qualname__} cannot be a drive: models are driven as"
                " DifferentialWheels or as a PlanarBase; for another way,"
                " derive a robot from RobotConfig, and register it by"
                " @register_robot"
            )


DRIVES = Registry("drive", DriveConfig, default="differential")


@DRIVES.register("differential")
@dataclass(kw_only=True, config=CONFIG)
class DifferentialWheels(DriveConfig):
    """Differential drive: two driven wheels; other supports roll or slide."""

    left_wheel: Name
    """Joint of the left wheel; its axis is along the base's y axis or opposite
    to it."""

    right_wheel: Name
    """Joint of the right wheel; its axis is along the base's y axis or opposite
    to it."""

    wheel_separation: Size
    """Distance between the wheels, in meters."""

    wheel_radius: Size
    """Radius of the wheels, in meters."""

    max_torque: Torque = 20.0
    """Maximum torque on a wheel, in N m. A lower limit in the model holds."""

    max_wheel_speed: WheelSpeed = 100.0
    """Maximum speed of a wheel, in rad/s."""


@DRIVES.register("omnidirectional")
@dataclass(kw_only=True, config=CONFIG)
class PlanarBase(DriveConfig):
    """Omnidirectional drive: motors along x and y of the world, and about z.

    They are joints of the model, or, without names, joints added between the
    world and the base, which must then be the root of the model.
    """

    x: Name = ""
    """Joint along x of the world. Name all three joints or none."""

    y: Name = ""
    """Joint along y of the world."""

    yaw: Name = ""
    """Joint about the vertical."""

    height: Annotated[StrictFloat, within(-10, 10, "m")] = 0.0
    """Height of the base above the floor, in meters; for added joints only."""

    max_force: Force = 300.0
    """Maximum force along x and along y, in N. A lower limit in the model
    holds."""

    max_torque: Torque = 100.0
    """Maximum torque about the vertical, in N m. A lower limit in the model
    holds."""
