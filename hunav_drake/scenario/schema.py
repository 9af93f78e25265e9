"""What a scenario file says, as a tree of dataclasses.

The keys of the file are the names of the fields; what is left out has the
default written here.
"""

from dataclasses import field
from typing import Annotated

from pydantic import Field, StrictFloat, StrictStr
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import CONFIG, Integer, Name, within
from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.evaluation.evaluator_config import EvaluatorConfig
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.population_config import PopulationConfig
from hunav_drake.systems.planning.planner import PLANNERS, PlannerConfig
from hunav_drake.systems.robot.robot_config import ROBOTS, RobotConfig
from hunav_drake.systems.scene.scene_config import SceneConfig
from hunav_drake.systems.sensing.sensor_config import SENSORS, SensorConfig
from hunav_drake.systems.world.shapes import World


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class SimulationConfig:
    """How long and how finely the trial runs."""

    # The one step of everything, in seconds.
    time_step: Annotated[StrictFloat, within(1e-4, 0.5, "s")] = 0.05

    # The trial ends after this time at the latest, in seconds.
    duration: Annotated[StrictFloat, within(0, 86400, "s", low_open=True)] = (
        60.0
    )

    # All that is drawn at random in the trial follows from this number; who
    # the people of a population are, from `population.seed`.
    seed: Annotated[Integer, Field(ge=0, le=2**63 - 1)] = 0

    # Each person starts up to this far from the given place, along x and
    # along y, in meters.
    start_jitter: Annotated[StrictFloat, within(0, 1, "m")] = 0.0

    # The trial ends as stuck once the robot has had a goal but has not moved
    # `stuck_distance` in `stuck_time`, in meters and seconds.
    stuck_time: Annotated[StrictFloat, within(0, 86400, "s", low_open=True)] = (
        15.0
    )
    stuck_distance: Annotated[
        StrictFloat, within(0, 100, "m", low_open=True)
    ] = 0.5


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class Scenario:
    """A trial: a world, people, a robot with its planner, and an evaluator."""

    # What the trial is called in tables; by default as its file is.
    name: Name = ""

    # One line on what happens here.
    description: StrictStr = ""

    # Everything that does not move.
    world: World = field(default_factory=World)

    # How people move, and how they take in the world.
    crowd: CrowdConfig = field(default_factory=CrowdConfig)

    # The people, one by one.
    humans: list[HumanConfig] = field(default_factory=list)

    # People who are drawn, besides those listed under humans.
    population: PopulationConfig = field(default_factory=PopulationConfig)

    # The robot, with its start and its goal.
    robot: Annotated[RobotConfig, ROBOTS] = field(default_factory=ROBOTS.make)

    # What drives the robot.
    planner: Annotated[PlannerConfig, PLANNERS] = field(
        default_factory=PLANNERS.make
    )

    # What the robot, or the place, measures with.
    sensors: list[Annotated[SensorConfig, SENSORS]] = field(
        default_factory=list
    )

    # What is measured of the trial.
    evaluator: EvaluatorConfig = field(default_factory=EvaluatorConfig)

    # How long and how finely the trial runs.
    simulation: SimulationConfig = field(default_factory=SimulationConfig)

    # What is seen of the trial, where it is shown.
    scene: SceneConfig = field(default_factory=SceneConfig)
