"""The common options of generated scenarios, and how one is drawn."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
import dataclasses as dc
from dataclasses import field
import math
from pathlib import Path
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import BeforeValidator, Field, StrictStr, ValidationError
from pydantic.dataclasses import dataclass
import shapely

from hunav_drake.scenario.checks import CheckScenario
from hunav_drake.scenario.error import ScenarioError
from hunav_drake.scenario.population import with_drawn_people
from hunav_drake.scenario.schema import Scenario, SimulationConfig
from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.plain_errors import message_of
from hunav_drake.systems.common.random_streams import Purpose, stream
from hunav_drake.systems.common.registry import Registry, name_of
from hunav_drake.systems.common.schema import (
    CONFIG,
    BodyRadius,
    FileName,
    Integer,
    as_tuple,
)
from hunav_drake.systems.common.suggest import suggestion
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.people.area import Area
from hunav_drake.systems.people.population import PopulationError
from hunav_drake.systems.people.population_config import (
    CohortConfig,
    PopulationConfig,
    Share,
    Weight,
)
from hunav_drake.systems.planning.planner import PLANNERS
from hunav_drake.systems.robot.robot_config import ROBOTS, RobotConfig
from hunav_drake.systems.world.shapes import World

# (x_min, y_min, x_max, y_max) in W, in meters.
Rect = tuple[float, float, float, float]

# The number of worlds that are drawn before a seed is given up, and how many of
# them may lack room for people.
_DRAWS, _CROWDED = 100, 20

# The room beside a robot on its way, for planners on maps of 5 cm, in meters.
_EASE = 0.1

# The number of goals of each person.
_GOALS = 3

# The difficulties of seeds follow each other by this part of their range.
_GOLDEN = (math.sqrt(5) - 1) / 2


class NoRoomError(ValueError):
    """A drawn world has no room for something; another draw may have."""


class Draft(NamedTuple):
    """A drawn world, without people.

    Attributes:
        world: Walls and furniture.
        robot: The robot, with its start and its goal.
        areas: Where people start, and where their goals are.
        duration: The time limit of the trial, in seconds.
        description: The trial in one line.
    """

    world: World
    robot: RobotConfig
    areas: Sequence[Rect]
    duration: float
    description: str


def _as_range(value: Any) -> Any:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return (float(value),) * 2 if is_number else as_tuple(value)


@explain
@dataclass(kw_only=True, config=CONFIG)
class ScenarioKind(ABC):
    """The common options of all kinds of generated scenarios."""

    is_drawn: ClassVar[bool] = True
    """Whether another draw of the same seed may have what one lacks."""

    name: FileName = ""
    """Name of the scenarios in a suite; by default that of the kind."""

    difficulty: Annotated[
        tuple[Share, Share], BeforeValidator(_as_range), Field()
    ] = (0.5, 0.5)
    """Difficulty, from 0 (spacious) to 1 (cluttered); of a range [low, high],
    each seed has its own, and seeds are spread evenly over it."""

    people: Annotated[Integer, Field(ge=0, le=1000)] = 4
    """Number of people, each with a way of up to three goals."""

    behaviors: dict[StrictStr, Weight] = field(
        default_factory=lambda: {"regular": 1.0}
    )
    """Behaviors, with weights in proportion to which they are drawn."""

    robot_radius: BodyRadius = 0.275
    """Radius of the robot's disc, in meters; there is a way for it. Planners
    with maps take 0.275 m for radii up to 0.35 m, unless they are told."""

    @abstractmethod
    def draw(self, seed: int, random: np.random.Generator) -> Draft:
        """Draws a world.

        Raises:
            NoRoomError: If this draw has no room for something.
            ValueError: If no draw of the seed has.
        """

    def difficulty_of(self, seed: int) -> float:
        """Returns the difficulty of a seed, in [0, 1]."""
        low, high = self.difficulty
        return low + (high - low) * ((seed * _GOLDEN) % 1.0)

    def files(self) -> list[Path]:
        """Returns all files that scenarios are read from, if any."""
        return []

    def numbers(self, recording: Recording, seed: int) -> dict[str, float]:
        """Returns further numbers of a trial, by name, such as a score."""
        del recording, seed
        return {}

    def robot(
        self, start: Sequence[float], goal: Sequence[float], **options: Any
    ) -> RobotConfig:
        """Returns the robot from (x, y) to (x, y), in meters, facing it."""
        yaw = round(math.atan2(goal[1] - start[1], goal[0] - start[0]), 3)
        places = {"start": (*start, yaw), "goal": (*goal, yaw)}
        # Any heading at the goal will do.
        given = {"radius": self.robot_radius, "goal_yaw_tolerance": 3.15}
        robot: RobotConfig = ROBOTS.make({**given, **places, **options})
        return robot


# The kinds by name.
KINDS = Registry(
    "kind of scenario", ScenarioKind, home="hunav_drake.scenario.generate.kinds"
)

register_kind = KINDS.register


def GenerateScenario(
    kind: str | ScenarioKind, *, seed: int = 0, **options: Any
) -> Scenario:
    """Returns a scenario that follows from its kind, options and seed.

    All goals can be reached: worlds are drawn until they can.

    Args:
        kind: The name of a kind: "field", "corridors", "rooms", "office",
            "barn"; or a kind with its options.
        seed: The seed, a whole number from 0; of "barn", the number of the
            world.
        options: The options of the kind, such as `difficulty=0.3, people=6`.

    Raises:
        ValueError: If there is no such kind or option, an option is out of
            its range, or no world with these options could be drawn.
    """
    if isinstance(kind, str):
        kind = make_kind({"type": kind, **options})
    elif options:
        kind = dc.replace(kind, **options)
    return draw_scenario(kind, seed)[0]


def make_kind(data: Mapping[str, Any]) -> ScenarioKind:
    """Returns a kind from its `type` and options.

    Raises:
        ValueError: If there is no such kind or option, or an option is out of
            its range.
    """
    try:
        kind: ScenarioKind = KINDS.make(data)
    except ValidationError as error:
        found = error.errors(include_url=False)[0]
        # (Both ends of a range have the same rule.)
        place = ".".join(it for it in found["loc"] if isinstance(it, str))
        told = message_of(found["type"], found)
        if found["type"] == "unexpected_keyword_argument":
            names = [it.name for it in dc.fields(KINDS[data["type"]])]
            told = f"there is no such option; {suggestion(place, names)}"
        raise ValueError(f"{place}: {told}") from error
    return kind


def draw_scenario(kind: ScenarioKind, seed: int) -> tuple[Scenario, int]:
    """Returns the scenario of a seed, and the number of draws that it took.

    Raises:
        ValueError: If none of 100 draws has ways for the robot and everybody.
    """
    what = f"{name_of(kind)}, seed {seed}"
    _check_people(kind, what)
    lacks: Exception | str = ""
    draws, crowded = 0, 0
    while draws < (_DRAWS if kind.is_drawn else 1) and crowded < _CROWDED:
        draws += 1
        random = stream(seed, draws - 1, Purpose.WORLD)
        try:
            draft = kind.draw(seed, random)
            if kind.is_drawn and not _leads_to_goal(draft):
                raise NoRoomError("the robot has no way to its goal")
            scenario = _with_people(kind, draft, seed)
            return CheckScenario(scenario), draws
        except (NoRoomError, PopulationError, ScenarioError) as error:
            lacks = error
            crowded += not isinstance(error, NoRoomError)
    reason = str(lacks).splitlines()[-1].strip()
    raise ValueError(
        f"{what}: no ways for the robot and {kind.people} people in"
        f" {draws} draw{'s' * (draws > 1)} of a world; the last: {reason};"
        " lower difficulty, people or robot_radius"
    )


def _cohort(kind: ScenarioKind, areas: Sequence[Rect]) -> PopulationConfig:
    places = [Area(rectangle=it) for it in areas]
    cohort = CohortConfig(
        number=kind.people,
        start=places,
        goals=places,
        shuffle_goals=True,
        behaviors=kind.behaviors,
    )
    return PopulationConfig(cohorts=[cohort] if kind.people else [])


def _check_people(kind: ScenarioKind, what: str) -> None:
    """Checks the behaviors in a world with room for everybody."""
    try:
        CheckScenario(Scenario(population=_cohort(kind, [(9, 9, 999, 999)])))
    except ValueError as error:
        reason = str(error).splitlines()[-1].strip()
        raise ValueError(f"{what}: {reason}") from error


def _leads_to_goal(draft: Draft) -> bool:
    assert draft.robot.goal is not None
    ends = [
        shapely.Point(it[:2]) for it in (draft.robot.start, draft.robot.goal)
    ]
    # All at once: faster than `FreeSpace`, which knows what is beside a way.
    solid = shapely.union_all(
        [
            shapely.Polygon(outline)
            for fixture in draft.world.fixtures()
            for outline in fixture.footprints
        ]
    )
    thick = solid.buffer(draft.robot.radius + _EASE, quad_segs=4)
    # Around a world without walls, there is floor.
    whole = shapely.union_all([thick, *ends]).buffer(1.0).envelope
    rooms = shapely.get_parts(whole.difference(thick))
    return any(all(room.covers(it) for it in ends) for room in rooms)


def _with_people(kind: ScenarioKind, draft: Draft, seed: int) -> Scenario:
    population = _cohort(kind, draft.areas)
    scenario = Scenario(
        name=f"{kind.name or name_of(kind)}_{seed}",
        description=draft.description,
        world=draft.world,
        population=dc.replace(population, seed=seed),
        robot=draft.robot,
        planner=PLANNERS.make("dwb"),
        simulation=SimulationConfig(
            duration=draft.duration, seed=seed, start_jitter=0.05
        ),
    )
    listed, _ = with_drawn_people(scenario)
    listed.humans = [
        dc.replace(
            human,
            pose=(
                round(human.pose[0], 3),
                round(human.pose[1], 3),
                round(human.pose[2], 3),
            ),
            goals=[tuple(np.round(it, 3)) for it in human.goals[:_GOALS]],
            desired_speed=round(human.desired_speed, 3),
            body_radius=round(human.body_radius or human.radius, 3),
        )
        for human in listed.humans
    ]
    return listed
