"""Bodies of the fixed world in three dimensions, and horizontal cuts of them.

Everything in a world consists of a few solids. The obstacles of people, of a
lidar at some height and of views follow from them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike
import shapely

from hunav_drake.systems.common.arrays import Array

# The least number of corners of round outlines, and the radius up to which it
# is enough, in meters: there, corners are 5 mm off the circle.
_SIDES, _ROUND = 16, 0.38

# How far corners of the polygon of a disc may be off it, in meters.
_ROUGH = 0.01

# Lengths that differ by less, in proportion, are equal: see `as_disc`.
_EQUAL = 1e-9


class WorldFileError(ValueError):
    """A file that a world names cannot be read; the text says why."""


class Solid(Protocol):
    """Something with a place and a height."""

    @property
    def closed(self) -> bool:
        """Whether its cuts enclose an inside; those of a thin wall do not."""
        ...

    def cuts(self, height: float) -> Sequence[Array]:
        """Returns the cuts of a horizontal plane with it.

        Args:
            height: The height of the plane over the floor, in meters.

        Returns:
            The outlines, each (k, 2) in W, in meters; empty if there are none.
        """
        ...


@dataclass(frozen=True, eq=False)
class Prism:
    """An upright solid: the same outline at all heights.

    Attributes:
        outline: Shape (k, 2) in W, in meters; the last joins the first if it
            is closed.
        low: The height where it begins, in meters.
        high: The height where it ends, in meters; it is not part of it.
        material: Its material, which gives it its color.
        closed: Whether the outline encloses an inside.
    """

    outline: Array
    low: float
    high: float
    material: str = "wall"
    closed: bool = True

    def cuts(self, height: float) -> list[Array]:
        """Returns the outline if the height is in [low, high)."""
        return [self.outline] if self.low <= height < self.high else []


@dataclass(frozen=True)
class Lettering:
    """Text on an upright surface; nothing bumps into it.

    Attributes:
        text: Its lines.
        pose: Where its middle is, and where it faces: (x, y, yaw) in W, in
            meters and radians.
        middle: The height of its middle, in meters.
        size: The largest width and height of the text, in meters.
        material: Its material, which gives it its color.
    """

    text: str
    pose: tuple[float, float, float]
    middle: float
    size: tuple[float, float]
    material: str = "white"
    closed: bool = False

    def cuts(self, height: float) -> list[Array]:
        """Returns no outlines."""
        return []


@dataclass(frozen=True, eq=False)
class Hull:
    """The convex hull of points (k, 3) in W, in meters."""

    points: Array
    closed: bool = True

    def cuts(self, height: float) -> list[Array]:
        """Returns the convex polygon that a plane cuts out of it, if any."""
        outline = self.slice(height, height)
        return [] if outline is None else [outline]

    def slice(self, low: float, high: float) -> Array | None:
        """Returns the outline of the part between two heights, from above.

        It is None if there is no such part, or if it has no area.
        """
        p = self.points
        z = p[:, 2]
        found = [p[(low <= z) & (z <= high), :2]]
        for plane in {low, high}:
            below, above = p[z < plane], p[z > plane]
            # The hull meets a plane within the hull of the points where lines
            # between points of both sides meet it.
            a, b = below[:, None], above[None]
            part = (plane - a[..., 2]) / (b[..., 2] - a[..., 2])
            crossing = a[..., :2] + part[..., None] * (b - a)[..., :2]
            found.append(crossing.reshape(-1, 2))
        hull = shapely.convex_hull(shapely.multipoints(np.vstack(found)))
        # (Without corners that rounding makes.)
        hull = shapely.simplify(hull, 1e-9)
        if hull.geom_type != "Polygon":
            return None
        outline: Array = shapely.get_coordinates(hull.exterior)[:-1]
        # Counter-clockwise, as the outlines of all solids are.
        return outline if hull.exterior.is_ccw else outline[::-1]


class Fixture(NamedTuple):
    """A thing in the world.

    Attributes:
        place: Its place in the configuration of the world, as ("walls", 3).
        footprints: The outlines that people and robots walk around, each
            (k, 2) in W, in meters.
        closed: Whether the footprints enclose an inside.
        solids: Its solids.
    """

    place: tuple[str | int, ...]
    footprints: Sequence[Array]
    closed: bool
    solids: Sequence[Solid]


def rectangle(x0: float, y0: float, x1: float, y1: float) -> Array:
    """Returns the corners (4, 2) of a rectangle, counter-clockwise."""
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], dtype=float)


def disc(x: float, y: float, radius: float, sides: int = _SIDES) -> Array:
    """Returns a regular polygon (sides, 2) with the area of a disc."""
    angles = (np.arange(sides) + 0.5) * (2 * np.pi / sides)
    step = 2 * np.pi / sides
    outer = radius * np.sqrt(step / np.sin(step))
    result: Array = np.array([x, y]) + outer * np.column_stack(
        [np.cos(angles), np.sin(angles)]
    )
    return result


def fine_disc(x: float, y: float, radius: float) -> Array:
    """Returns a regular polygon with the area of a disc, within 5 mm of it.

    Its shape is (k, 2), in meters; k is a multiple of 4, and at least 16.
    """
    sides = _SIDES * np.sqrt(max(radius / _ROUND, 1.0))
    return disc(x, y, radius, 4 * int(np.ceil(sides / 4)))


def as_disc(outline: Array) -> tuple[float, float, float] | None:
    """Returns the disc (x, y, radius) of which an outline is a polygon.

    The outline, (k, 2), is one of `disc`, moved and turned; of others, the
    result is None. Lengths are in meters.
    """
    sides = len(outline)
    if sides < _SIDES:
        return None
    center = outline.mean(axis=0)
    away = outline - center
    outer = np.hypot(*away.T)
    steps = np.hypot(*(away - np.roll(away, 1, axis=0)).T)
    least = _EQUAL * (np.abs(outline).max() + outer.max())
    if max(np.ptp(outer), np.ptp(steps)) > least or outer.min() < 1e-3:
        return None
    step = 2 * np.pi / sides
    radius = float(outer.mean() / np.sqrt(step / np.sin(step)))
    # (A large building with equal sides is no disc.)
    if outer.mean() - radius > _ROUGH:
        return None
    return float(center[0]), float(center[1]), radius


def turned(points: ArrayLike, pose: tuple[float, float, float]) -> Array:
    """Returns points (k, 2) of a frame with the pose (x, y, yaw), in W."""
    x, y = np.asarray(points, dtype=float).T
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.column_stack(
        [pose[0] + (x * c - y * s), pose[1] + (x * s + y * c)]
    )
