"""Robots that people meet."""

from hunav_drake.systems.robot.body_state import AddBodyState, BodyState
from hunav_drake.systems.robot.differential_drive import DifferentialDrive
from hunav_drake.systems.robot.robot_config import RobotConfig, RobotLimits

__all__ = [
    "AddBodyState",
    "BodyState",
    "DifferentialDrive",
    "RobotConfig",
    "RobotLimits",
]
