"""A cafe with tables."""

import math
from typing import Annotated, ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from hunav_drake.editor.templates.base import (
    Template,
    chosen,
    person,
    rotated,
    rounded,
    scenario,
    walls_around,
)
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.schema import CONFIG, Integer
from hunav_drake.systems.world.furniture.base import Furniture
from hunav_drake.systems.world.furniture.seats import Chair
from hunav_drake.systems.world.furniture.tables import Counter, Table
from hunav_drake.systems.world.shapes import World


@dataclass(kw_only=True, config=CONFIG)
class Cafe(Template):
    """Tables with chairs, and aisles between them."""

    title: ClassVar[str] = "Cafe"

    tables: Annotated[Integer, Field(ge=1, le=40)] = 6
    """How many tables there are, with four chairs each."""

    guests: Annotated[Integer, Field(ge=0, le=40)] = 4
    """How many guests walk about."""

    def make(self) -> Scenario:
        """Returns the scenario: see `Template.make`."""
        # A table stands in the middle of each field; between are aisles.
        field, margin = 3.0, 0.9
        columns = math.ceil(math.sqrt(self.tables))
        rows = math.ceil(self.tables / columns)
        wide, deep = columns * field, rows * field
        furniture: list[Furniture] = [
            Counter(
                name="counter",
                center=(wide / 2, deep + margin + 0.5),
                yaw=math.pi / 2,
            )
        ]
        for i in range(self.tables):
            x = (i % columns + 0.5) * field
            y = (i // columns + 0.5) * field
            furniture += _table(i, x, y)
        corners = [
            (i * field, k * field)
            for i in range(columns + 1)
            for k in range(rows + 1)
        ]
        middles = [
            ((i + 0.5) * field, k * field)
            for i in range(columns)
            for k in range(rows + 1)
        ]
        places = [*corners[1:], *middles]
        humans = []
        for i, start in enumerate(chosen(places, self.guests, "cafe")):
            goals = [
                places[(7 * (i + 1) + step) % len(places)] for step in (0, 3)
            ]
            humans.append(person(i, start, [*goals, start], 0.0))
        top = deep + margin + 1.0
        walls = walls_around((-margin, -margin), (wide + margin, top))
        return scenario(
            "A cafe with tables; guests walk in the aisles.",
            World(walls=walls, furniture=furniture),
            humans,
            ((0.0, 0.0), (wide, deep)),
        )


def _table(index: int, x: float, y: float) -> list[Furniture]:
    result: list[Furniture] = [
        Table(name=f"table_{index + 1}", center=(x, y), size=(0.8, 0.8))
    ]
    for k in range(4):
        dx, dy = rotated((0.6, 0.0), k)
        # One looks at the table.
        yaw = math.remainder(math.pi + k * math.pi / 2, 2 * math.pi)
        result.append(
            Chair(center=rounded((x + dx, y + dy)), yaw=round(yaw, 4))
        )
    return result
