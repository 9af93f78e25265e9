"""Corridors, and an empty room."""

import itertools
import math
from typing import Annotated, ClassVar

from pydantic import Field, StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.editor.templates.base import (
    APART,
    WALL,
    Template,
    chosen,
    person,
    rotated,
    scenario,
    spread,
    wall,
    walls_around,
)
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.schema import CONFIG, Integer, within
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.world.shapes import World


@dataclass(kw_only=True, config=CONFIG)
class Corridor(Template):
    """A straight corridor; people walk both ways, the robot along it."""

    title: ClassVar[str] = "Corridor"

    length: Annotated[StrictFloat, within(8, 100, "m")] = 14.0
    """How long it is, in meters."""

    width: Annotated[StrictFloat, within(2, 12, "m")] = 3.0
    """How wide it is between its walls, in meters."""

    people: Annotated[Integer, Field(ge=0, le=60)] = 6
    """How many people walk in it."""

    def make(self) -> Scenario:
        """Returns the scenario: see `Template.make`."""
        x, y = self.length / 2, self.width / 2
        lanes = spread(-y + 0.5, y - 0.5)
        places = list(itertools.product(spread(2.2 - x, x - 0.5), lanes))
        humans = []
        for i, (px, py) in enumerate(chosen(places, self.people, "corridor")):
            way = 1 if i % 2 else -1
            yaw = 0.0 if way > 0 else math.pi
            ends = [(way * (x - 0.6), py), (-way * (x - 0.6), py)]
            humans.append(person(i, (px, py), ends, yaw))
        walls = [
            wall("north", (0.0, y + WALL / 2), (self.length, WALL)),
            wall("south", (0.0, -y - WALL / 2), (self.length, WALL)),
        ]
        return scenario(
            "A corridor in which people walk both ways.",
            World(walls=walls),
            humans,
            ((1 - x, 0.0), (x - 1, 0.0)),
        )


@dataclass(kw_only=True, config=CONFIG)
class Crossing(Template):
    """Two corridors that cross; people come from all four sides."""

    title: ClassVar[str] = "Crossing"

    size: Annotated[StrictFloat, within(8, 60, "m")] = 12.0
    """How long each corridor is, in meters; they are 3 m wide."""

    people_per_side: Annotated[Integer, Field(ge=0, le=6)] = 2
    """How many people come from each side."""

    def make(self) -> Scenario:
        """Returns the scenario: see `Template.make`."""
        half, aisle = self.size / 2, 1.5
        block = half - aisle
        middle = aisle + block / 2
        walls = [
            wall(name, (sx * middle, sy * middle), (block, block))
            for name, sx, sy in (
                ("north_east", 1, 1),
                ("north_west", -1, 1),
                ("south_west", -1, -1),
                ("south_east", 1, -1),
            )
        ]
        humans: list[HumanConfig] = []
        # Two abreast; the robot starts between them.
        queue = [
            (half - 0.5 - APART * row, side)
            for row in range(3)
            for side in (-0.9, 0.9)
        ]
        for turn in range(4):
            yaw = turn * math.pi / 2
            for back, side in queue[: self.people_per_side]:
                start = rotated((-back, side), turn)
                goals = [
                    rotated((half - 0.5, side), turn),
                    rotated((0.5 - half, side), turn),
                ]
                heading = math.remainder(yaw, 2 * math.pi)
                humans.append(person(len(humans), start, goals, heading))
        return scenario(
            "Two corridors that cross, with people from all sides.",
            World(walls=walls),
            humans,
            ((0.6 - half, 0.0), (half - 0.6, 0.0)),
        )


@dataclass(kw_only=True, config=CONFIG)
class Room(Template):
    """An empty room with the robot, to place everything by hand."""

    title: ClassVar[str] = "Empty room"

    width: Annotated[StrictFloat, within(3, 200, "m")] = 8.0
    """How wide the room is, in meters."""

    depth: Annotated[StrictFloat, within(2, 200, "m")] = 6.0
    """How deep the room is, in meters."""

    def make(self) -> Scenario:
        """Returns the scenario: see `Template.make`."""
        x, y = self.width / 2, self.depth / 2
        world = World(walls=walls_around((-x, -y), (x, y)))
        return scenario("A room.", world, [], ((1 - x, 0.0), (x - 1, 0.0)))
