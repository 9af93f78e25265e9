"""How a model of a robot is driven: choices of a scenario's robot."""

from typing import Annotated

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
    """What all drives derive from; which one it is, a derived class tells."""


DRIVES = Registry("drive", DriveConfig, default="differential")

register_drive = DRIVES.register


@register_drive("differential")
@dataclass(kw_only=True, config=CONFIG)
class DifferentialWheels(DriveConfig):
    """Two driven wheels; what else carries the robot rolls or slides."""

    left_wheel: Name
    """The joint that turns the left wheel, about the y axis of the base or the
    opposite one."""

    right_wheel: Name
    """The joint that turns the right wheel, about the y axis of the base or the
    opposite one."""

    wheel_separation: Size
    """The distance between the wheels, in meters."""

    wheel_radius: Size
    """The radius of the wheels, in meters."""

    max_torque: Torque = 20.0
    """The largest torque on a wheel, in N m; a smaller one in the model counts.
    """

    max_wheel_speed: WheelSpeed = 100.0
    """How fast a wheel turns at most, in rad/s."""


@register_drive("omnidirectional")
@dataclass(kw_only=True, config=CONFIG)
class PlanarBase(DriveConfig):
    """Motors that move the base along x and y of the world, and turn it.

    They are joints of the model, or, without names, added between the world
    and the base, which may then be any body that nothing else carries.
    """

    x: Name = ""
    """The joint along x of the world. All three joints are named, or none."""

    y: Name = ""
    """The joint along y of the world."""

    yaw: Name = ""
    """The joint about the vertical."""

    height: Annotated[StrictFloat, within(-10, 10, "m")] = 0.0
    """How high above the floor the base is, in meters; for joints that are
    added."""

    max_force: Force = 300.0
    """The largest force along x and along y, in N; a smaller one in the model
    counts."""

    max_torque: Torque = 100.0
    """The largest torque about the vertical, in N m; a smaller one in the model
    counts."""
