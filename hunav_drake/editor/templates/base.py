"""What all templates have, and what they are made with."""

from abc import ABC, abstractmethod
import math
from typing import ClassVar

from hunav_drake.scenario.schema import Scenario, SimulationConfig
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.robot.robots import DifferentialDriveConfig
from hunav_drake.systems.world.shapes import Box, Wall, World

Place = tuple[float, float]

# How thick walls are, in meters, and how far apart people start at least.
WALL = 0.2
APART = 0.8

_NAMES = [
    "ana",
    "ben",
    "carla",
    "dan",
    "eva",
    "finn",
    "gina",
    "hugo",
    "ines",
    "jon",
    "kim",
    "leo",
]
_BEHAVIORS = ("regular", "regular", "curious", "impassive")


class Template(ABC):
    """A kind of place; its fields are what one chooses of it."""

    # What it is called.
    title: ClassVar[str]

    @abstractmethod
    def make(self) -> Scenario:
        """Returns the scenario.

        Raises:
            ValueError: If there is no room for so many people.
        """


def spread(low: float, high: float) -> list[float]:
    """Returns places in an interval, as many as there is room for."""
    count = int((high - low + 1e-9) / APART) + 1
    if count <= 1:
        return [(low + high) / 2]
    step = (high - low) / (count - 1)
    return [low + k * step for k in range(count)]


def chosen(places: list[Place], count: int, what: str) -> list[Place]:
    """Returns some of the places, spread over all of them."""
    if count > len(places):
        raise ValueError(
            f"there is room for {len(places)} people in this {what}, not for"
            f" {count}; make it larger, or take fewer"
        )
    return [places[i * len(places) // count] for i in range(count)]


def rotated(place: Place, turns: int) -> Place:
    """Returns a place after some quarter turns about the origin."""
    x, y = place
    for _ in range(turns):
        x, y = -y, x
    return x, y


def rounded(place: Place) -> Place:
    """Returns a place in whole millimeters."""
    return round(place[0], 3), round(place[1], 3)


def person(
    index: int, start: Place, goals: list[Place], yaw: float
) -> HumanConfig:
    """Returns somebody with a name, who walks from goal to goal."""
    turn, letter = divmod(index, len(_NAMES))
    return HumanConfig(
        name=_NAMES[letter] + (f"_{turn + 1}" if turn else ""),
        id=index + 1,
        pose=(*rounded(start), round(yaw, 4)),
        behavior=_BEHAVIORS[index % len(_BEHAVIORS)],
        goals=[rounded(goal) for goal in goals],
        cyclic=True,
    )


def wall(name: str, center: Place, size: Place) -> Wall:
    """Returns a wall along x or y: a box."""
    return Box(name=name, center=rounded(center), size=rounded(size))


def walls_around(low: Place, high: Place) -> list[Wall]:
    """Returns four walls around a floor from one corner to the opposite."""
    (x0, y0), (x1, y1), t = low, high, WALL
    x, y, wide, deep = (x0 + x1) / 2, (y0 + y1) / 2, x1 - x0, y1 - y0
    return [
        wall("south", (x, y0 - t / 2), (wide + 2 * t, t)),
        wall("north", (x, y1 + t / 2), (wide + 2 * t, t)),
        wall("west", (x0 - t / 2, y), (t, deep)),
        wall("east", (x1 + t / 2, y), (t, deep)),
    ]


def scenario(
    description: str,
    world: World,
    humans: list[HumanConfig],
    way: tuple[Place, Place],
) -> Scenario:
    """Returns a scenario whose robot has a way: a start and a goal."""
    start, goal = map(rounded, way)
    yaw = round(math.atan2(goal[1] - start[1], goal[0] - start[0]), 4)
    return Scenario(
        description=description,
        world=world,
        humans=humans,
        robot=DifferentialDriveConfig(start=(*start, yaw), goal=(*goal, yaw)),
        simulation=SimulationConfig(duration=120.0),
    )
