from .body_state import AddBodyState as AddBodyState, BodyState as BodyState
from .differential_drive import DifferentialDrive as DifferentialDrive
from .disc_contacts import DiscContacts as DiscContacts
from .drives import (
    DRIVES as DRIVES,
    DifferentialWheels as DifferentialWheels,
    DriveConfig as DriveConfig,
    PlanarBase as PlanarBase,
)
from .robot_config import (
    ROBOTS as ROBOTS,
    RobotConfig as RobotConfig,
    RobotLimits as RobotLimits,
    RobotTask as RobotTask,
    register_robot as register_robot,
)
from .robots import (
    DifferentialDriveConfig as DifferentialDriveConfig,
    PhysicalRobot as PhysicalRobot,
    PMB2Config as PMB2Config,
    UrdfRobot as UrdfRobot,
)
