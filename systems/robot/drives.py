"""The drives of robot models: choices of a scenario's robot."""

import math
from typing import Annotated, Any

from pydantic import Discriminator, Field, StrictFloat, StrictStr, Tag
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.common.schema import CONFIG, within

Name = StrictStr
Names = Annotated[
    Annotated[Name, Tag("one")]
    | Annotated[list[Name], Field(min_length=1), Tag("list")],
    Discriminator(lambda it: "list" if isinstance(it, list) else "one"),
]
Size = Annotated[StrictFloat, within(0, 100, "m", low_open=True)]
Torque = Annotated[StrictFloat, within(0, 1e5, "N m", low_open=True)]
Force = Annotated[StrictFloat, within(0, 1e6, "N", low_open=True)]
WheelSpeed = Annotated[StrictFloat, within(0, 1e4, "rad/s", low_open=True)]
Steering = Annotated[
    StrictFloat, within(0, math.pi / 2 - 0.01, "rad", low_open=True)
]


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class DriveConfig:
    """Base class of the drives."""

    def __init_subclass__(cls, **options: Any) -> None:
        """Refuses user-defined drives, which plants do not support."""
        super().__init_subclass__(**options)
        if not cls.__module__.startswith("hunav_drake."):
            raise TypeError(
                f"{cls.__qualname__} cannot be a drive: models are driven as"
                " DifferentialWheels, AckermannSteering, MecanumWheels or as a"
                " PlanarBase; for another way, derive a robot from RobotConfig,"
                " and register it by @register_robot"
            )


DRIVES = Registry("drive", DriveConfig, default="differential")


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class WheelDrive(DriveConfig):
    """Base class of the drives with wheels."""

    wheel_radius: Size
    """Radius of the wheels, in meters."""

    max_torque: Torque = 20.0
    """Maximum torque on a wheel, in N m. A lower limit of a motor in the model
    holds."""

    max_wheel_speed: WheelSpeed = 100.0
    """Maximum speed of a wheel, in rad/s."""

    def joints(self) -> dict[str, list[str]]:
        """Returns the names of the joints by settings, the wheels' first."""
        settings = vars(self)
        names = {
            key: settings[key]
            for kind in ("_wheel", "_steering")
            for key in settings
            if key.endswith(kind)
        }
        return {
            key: [it] if isinstance(it, str) else it
            for key, it in names.items()
        }


@DRIVES.register("differential")
@dataclass(kw_only=True, config=CONFIG)
class DifferentialWheels(WheelDrive):
    """Differential drive: two driven wheels; other supports roll or slide.

    With several wheels on a side it is a skid steer.
    """

    left_wheel: Names
    """Joint of the left wheel, or a list of those of a skid steer. Axes are
    along the base's y axis or opposite to it."""

    right_wheel: Names
    """Joint of the right wheel, or a list of those of a skid steer. Axes are
    along the base's y axis or opposite to it."""

    wheel_separation: Size
    """Distance between the wheels of both sides, in meters."""

    @property
    def skids(self) -> bool:
        """Whether wheels slip sideways in a turn."""
        return any(len(names) > 1 for names in self.joints().values())


@DRIVES.register("ackermann")
@dataclass(kw_only=True, config=CONFIG)
class AckermannSteering(WheelDrive):
    """Car-like drive: two steered wheels, and driven ones on another axle.

    A command (v, omega) is a speed and a curvature: the robot turns only while
    it moves. Places of wheels are those in the model.
    """

    left_wheel: Names
    """Joint of the driven wheel on the left, or a list; its axis is along the
    base's y axis or opposite to it."""

    right_wheel: Names
    """Joint of the driven wheel on the right, or a list; its axis is along the
    base's y axis or opposite to it."""

    left_steering: Name
    """Vertical joint that steers the wheel on the left."""

    right_steering: Name
    """Vertical joint that steers the wheel on the right."""

    max_steering_angle: Steering = 0.6
    """Maximum angle of the inner steered wheel, in radians. A lower limit in
    the model holds."""


@DRIVES.register("mecanum")
@dataclass(kw_only=True, config=CONFIG)
class MecanumWheels(WheelDrive):
    """Four mecanum wheels, without their rollers.

    The floor pushes and turns the base, as far as ideal wheels at their maximum
    torque and the grip of rubber on the floor allow; the wheels turn with it.
    The base must be the root of the model. Places of wheels are those in the
    model.
    """

    front_left_wheel: Name
    """Joint of the wheel; its axis is along the base's y axis or opposite."""

    front_right_wheel: Name
    """Joint of the wheel; its axis is along the base's y axis or opposite."""

    rear_left_wheel: Name
    """Joint of the wheel; its axis is along the base's y axis or opposite."""

    rear_right_wheel: Name
    """Joint of the wheel; its axis is along the base's y axis or opposite."""


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
