from .body_state import AddBodyState as AddBodyState, BodyState as BodyState
from .differential_drive import DifferentialDrive as DifferentialDrive
from .robot_config import (
    ROBOTS as ROBOTS,
    DifferentialDriveConfig as DifferentialDriveConfig,
    RobotConfig as RobotConfig,
    RobotLimits as RobotLimits,
    register_robot as register_robot,
)
