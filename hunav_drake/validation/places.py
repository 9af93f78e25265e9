"""Walls of rooms and corridors, and places for people to start."""

from collections.abc import Sequence
import math
from typing import NamedTuple

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.world.obstacles import inside
from hunav_drake.systems.world.shapes import Box, Wall, World

# The default thickness of walls, in meters.
THICK = 0.2

# The largest offset from the grid, as a fraction of the free room.
_DISORDER = 0.8

# The depth in a wall from which a person counts as inside, in meters.
_BUFFER = 1e-3


class Area(NamedTuple):
    """A rectangle, in meters."""

    x0: float
    y0: float
    x1: float
    y1: float

    @property
    def size(self) -> float:
        """Its area, in m^2."""
        return (self.x1 - self.x0) * (self.y1 - self.y0)

    def holds(self, states: Array) -> Mask:
        """Returns which rows (..., 2 or more) of x, y, ... are inside."""
        x, y = states[..., 0], states[..., 1]
        in_x = (x >= self.x0) & (x < self.x1)
        return in_x & (y >= self.y0) & (y < self.y1)


def wall(x0: float, y0: float, x1: float, y1: float) -> Box:
    """Returns a wall between two corners."""
    return Box(
        center=((x0 + x1) / 2, (y0 + y1) / 2), size=(abs(x1 - x0), abs(y1 - y0))
    )


def corridor(x0: float, x1: float, width: float) -> list[Box]:
    """Returns the two walls of a corridor along x, from y = 0 to a width."""
    return [wall(x0, -THICK, x1, 0), wall(x0, width, x1, width + THICK)]


def gap_in_wall(
    x: float,
    low: float,
    high: float,
    middle: float,
    width: float,
    thick: float = THICK,
) -> list[Box]:
    """Returns a wall from x on, from y = low to high, with a door.

    The door has its middle at y = `middle`. All are in meters.
    """
    return [
        wall(x, low, x + thick, middle - width / 2),
        wall(x, middle + width / 2, x + thick, high),
    ]


def room(
    length: float, width: float, door: float, thick: float = THICK
) -> list[Box]:
    """Returns a room from (0, 0), with a door in the middle of its right side.

    The length is along x, `thick` is the thickness of the wall with the door.
    All are in meters.
    """
    return [
        wall(-THICK, -THICK, 0, width + THICK),
        *corridor(0, length + thick, width),
        *gap_in_wall(length, 0, width, width / 2, door, thick),
    ]


def spread(
    n: int, area: Area, generator: np.random.Generator, radius: float = 0.2
) -> Array:
    """Returns n evenly distributed places for people, shape (n, 2), in meters.

    Each has its own cell of a grid, and a random offset from its middle. The
    empty cells are random, too. Bodies of the given radius do not overlap.

    Raises:
        ValueError: If there is no room for n people.
    """
    if n == 0:
        return np.zeros((0, 2))
    length, width = area.x1 - area.x0, area.y1 - area.y0
    rows = max(1, round(math.sqrt(n * width / length)))
    columns = math.ceil(n / rows)
    cell = np.array([length / columns, width / rows])
    room = cell / 2 - radius
    if room.min() < 0:
        raise ValueError(
            f"{n} people of {radius:g} m do not fit into {length:g} x"
            f" {width:g} m"
        )
    chosen = np.sort(generator.permutation(rows * columns)[:n])
    middle = np.stack([chosen // rows, chosen % rows], axis=1) + 0.5
    off = generator.uniform(-_DISORDER, _DISORDER, (n, 2)) * np.minimum(
        room, 0.15 * cell.min()
    )
    places: Array = np.array([area.x0, area.y0]) + middle * cell + off
    return places


def samples_in_walls(walls: Sequence[Box], positions: Array) -> int:
    """Returns the number of positions (..., 2) over 1 mm deep in a wall."""
    shrunk: list[Wall] = [
        Box(
            center=box.center,
            size=(box.size[0] - 2 * _BUFFER, box.size[1] - 2 * _BUFFER),
        )
        for box in walls
    ]
    return int(inside(World(walls=shrunk).obstacles(), positions).sum())
