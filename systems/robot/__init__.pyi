from .body_state import AddBodyState as AddBodyState, BodyState as BodyState
from .differential_drive import DifferentialDrive as DifferentialDrive
from .disc_contacts import DiscContacts as DiscContacts
from .drives import (
    DRIVES as DRIVES,
    AckermannSteering as AckermannSteering,
    DifferentialWheels as DifferentialWheels,
    DriveConfig as DriveConfig,
    MecanumWheels as MecanumWheels,
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
    JackalConfig as JackalConfig,
    PhysicalRobot as PhysicalRobot,
    PMB2Config as PMB2Config,
    TiagoBaseConfig as TiagoBaseConfig,
    TurtleBot3BurgerConfig as TurtleBot3BurgerConfig,
    TurtleBot3WaffleConfig as TurtleBot3WaffleConfig,
    UrdfRobot as UrdfRobot,
)
