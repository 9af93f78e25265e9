"""What a scenario file says, as a tree of dataclasses.

The keys of the file are the names of the fields; what is left out has the
default written here.
"""

from dataclasses import field
from typing import Annotated

from pydantic import Field, StrictFloat, StrictStr
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import CONFIG, FileName, Integer, within
from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.evaluation.evaluator_config import EvaluatorConfig
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.names import name_people
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

    time_step: Annotated[StrictFloat, within(1e-4, 0.5, "s")] = 0.05
    """The one step of everything, in seconds."""

    duration: Annotated[StrictFloat, within(0, 86400, "s", low_open=True)] = (
        60.0
    )
    """The trial ends after this time at the latest, in seconds: a multiple of
    the step."""

    seed: Annotated[Integer, Field(ge=0, le=2**63 - 1)] = 0
    """All that is drawn at random in the trial follows from this number, and so
    do the people of a population without a `seed` of its own."""

    start_jitter: Annotated[StrictFloat, within(0, 1, "m")] = 0.0
    """Each person starts up to this far from the given place, along x and along
    y, in meters."""

    stuck_time: Annotated[StrictFloat, within(0, 86400, "s", low_open=True)] = (
        30.0
    )
    """The trial ends as stuck once the robot, with a goal, has not moved
    `stuck_distance` in this time, in seconds. Planners with maps need some 18 s
    to notice that they get nowhere and to recover for the first time."""

    stuck_distance: Annotated[
        StrictFloat, within(0, 100, "m", low_open=True)
    ] = 0.5
    """How far the robot must move within `stuck_time`, in meters."""


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class Scenario:
    """A trial: a world, people, a robot with its planner, and an evaluator."""

    name: FileName = ""
    """What the trial is called in tables; by default as its file is."""

    description: StrictStr = ""
    """One line on what happens here."""

    world: World = field(default_factory=World)
    """Everything that does not move."""

    crowd: CrowdConfig = field(default_factory=CrowdConfig)
    """How people move, and how they take in the world."""

    humans: list[HumanConfig] = field(default_factory=list)
    """The people, one by one. Those without a name or a number are given
    "human_1", "human_2", ... and 1, 2, ... as far as these are free."""

    population: PopulationConfig = field(default_factory=PopulationConfig)
    """People who are drawn, besides those listed under humans."""

    robot: Annotated[RobotConfig, ROBOTS] = field(default_factory=ROBOTS.make)
    """The robot, with its start and its goal."""

    planner: Annotated[PlannerConfig, PLANNERS] = field(
        default_factory=PLANNERS.make
    )
    """What drives the robot."""

    sensors: list[Annotated[SensorConfig, SENSORS]] = field(
        default_factory=list
    )
    """What the robot, or the place, measures with."""

    evaluator: EvaluatorConfig = field(default_factory=EvaluatorConfig)
    """What is measured of the trial."""

    simulation: SimulationConfig = field(default_factory=SimulationConfig)
    """How long and how finely the trial runs."""

    scene: SceneConfig = field(default_factory=SceneConfig)
    """What is seen of the trial, where it is shown."""

    def __post_init__(self) -> None:
        """Gives names and numbers to the people who have none."""
        if any(not it.name or it.id is None for it in self.humans):
            self.humans = name_people(self.humans)
