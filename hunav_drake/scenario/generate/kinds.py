"""The kinds of generated scenarios."""

from collections.abc import Sequence
import math
from typing import Annotated

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass
from scipy import ndimage
import shapely

# (It registers its kind.)
from hunav_drake.scenario.generate import barn  # noqa: F401
from hunav_drake.scenario.generate.buildings import (
    THICK,
    Door,
    free_place,
    furnish,
    possible_doors,
    spanning,
    split,
    walls_around,
)
from hunav_drake.scenario.generate.kind import (
    Draft,
    NoRoomError,
    Rect,
    ScenarioKind,
    register_kind,
)
from hunav_drake.systems.common.schema import CONFIG, Integer, PositiveLength
from hunav_drake.systems.people.population_config import Share
from hunav_drake.systems.world.shapes import Box, Disc, Wall, World

Generator = np.random.Generator

# The free floor at both ends of a field, in meters.
_END = 2.5

# The free floor around the robot at its start and goal, in meters.
_AROUND = 0.2

# The least distance from start to goal, in meters.
_FAR = 1.0

# The time limit of a trial: some seconds, and some for each meter.
_SECONDS, _SECONDS_PER_METER = 30, 4


def _between(easy: float, hard: float, difficulty: float) -> float:
    """Returns a length between that of difficulty 0 and that of 1, in m."""
    return round(easy + (hard - easy) * difficulty, 2)


@register_kind("field")
@dataclass(kw_only=True, config=CONFIG)
class Field_(ScenarioKind):
    """A square field of thin columns, made by a cellular automaton."""

    fill: Share | None = None
    """Share of the cells with a column before smoothing; by default 0.13 at
    difficulty 0 to 0.24 at 1."""

    smoothing: Annotated[Integer, Field(ge=0, le=100)] = 2
    """Number of smoothing steps, in which cells take after their neighbors."""

    side: PositiveLength = 4.5
    """Length of a side of the field, in meters."""

    column: PositiveLength = 0.075
    """Radius of the columns, and half the width of a cell, in meters."""

    def draw(self, seed: int, random: Generator) -> Draft:
        """Draws a field between two free ends and two walls.

        A cell with five or more of its eight neighbors filled becomes filled,
        with one or none empty: as in Perille et al., "Benchmarking Metric
        Ground Navigation", 2020, whose fields of BARN are as large.
        """
        hardness = self.difficulty_of(seed)
        fill = 0.13 + 0.11 * hardness if self.fill is None else self.fill
        cell = 2 * self.column
        count = math.floor(self.side / cell + 1e-9)
        if not 3 <= count <= 1000:
            raise ValueError(
                f"field, seed {seed}: side must be 3 to 1000 cells of"
                f" {cell:g} m, got {self.side:g} m"
            )
        full = random.random((count, count)) < fill
        around = np.ones((3, 3))
        around[1, 1] = 0
        for _ in range(self.smoothing):
            near = ndimage.convolve(full.astype(float), around, mode="constant")
            full = (full & (near > 1)) | (near >= 5)
        # No center of a robot is in a cell beside a column.
        wide = self.robot_radius > cell
        blocked = ndimage.binary_dilation(full) if wide else full
        rooms, _ = ndimage.label(~blocked, np.ones((3, 3)))
        if not set(rooms[:, 0]) & set(rooms[:, -1]) - {0}:
            raise NoRoomError("columns close the field")
        side = round(count * cell, 4)
        walls: list[Wall] = [
            Box(center=(x, side / 2), size=(THICK, side + 2 * _END + 2 * THICK))
            for x in (-THICK / 2, side + THICK / 2)
        ]
        walls += [
            Box(center=(side / 2, y), size=(side, THICK))
            for y in (-_END - THICK / 2, side + _END + THICK / 2)
        ]
        walls += [
            Disc(center=tuple(((it + 0.5) * cell).round(4)), radius=self.column)
            for it in np.argwhere(full)
        ]
        return Draft(
            World(walls=walls),
            self.robot((side / 2, -_END / 2), (side / 2, side + _END / 2)),
            [(0.0, -_END, side, 0.0), (0.0, side, side, side + _END)],
            round(_SECONDS + _SECONDS_PER_METER * (side + _END)),
            f"A field of {full.sum()} columns of {self.column:g} m; difficulty"
            f" {hardness:.2f}.",
        )


class _Indoors(ScenarioKind):
    """Rooms with doors and furniture."""

    def _draft(
        self,
        seed: int,
        random: Generator,
        rooms: Sequence[Rect],
        doors: Sequence[Door],
        uses: Sequence[str],
        what: str,
    ) -> Draft:
        """Returns a draft of rooms with doors, one use for each room."""
        hardness = self.difficulty_of(seed)
        places = [*rooms, *(door.rect for door in doors)]
        floor = shapely.union_all([shapely.box(*it) for it in places])
        aisle = 2 * self.robot_radius + _between(0.6, 0.25, hardness)
        furniture = []
        for i, (room, use) in enumerate(zip(rooms, uses, strict=True)):
            size = (room[2] - room[0]) * (room[3] - room[1])
            number = size * (0.04 + 0.16 * hardness) + random.random()
            furniture += furnish(
                *(room, [it for it in doors if i in it.rooms], use, random),
                number=int(number),
                aisle=aisle,
            )
        world = World(walls=[*walls_around(floor)], furniture=furniture)
        middles = np.array([np.add(it[:2], it[2:]) / 2 for it in rooms])
        first = int(random.integers(len(rooms)))
        last = int(np.hypot(*(middles - middles[first]).T).argmax())
        start, goal = (
            free_place(rooms[i], world, self.robot_radius + _AROUND, random)
            for i in (first, last)
        )
        if math.dist(start, goal) < _FAR:
            raise NoRoomError("the goal is too near to the start")
        way = abs(start[0] - goal[0]) + abs(start[1] - goal[1])
        return Draft(
            world,
            self.robot(start, goal),
            rooms,
            round(_SECONDS + _SECONDS_PER_METER * way),
            f"{what}; difficulty {hardness:.2f}.",
        )


@register_kind("corridors")
@dataclass(kw_only=True, config=CONFIG)
class Corridors(_Indoors):
    """Corridors that meet at right angles, with a few loops."""

    columns: Annotated[Integer, Field(ge=2, le=50)] = 4
    """Number of crossings along x."""

    rows: Annotated[Integer, Field(ge=2, le=50)] = 3
    """Number of crossings along y."""

    def draw(self, seed: int, random: Generator) -> Draft:
        """Draws which crossings of a grid are joined; narrow ones are hard."""
        hardness = self.difficulty_of(seed)
        width = _between(2.6, 1.6, hardness)
        xs = np.cumsum(random.uniform(3.6, 5.4, self.columns)).round(1)
        ys = np.cumsum(random.uniform(3.6, 5.4, self.rows)).round(1)
        half = width / 2
        crossings = [
            (float(x - half), float(y - half), float(x + half), float(y + half))
            for y in ys
            for x in xs
        ]
        ways = []
        for i in range(len(crossings)):
            column = i % self.columns
            nexts = [i + 1] * (column < self.columns - 1) + [i + self.columns]
            for k in nexts:
                if k < len(crossings):
                    a, b = crossings[i], crossings[k]
                    along = k == i + 1
                    rect = (
                        (a[2], a[1], b[0], a[3])
                        if along
                        else (a[0], a[3], a[2], b[1])
                    )
                    ways.append(Door(rect, (i, k)))
        chosen = spanning(ways, 0.25, random)
        rooms = [*crossings, *(it.rect for it in chosen)]
        # No furniture in crossings, and in front of them.
        doors = [
            Door(crossings[i], (i, len(crossings) + n))
            for n, way in enumerate(chosen)
            for i in way.rooms
        ]
        uses = ["hall"] * len(rooms)
        return self._draft(
            *(seed, random, rooms, doors, uses),
            f"Corridors of {width:g} m with {len(crossings)} crossings",
        )


@register_kind("rooms")
@dataclass(kw_only=True, config=CONFIG)
class Rooms(_Indoors):
    """Rooms with doors between them, and furniture."""

    width: PositiveLength = 14.0
    """Extent along x, in meters."""

    depth: PositiveLength = 10.0
    """Extent along y, in meters."""

    room: PositiveLength = 3.2
    """Least extent of a room to the middle of a wall, in meters."""

    def draw(self, seed: int, random: Generator) -> Draft:
        """Draws rooms by dividing a rectangle again and again."""
        hardness = self.difficulty_of(seed)
        rooms = split((0.0, 0.0, self.width, self.depth), self.room, random)
        door = _between(1.6, 1.0, hardness)
        doors = spanning(possible_doors(rooms, door, random), 0.3, random)
        homely = ["living", "bedroom", "kitchen", "work", "store"]
        uses = [
            homely[i] for i in random.integers(len(homely), size=len(rooms))
        ]
        what = f"{len(rooms)} rooms with doors of {door:g} m"
        return self._draft(seed, random, rooms, doors, uses, what)


@register_kind("office")
@dataclass(kw_only=True, config=CONFIG)
class Office(_Indoors):
    """An office: a corridor with rooms on both sides, desks and meetings."""

    length: PositiveLength = 20.0
    """Length of the corridor, in meters."""

    depth: PositiveLength = 5.0
    """Depth of the rooms on each side, in meters."""

    room: PositiveLength = 3.4
    """Least extent of a room to the middle of a wall, in meters."""

    def draw(self, seed: int, random: Generator) -> Draft:
        """Draws the rooms of each side by dividing it again and again."""
        hardness = self.difficulty_of(seed)
        spine, door = _between(2.6, 1.8, hardness), _between(1.4, 1.0, hardness)
        above = (0.0, spine + THICK, self.length, spine + THICK + self.depth)
        below = (0.0, -THICK - self.depth, self.length, -THICK)
        sides = [
            *split(above, self.room, random),
            *split(below, self.room, random),
        ]
        rooms = [*sides, (0.0, 0.0, self.length, spine)]
        hall = len(rooms) - 1
        ways = possible_doors(rooms, door, random)
        doors = [
            it for it in ways if hall in it.rooms or random.random() < 0.15
        ]
        joined = {hall}
        for _ in rooms:
            joined.update(*(it.rooms for it in doors if joined & {*it.rooms}))
        if len(joined) < len(rooms):
            # Rooms that no door leads to, from the corridor.
            doors += spanning([it for it in ways if it not in doors], 0, random)
        uses = random.choice(
            ["work", "meeting", "kitchen"], len(sides), p=[0.6, 0.25, 0.15]
        )
        return self._draft(
            *(seed, random, rooms, doors, [*map(str, uses), "hall"]),
            f"An office of {len(sides)} rooms along {self.length:g} m of"
            " corridor",
        )
