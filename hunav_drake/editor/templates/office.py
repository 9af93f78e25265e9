"""Rooms with desks on a corridor."""

import math
from typing import Annotated, ClassVar

from pydantic import Field, StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.editor.templates.base import (
    WALL,
    Template,
    person,
    scenario,
    spread,
    wall,
    walls_around,
)
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.schema import CONFIG, Integer, within
from hunav_drake.systems.world.furniture.base import Furniture
from hunav_drake.systems.world.furniture.seats import Chair
from hunav_drake.systems.world.furniture.tables import Desk
from hunav_drake.systems.world.shapes import Wall, World


@dataclass(kw_only=True, config=CONFIG)
class Office(Template):
    """Two rooms with desks on a corridor, in which the robot drives."""

    title: ClassVar[str] = "Office"

    room_width: Annotated[StrictFloat, within(4, 20, "m")] = 5.0
    """How wide each room is, in meters."""

    room_depth: Annotated[StrictFloat, within(3.5, 15, "m")] = 4.0
    """How deep each room is, in meters."""

    corridor_width: Annotated[StrictFloat, within(1.6, 6, "m")] = 2.4
    """How wide the corridor is, in meters."""

    people: Annotated[Integer, Field(ge=0, le=12)] = 8
    """How many people walk between the rooms and the corridor."""

    def make(self) -> Scenario:
        """Returns the scenario: see `Template.make`."""
        wide, deep, aisle = (
            self.room_width,
            self.room_depth,
            self.corridor_width,
        )
        low, high = aisle + WALL, aisle + WALL + deep
        row = low + 0.7
        # In front of the desks, and along the corridor.
        rooms = [
            [(x, row) for x in spread(left + 0.6, left + wide - 0.6)]
            for left in (0.0, wide)
        ]
        hall = [(x, aisle / 2) for x in spread(2.2, 2 * wide - 0.8)]
        spots = [rooms[0], rooms[1], hall]
        humans = []
        for i in range(self.people):
            start = spots[i % 3][i // 3]
            goals = [
                spots[(i + 1) % 3][-1 - i // 3],
                spots[(i + 2) % 3][i // 3],
                start,
            ]
            humans.append(person(i, start, goals, -math.pi / 2))
        return scenario(
            "Two rooms on a corridor; people walk between them.",
            World(
                walls=self._walls(low, high), furniture=self._furniture(high)
            ),
            humans,
            ((0.8, aisle / 2), (2 * wide - 0.8, aisle / 2)),
        )

    def _walls(self, low: float, high: float) -> list[Wall]:
        wide, t, door = self.room_width, WALL, 1.0
        middle = (low + high) / 2
        walls = [
            *walls_around((0.0, 0.0), (2 * wide, high)),
            wall("between", (wide, middle), (t, high - low)),
        ]
        # The wall to the corridor, with a door in the middle of each room.
        part = (wide - door) / 2
        for i, x in enumerate((part / 2, wide, 2 * wide - part / 2)):
            size = 2 * part if i == 1 else part
            walls.append(wall(f"doors_{i + 1}", (x, low - t / 2), (size, t)))
        return walls

    def _furniture(self, high: float) -> list[Furniture]:
        result: list[Furniture] = []
        for i in range(2):
            x = (i + 0.5) * self.room_width
            # At the wall; one sits in front of it, and looks at the wall.
            result.append(
                Desk(
                    name=f"desk_{i + 1}",
                    center=(x, high - 0.4),
                    yaw=-math.pi / 2,
                )
            )
            result.append(
                Chair(
                    name=f"chair_{i + 1}",
                    center=(x, high - 1.1),
                    yaw=math.pi / 2,
                )
            )
        return result
