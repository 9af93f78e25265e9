"""The fixed world: walls and furniture, and the same as arrays of segments."""

from abc import ABC, abstractmethod
from dataclasses import field
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.common.schema import (
    CONFIG,
    Angle,
    Name,
    Point,
    Points,
    PositiveLength,
    Size,
)
from hunav_drake.systems.world.obstacles import Obstacles


@dataclass(kw_only=True, config=CONFIG)
class Wall(ABC):
    """What all shapes of walls have."""

    # Whether it has an inside, where nobody can be.
    solid: ClassVar[bool] = True

    # What it is called in messages and in the scene.
    name: Name = ""

    # How high it stands in the scene, in meters.
    height: PositiveLength = 1.0

    @abstractmethod
    def vertices(self) -> Array:
        """Returns the points of its outline in W, shape (k, 2), in meters.

        For a solid shape, the last joins the first.
        """


WALLS = Registry("wall shape", Wall, tag="shape")

register_wall = WALLS.register


@register_wall("box")
@dataclass(kw_only=True, config=CONFIG)
class Box(Wall):
    """A solid rectangle: a wall with its thickness, a table, a shelf."""

    # The center, in meters.
    center: Point

    # The full extents along its own axes, in meters.
    size: Size

    # The rotation about the vertical, in radians.
    yaw: Angle = 0.0

    def vertices(self) -> Array:
        """Returns the four corners, counter-clockwise, shape (4, 2)."""
        half = np.array(self.size) / 2
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        vertices = np.array(self.center) + corners @ [[c, s], [-s, c]]
        return np.asarray(vertices, dtype=float)


@register_wall("polygon")
@dataclass(kw_only=True, config=CONFIG)
class Polygon(Wall):
    """A solid simple polygon, in either direction of rotation."""

    # The corners, three to a thousand, in meters; the last joins the first.
    points: Annotated[Points, Field(min_length=3, max_length=1000)]

    def vertices(self) -> Array:
        """Returns the corners as given, shape (k, 2)."""
        return np.array(self.points, dtype=float)


@register_wall("polyline")
@dataclass(kw_only=True, config=CONFIG)
class Polyline(Wall):
    """A thin wall along a line of points, drawn 5 cm thick."""

    solid: ClassVar[bool] = False

    # The points, at least two, in meters.
    points: Annotated[Points, Field(min_length=2)]

    def vertices(self) -> Array:
        """Returns the points as given, shape (k, 2)."""
        return np.array(self.points, dtype=float)


@dataclass(kw_only=True, slots=True, config=CONFIG)
class World:
    """Everything that does not move."""

    # Each wall pushes people away from its nearest point, so a room is four
    # walls, not one outline.
    walls: list[Annotated[Wall, WALLS]] = field(default_factory=list)

    def obstacles(self) -> Obstacles:
        """Returns the walls as one set of arrays."""
        return Obstacles.from_shapes(
            [wall.vertices() for wall in self.walls],
            solid=[wall.solid for wall in self.walls],
        )
