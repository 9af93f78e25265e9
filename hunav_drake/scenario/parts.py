"""The classes of the parts of a scenario, gathered for users."""

from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.evaluation.evaluator_config import EvaluatorConfig
from hunav_drake.systems.people.area import Area
from hunav_drake.systems.people.behavior_choice import BehaviorConfig
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.parameters import SocialForceParameters
from hunav_drake.systems.people.population_config import (
    AgeBand,
    CohortConfig,
    PopulationConfig,
    SinkConfig,
    SourceConfig,
    SpeedDistribution,
)
from hunav_drake.systems.people.track_config import TrackConfig, TracksConfig
from hunav_drake.systems.planning.planner import PlannerConfig
from hunav_drake.systems.robot.robot_config import RobotConfig, RobotLimits
from hunav_drake.systems.robot.robots import DifferentialDriveConfig
from hunav_drake.systems.sensing.sensor_config import (
    CameraConfig,
    LidarConfig,
    SensorConfig,
    VisiblePeopleConfig,
)
from hunav_drake.systems.world.furniture import Furniture
from hunav_drake.systems.world.shapes import (
    Box,
    Disc,
    Polygon,
    Polyline,
    Wall,
    World,
)

__all__ = [
    "AgeBand",
    "Area",
    "BehaviorConfig",
    "Box",
    "CameraConfig",
    "CohortConfig",
    "CrowdConfig",
    "DifferentialDriveConfig",
    "Disc",
    "EvaluatorConfig",
    "Furniture",
    "HumanConfig",
    "LidarConfig",
    "PlannerConfig",
    "Polygon",
    "Polyline",
    "PopulationConfig",
    "RobotConfig",
    "RobotLimits",
    "SensorConfig",
    "SinkConfig",
    "SocialForceParameters",
    "SourceConfig",
    "SpeedDistribution",
    "TrackConfig",
    "TracksConfig",
    "VisiblePeopleConfig",
    "Wall",
    "World",
]
