"""Robots that people meet."""

from typing import TYPE_CHECKING

from hunav_drake.systems.lazy import lazy_exports

if TYPE_CHECKING:
    from hunav_drake.systems.robot.body_state import (
        AddBodyState,
        BodyState,
    )
    from hunav_drake.systems.robot.differential_drive import (
        DifferentialDrive,
    )
    from hunav_drake.systems.robot.robot_config import (
        RobotConfig,
        RobotLimits,
    )

__all__ = [
    "AddBodyState",
    "BodyState",
    "DifferentialDrive",
    "RobotConfig",
    "RobotLimits",
]

__getattr__ = lazy_exports(
    __name__,
    {
        "AddBodyState": "hunav_drake.systems.robot.body_state",
        "BodyState": "hunav_drake.systems.robot.body_state",
        "DifferentialDrive": "hunav_drake.systems.robot.differential_drive",
        "RobotConfig": "hunav_drake.systems.robot.robot_config",
        "RobotLimits": "hunav_drake.systems.robot.robot_config",
    },
)
