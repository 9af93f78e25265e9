"""Scenarios to start with: places of some size, with people in them."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
import itertools
import math
from typing import Annotated, Any, ClassVar

from pydantic import Field, StrictFloat, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from hunav_drake.editor.document.plain_data import OperationError
from hunav_drake.editor.faults import DEFERRED
from hunav_drake.scenario.json_schema import described_schema
from hunav_drake.scenario.schema import Scenario, SimulationConfig
from hunav_drake.scenario.writer import SaveScenario
from hunav_drake.systems.common.choice_loading import registered_only
from hunav_drake.systems.common.schema import CONFIG, Integer, within
from hunav_drake.systems.common.suggest import shown, suggestion
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.robot.robot_config import DifferentialDriveConfig
from hunav_drake.systems.world.furniture.base import Furniture
from hunav_drake.systems.world.furniture.seats import Chair
from hunav_drake.systems.world.furniture.tables import Counter, Desk, Table
from hunav_drake.systems.world.shapes import Box, Wall, World

Place = tuple[float, float]

# How thick walls are, in meters, and how far apart people start at least.
_WALL = 0.2
_APART = 0.8

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


@dataclass(kw_only=True, config=CONFIG)
class Corridor(Template):
    """A straight corridor; people walk both ways, the robot along it."""

    title: ClassVar[str] = "Corridor"

    # How long it is, in meters.
    length: Annotated[StrictFloat, within(8, 100, "m")] = 14.0

    # How wide it is between its walls, in meters.
    width: Annotated[StrictFloat, within(2, 12, "m")] = 3.0

    # How many people walk in it.
    people: Annotated[Integer, Field(ge=0, le=60)] = 6

    def make(self) -> Scenario:
        """Returns the scenario: see `Template.make`."""
        x, y = self.length / 2, self.width / 2
        lanes = _spread(-y + 0.5, y - 0.5)
        places = list(itertools.product(_spread(2.2 - x, x - 0.5), lanes))
        humans = []
        for i, (px, py) in enumerate(_chosen(places, self.people, "corridor")):
            way = 1 if i % 2 else -1
            yaw = 0.0 if way > 0 else math.pi
            ends = [(way * (x - 0.6), py), (-way * (x - 0.6), py)]
            humans.append(_person(i, (px, py), ends, yaw))
        walls = [
            _wall("north", (0.0, y + _WALL / 2), (self.length, _WALL)),
            _wall("south", (0.0, -y - _WALL / 2), (self.length, _WALL)),
        ]
        return _scenario(
            "A corridor in which people walk both ways.",
            World(walls=walls),
            humans,
            ((1 - x, 0.0), (x - 1, 0.0)),
        )


@dataclass(kw_only=True, config=CONFIG)
class Crossing(Template):
    """Two corridors that cross; people come from all four sides."""

    title: ClassVar[str] = "Crossing"

    # How long each corridor is, in meters; they are 3 m wide.
    size: Annotated[StrictFloat, within(8, 60, "m")] = 12.0

    # How many people come from each side.
    people_per_side: Annotated[Integer, Field(ge=0, le=6)] = 2

    def make(self) -> Scenario:
        """Returns the scenario: see `Template.make`."""
        half, aisle = self.size / 2, 1.5
        block = half - aisle
        middle = aisle + block / 2
        walls = [
            _wall(name, (sx * middle, sy * middle), (block, block))
            for name, sx, sy in (
                ("north_east", 1, 1),
                ("north_west", -1, 1),
                ("south_west", -1, -1),
                ("south_east", 1, -1),
            )
        ]
        humans = []
        # Two abreast; the robot starts between them.
        queue = [
            (half - 0.5 - _APART * row, side)
            for row in range(3)
            for side in (-0.9, 0.9)
        ]
        for turn in range(4):
            yaw = turn * math.pi / 2
            for back, side in queue[: self.people_per_side]:
                start = _rotated((-back, side), turn)
                goals = [
                    _rotated((half - 0.5, side), turn),
                    _rotated((0.5 - half, side), turn),
                ]
                heading = math.remainder(yaw, 2 * math.pi)
                humans.append(_person(len(humans), start, goals, heading))
        return _scenario(
            "Two corridors that cross, with people from all sides.",
            World(walls=walls),
            humans,
            ((0.6 - half, 0.0), (half - 0.6, 0.0)),
        )


@dataclass(kw_only=True, config=CONFIG)
class Office(Template):
    """Two rooms with desks on a corridor, in which the robot drives."""

    title: ClassVar[str] = "Office"

    # How wide and how deep each room is, in meters.
    room_width: Annotated[StrictFloat, within(4, 20, "m")] = 5.0
    room_depth: Annotated[StrictFloat, within(3.5, 15, "m")] = 4.0

    # How wide the corridor is, in meters.
    corridor_width: Annotated[StrictFloat, within(1.6, 6, "m")] = 2.4

    # How many people walk between the rooms and the corridor.
    people: Annotated[Integer, Field(ge=0, le=12)] = 8

    def make(self) -> Scenario:
        """Returns the scenario: see `Template.make`."""
        wide, deep, aisle = (
            self.room_width,
            self.room_depth,
            self.corridor_width,
        )
        low, high = aisle + _WALL, aisle + _WALL + deep
        row = low + 0.7
        # In front of the desks, and along the corridor.
        rooms = [
            [(x, row) for x in _spread(left + 0.6, left + wide - 0.6)]
            for left in (0.0, wide)
        ]
        hall = [(x, aisle / 2) for x in _spread(2.2, 2 * wide - 0.8)]
        spots = [rooms[0], rooms[1], hall]
        humans = []
        for i in range(self.people):
            start = spots[i % 3][i // 3]
            goals = [
                spots[(i + 1) % 3][-1 - i // 3],
                spots[(i + 2) % 3][i // 3],
                start,
            ]
            humans.append(_person(i, start, goals, -math.pi / 2))
        return _scenario(
            "Two rooms on a corridor; people walk between them.",
            World(
                walls=self._walls(low, high), furniture=self._furniture(high)
            ),
            humans,
            ((0.8, aisle / 2), (2 * wide - 0.8, aisle / 2)),
        )

    def _walls(self, low: float, high: float) -> list[Wall]:
        wide, t, door = self.room_width, _WALL, 1.0
        tall = high + 2 * t
        middle = (low + high) / 2
        walls = [
            _wall("south", (wide, -t / 2), (2 * wide + 2 * t, t)),
            _wall("north", (wide, high + t / 2), (2 * wide + 2 * t, t)),
            _wall("west", (-t / 2, high / 2), (t, tall - t)),
            _wall("east", (2 * wide + t / 2, high / 2), (t, tall - t)),
            _wall("between", (wide, middle), (t, high - low)),
        ]
        # The wall to the corridor, with a door in the middle of each room.
        part = (wide - door) / 2
        for i, x in enumerate((part / 2, wide, 2 * wide - part / 2)):
            size = 2 * part if i == 1 else part
            walls.append(_wall(f"doors_{i + 1}", (x, low - t / 2), (size, t)))
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


@dataclass(kw_only=True, config=CONFIG)
class Cafe(Template):
    """Tables with chairs, and aisles between them."""

    title: ClassVar[str] = "Cafe"

    # How many tables there are, with four chairs each.
    tables: Annotated[Integer, Field(ge=1, le=40)] = 6

    # How many guests walk about.
    guests: Annotated[Integer, Field(ge=0, le=40)] = 4

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
        for i, start in enumerate(_chosen(places, self.guests, "cafe")):
            goals = [
                places[(7 * (i + 1) + step) % len(places)] for step in (0, 3)
            ]
            humans.append(_person(i, start, [*goals, start], 0.0))
        top = deep + margin + 1.0
        width, middle = wide + 2 * margin, wide / 2
        height, y = top + margin, (top - margin) / 2
        walls = [
            _wall("south", (middle, -margin - 0.1), (width + 0.4, _WALL)),
            _wall("north", (middle, top + 0.1), (width + 0.4, _WALL)),
            _wall("west", (-margin - 0.1, y), (_WALL, height)),
            _wall("east", (wide + margin + 0.1, y), (_WALL, height)),
        ]
        return _scenario(
            "A cafe with tables; guests walk in the aisles.",
            World(walls=walls, furniture=furniture),
            humans,
            ((0.0, 0.0), (wide, deep)),
        )


@dataclass(kw_only=True, config=CONFIG)
class Room(Template):
    """An empty room with the robot, to place everything by hand."""

    title: ClassVar[str] = "Empty room"

    # How wide and how deep it is, in meters.
    width: Annotated[StrictFloat, within(3, 200, "m")] = 8.0
    depth: Annotated[StrictFloat, within(2, 200, "m")] = 6.0

    def make(self) -> Scenario:
        """Returns the scenario: see `Template.make`."""
        x, y, t = self.width / 2, self.depth / 2, _WALL
        walls = [
            _wall("south", (0.0, -y - t / 2), (self.width + 2 * t, t)),
            _wall("north", (0.0, y + t / 2), (self.width + 2 * t, t)),
            _wall("west", (-x - t / 2, 0.0), (t, self.depth)),
            _wall("east", (x + t / 2, 0.0), (t, self.depth)),
        ]
        return _scenario(
            "A room.", World(walls=walls), [], ((1 - x, 0.0), (x - 1, 0.0))
        )


TEMPLATES: dict[str, type[Template]] = {
    "room": Room,
    "corridor": Corridor,
    "crossing": Crossing,
    "office": Office,
    "cafe": Cafe,
}


def template_forms() -> list[dict[str, Any]]:
    """Returns what a page needs to offer the templates."""
    result = []
    for name, template in TEMPLATES.items():
        schema = described_schema(template)
        defaults = {
            key: part.get("default")
            for key, part in schema.get("properties", {}).items()
        }
        result.append(
            {
                "name": name,
                "title": template.title,
                "schema": schema,
                "defaults": defaults,
            }
        )
    return result


def template_text(name: str, values: Mapping[str, Any]) -> str:
    """Returns the text of the scenario that a template makes.

    Args:
        name: One of `TEMPLATES`.
        values: Values for its fields; the others have their defaults.

    Raises:
        OperationError: If there is no such template, or no such scenario.
    """
    if name not in TEMPLATES:
        raise OperationError(
            f"there is no template {shown(name)};"
            f" {suggestion(name, list(TEMPLATES))}"
        )
    try:
        adapter: TypeAdapter[Any] = TypeAdapter(TEMPLATES[name])
        template = adapter.validate_python(dict(values))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"])) or name
        raise OperationError(
            f"template {name}: {place}: {first['msg']}"
        ) from None
    with registered_only(*DEFERRED):
        try:
            return SaveScenario(template.make())
        except ValueError as error:
            raise OperationError(f"template {name}: {error}") from error


def _spread(low: float, high: float) -> list[float]:
    """Returns places in an interval, as many as there is room for."""
    count = int((high - low + 1e-9) / _APART) + 1
    if count <= 1:
        return [(low + high) / 2]
    step = (high - low) / (count - 1)
    return [low + k * step for k in range(count)]


def _chosen(places: list[Place], count: int, what: str) -> list[Place]:
    """Returns some of the places, spread over all of them."""
    if count > len(places):
        raise ValueError(
            f"there is room for {len(places)} people in this {what}, not for"
            f" {count}; make it larger, or take fewer"
        )
    return [places[i * len(places) // count] for i in range(count)]


def _rotated(place: Place, turns: int) -> Place:
    """Returns a place after some quarter turns about the origin."""
    x, y = place
    for _ in range(turns):
        x, y = -y, x
    return x, y


def _rounded(place: Place) -> Place:
    return round(place[0], 3), round(place[1], 3)


def _person(
    index: int, start: Place, goals: list[Place], yaw: float
) -> HumanConfig:
    turn, letter = divmod(index, len(_NAMES))
    return HumanConfig(
        name=_NAMES[letter] + (f"_{turn + 1}" if turn else ""),
        id=index + 1,
        pose=(*_rounded(start), round(yaw, 4)),
        behavior=_BEHAVIORS[index % len(_BEHAVIORS)],
        goals=[_rounded(goal) for goal in goals],
        cyclic=True,
    )


def _wall(name: str, center: Place, size: Place) -> Box:
    return Box(name=name, center=_rounded(center), size=_rounded(size))


def _table(index: int, x: float, y: float) -> list[Furniture]:
    result: list[Furniture] = [
        Table(name=f"table_{index + 1}", center=(x, y), size=(0.8, 0.8))
    ]
    for k in range(4):
        dx, dy = _rotated((0.6, 0.0), k)
        # One looks at the table.
        yaw = math.remainder(math.pi + k * math.pi / 2, 2 * math.pi)
        result.append(
            Chair(center=_rounded((x + dx, y + dy)), yaw=round(yaw, 4))
        )
    return result


def _scenario(
    description: str,
    world: World,
    humans: list[HumanConfig],
    way: tuple[Place, Place],
) -> Scenario:
    start, goal = map(_rounded, way)
    yaw = round(math.atan2(goal[1] - start[1], goal[0] - start[0]), 4)
    return Scenario(
        description=description,
        world=world,
        humans=humans,
        robot=DifferentialDriveConfig(start=(*start, yaw), goal=(*goal, yaw)),
        simulation=SimulationConfig(duration=120.0),
    )
