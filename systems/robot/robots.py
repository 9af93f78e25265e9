"""The robots that come with the package, by name."""

from typing import TYPE_CHECKING

from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.schema import CONFIG
from hunav_drake.systems.robot.robot_config import (
    ROBOTS,
    RobotConfig,
    register_robot,
)

if TYPE_CHECKING:
    from hunav_drake.systems.robot.differential_drive import DifferentialDrive

__all__ = ["ROBOTS", "DifferentialDriveConfig"]


@register_robot("differential_drive")
@dataclass(kw_only=True, config=CONFIG)
class DifferentialDriveConfig(RobotConfig):
    """A kinematic robot that follows (v, omega) within its limits."""

    def MakeSystem(self, *, time_step: float) -> "DifferentialDrive":
        """Makes a `DifferentialDrive`."""
        # Reading a scenario does without Drake.
        from hunav_drake.systems.robot.differential_drive import (
            DifferentialDrive,
        )

        return DifferentialDrive(self, time_step=time_step)
