"""Walls of rooms and corridors, and places for people to start."""

from collections.abc import Sequence
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.world.obstacles import inside
from hunav_drake.systems.world.shapes import Box, Wall, World

Array = NDArray[np.float64]

# How thick walls are if nothing else is said, in meters.
THICK = 0.2

# The part of the room around a place by which it is off the grid.
_DISORDER = 0.8

# How deep in a wall somebody must be to count as inside, in meters.
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

    def holds(self, states: Array) -> NDArray[np.bool_]:
        """Tells which rows (..., 2 or more), from x and y on, are within."""
        x, y = states[..., 0], states[..., 1]
        result: NDArray[np.bool_] = (
            (x >= self.x0) & (x < self.x1) & (y >= self.y0) & (y < self.y1)
        )
        return result


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
    """Returns a wall across x, from `x` on, with a door in it.

    Args:
        x: Where it begins, in meters.
        low: Its least y.
        high: Its largest y.
        middle: The y of the middle of the door.
        width: The width of the door.
        thick: How thick the wall is.
    """
    return [
        wall(x, low, x + thick, middle - width / 2),
        wall(x, middle + width / 2, x + thick, high),
    ]


def room(
    length: float, width: float, door: float, thick: float = THICK
) -> list[Box]:
    """Returns a room from (0, 0), with a door in the middle of its right side.

    Args:
        length: Along x, in meters.
        width: Along y, in meters.
        door: The width of the door, in meters.
        thick: How thick the wall with the door is, in meters.
    """
    return [
        wall(-THICK, -THICK, 0, width + THICK),
        *corridor(0, length + thick, width),
        *gap_in_wall(length, 0, width, width / 2, door, thick),
    ]


def spread(
    n: int, area: Area, generator: np.random.Generator, radius: float = 0.2
) -> Array:
    """Returns places for people that are spread evenly, not quite in order.

    Each has a cell of a grid of its own, and is off its middle by a draw. The
    cells that are left over are drawn, too.

    Args:
        n: How many.
        area: Where.
        generator: What is drawn from.
        radius: That of their bodies, which do not overlap, in meters.

    Returns:
        Shape (n, 2), in meters.

    Raises:
        ValueError: If there is no room for so many.
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
    """Returns how many positions (..., 2) are in a wall, by over 1 mm."""
    shrunk: list[Wall] = [
        Box(
            center=box.center,
            size=(box.size[0] - 2 * _BUFFER, box.size[1] - 2 * _BUFFER),
        )
        for box in walls
    ]
    return int(inside(World(walls=shrunk).obstacles(), positions).sum())
