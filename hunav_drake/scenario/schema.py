"""The content of a scenario file as a tree of dataclasses.

The keys of the file are the names of the fields. A missing key has the default
given here.
"""

from dataclasses import field
import re
from typing import Annotated

from pydantic import AfterValidator, Field, StrictFloat, StrictStr
from pydantic.dataclasses import dataclass
from pydantic_core import PydanticCustomError

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import (
    CONFIG,
    FileName,
    Integer,
    Name,
    within,
)
from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.evaluation.evaluator_config import EvaluatorConfig
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.names import name_people
from hunav_drake.systems.people.places import Place
from hunav_drake.systems.people.population_config import PopulationConfig
from hunav_drake.systems.planning.planner import PLANNERS, PlannerConfig
from hunav_drake.systems.robot.robot_config import ROBOTS, RobotConfig
from hunav_drake.systems.scene.scene_config import SceneConfig
from hunav_drake.systems.sensing.sensor_config import SENSORS, SensorConfig
from hunav_drake.systems.world.shapes import World


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class SimulationConfig:
    """Duration, time step, seed and end of the trial."""

    time_step: Annotated[StrictFloat, within(1e-4, 0.5, "s")] = 0.05
    """Time step of the whole simulation, in seconds."""

    duration: Annotated[StrictFloat, within(0, 86400, "s", low_open=True)] = (
        60.0
    )
    """Time limit of the trial, in seconds: a multiple of the time step."""

    seed: Annotated[Integer, Field(ge=0, le=2**63 - 1)] = 0
    """Seed of all random draws in the trial, and of the people of a population
    without its own `seed`."""

    start_jitter: Annotated[StrictFloat, within(0, 1, "m")] = 0.0
    """Largest random offset of each person's start along x and along y, in
    meters."""

    stuck_time: Annotated[StrictFloat, within(0, 86400, "s", low_open=True)] = (
        30.0
    )
    """Time, in seconds, after which a robot with a goal that has not moved by
    `stuck_distance` is stuck, which ends the trial. Planners with maps need
    about 18 s to detect that they make no progress and to recover once."""

    stuck_distance: Annotated[
        StrictFloat, within(0, 100, "m", low_open=True)
    ] = 0.5
    """Distance that the robot must move within `stuck_time`, in meters."""


def _robot_name(name: str) -> str:
    if re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]*", name):
        return name
    raise PydanticCustomError(
        "robot_name",
        "must begin with a letter, followed by letters, digits, - or _, as in"
        " robot_1",
    )


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class FleetMember:
    """One of several robots, with its planner and its sensors."""

    name: Annotated[Name, AfterValidator(_robot_name)]
    """Name of the robot: the prefix of its ports, systems and metrics."""

    robot: Annotated[RobotConfig, ROBOTS] = field(default_factory=ROBOTS.make)
    """Robot, with its start and its goal."""

    planner: Annotated[PlannerConfig, PLANNERS] = field(
        default_factory=PLANNERS.make
    )
    """Planner that drives the robot. It takes other robots for people: it gets
    them as rows, in view or not, or sees them by lidar, as it `sees` people."""

    sensors: list[Annotated[SensorConfig, SENSORS]] = field(
        default_factory=list
    )
    """Sensors on the robot."""


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class Scenario:
    """A trial: a world, people, a robot with its planner, and an evaluator."""

    name: FileName = ""
    """Name of the trial in tables; by default, that of its file."""

    description: StrictStr = ""
    """Description of the trial in one line."""

    world: World = field(default_factory=World)
    """World: everything that does not move."""

    crowd: CrowdConfig = field(default_factory=CrowdConfig)
    """Motion model of the people, and how they perceive the world."""

    places: list[Place] = field(default_factory=list)
    """Places that behavior trees name, as with `goal_id` of `GoTo`. A place
    without a name or a number gets "place_1", "place_2", ... and 1, 2, ..."""

    humans: list[HumanConfig] = field(default_factory=list)
    """People, one by one. A person without a name or a number gets the next
    free one of "human_1", "human_2", ... and 1, 2, ..."""

    population: PopulationConfig = field(default_factory=PopulationConfig)
    """People drawn at random, in addition to those listed under humans."""

    robot: Annotated[RobotConfig, ROBOTS] = field(default_factory=ROBOTS.make)
    """Robot, with its start and its goal."""

    planner: Annotated[PlannerConfig, PLANNERS] = field(
        default_factory=PLANNERS.make
    )
    """Planner that drives the robot."""

    sensors: list[Annotated[SensorConfig, SENSORS]] = field(
        default_factory=list
    )
    """Sensors, on the robot or fixed in the world."""

    robots: list[FleetMember] = field(default_factory=list)
    """Several robots, instead of `robot` and `planner`, each with sensors of
    its own."""

    evaluator: EvaluatorConfig = field(default_factory=EvaluatorConfig)
    """Recording and metrics of the trial."""

    simulation: SimulationConfig = field(default_factory=SimulationConfig)
    """Duration, time step, seed and end of the trial."""

    scene: SceneConfig = field(default_factory=SceneConfig)
    """Visualization of the trial."""

    def __post_init__(self) -> None:
        """Gives names and numbers to people without them."""
        if any(not it.name or it.id is None for it in self.humans):
            self.humans = name_people(self.humans)
