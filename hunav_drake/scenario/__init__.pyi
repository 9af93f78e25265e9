from .checks import CheckScenario as CheckScenario
from .error import Fault as Fault, ScenarioError as ScenarioError
from .generate.kind import GenerateScenario as GenerateScenario
from .loading import (
    ListScenarios as ListScenarios,
    LoadScenario as LoadScenario,
)
from .parts import (
    AgeBand as AgeBand,
    Area as Area,
    BehaviorConfig as BehaviorConfig,
    Box as Box,
    CameraConfig as CameraConfig,
    CohortConfig as CohortConfig,
    CrowdConfig as CrowdConfig,
    DifferentialDriveConfig as DifferentialDriveConfig,
    Disc as Disc,
    EvaluatorConfig as EvaluatorConfig,
    Furniture as Furniture,
    HumanConfig as HumanConfig,
    LidarConfig as LidarConfig,
    PlannerConfig as PlannerConfig,
    Polygon as Polygon,
    Polyline as Polyline,
    PopulationConfig as PopulationConfig,
    RobotConfig as RobotConfig,
    RobotLimits as RobotLimits,
    SensorConfig as SensorConfig,
    SinkConfig as SinkConfig,
    SocialForceParameters as SocialForceParameters,
    SourceConfig as SourceConfig,
    SpeedDistribution as SpeedDistribution,
    VisiblePeopleConfig as VisiblePeopleConfig,
    Wall as Wall,
    World as World,
)
from .population import draw_people as draw_people
from .schema import Scenario as Scenario, SimulationConfig as SimulationConfig
from .writer import SaveScenario as SaveScenario
