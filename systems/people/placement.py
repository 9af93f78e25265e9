"""Places on the floor that are free, drawn from areas."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
import shapely

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.people.area import Area
from hunav_drake.systems.world.obstacles import Obstacles

# How many places of an area are looked at, until one is free.
_TRIES = (16, 256, 4096)

# How far the others of a group start from the first, beyond touching, in
# meters, in a group of two.
_GROUP_REACH = 0.3

# Numbers in [0, 1), always the same ones, as many as asked for.
Draws = Callable[[int], Array]


class Floor:
    """What of the floor is taken: by walls, by discs, and by bodies."""

    def __init__(
        self, obstacles: Obstacles, taken: ArrayLike, most_bodies: int
    ) -> None:
        """Constructs a Floor without bodies.

        Args:
            obstacles: The walls.
            taken: Discs, shape (k, 3), rows (x, y, radius) in W, in meters.
            most_bodies: How many bodies there will be, at most.
        """
        self._walls = shapely.STRtree(_shapes(obstacles))
        self._taken = np.asarray(taken, dtype=float).reshape(-1, 3)
        self._bodies = np.zeros((most_bodies, 3))
        self._num_bodies = 0

    def add_bodies(self, bodies: ArrayLike) -> None:
        """Adds bodies, shape (k, 3), rows (x, y, radius)."""
        rows = np.asarray(bodies, dtype=float).reshape(-1, 3)
        self._bodies[self._num_bodies :][: len(rows)] = rows
        self._num_bodies += len(rows)

    @property
    def num_bodies(self) -> int:
        """How many bodies there are."""
        return self._num_bodies

    def keep_bodies(self, count: int) -> None:
        """Removes all bodies but the first ones."""
        self._num_bodies = count

    def is_clear_of_walls(self, points: Array, radius: float) -> Mask:
        """Tells which discs around points (k, 2) meet no wall, shape (k,)."""
        result = np.ones(len(points), dtype=bool)
        hits, _ = self._walls.query(
            shapely.points(points), predicate="dwithin", distance=radius
        )
        result[hits] = False
        return result

    def is_free(
        self, points: Array, radius: float, body: float, spacing: float
    ) -> Mask:
        """Tells at which points (k, 2) somebody can stand, shape (k,).

        Args:
            points: The centers in W, in meters.
            radius: That of the disc that meets no wall and no disc.
            body: That of the body, which is apart from other bodies.
            spacing: By how much at least.
        """
        bodies = self._bodies[: self._num_bodies]
        return (
            self.is_clear_of_walls(points, radius)
            & _is_apart(points, self._taken, radius)
            & _is_apart(points, bodies, body + spacing)
        )


def _shapes(obstacles: Obstacles) -> list[shapely.Geometry]:
    """Returns obstacles as lines, and as polygons where they are solid."""
    result: list[shapely.Geometry] = []
    for i, solid in enumerate(obstacles.solid):
        rows = obstacles.segments[obstacles.first[i] : obstacles.first[i + 1]]
        if solid:
            result.append(shapely.Polygon(rows[:, :2]))
        else:
            result.append(
                shapely.MultiLineString([row.reshape(2, 2) for row in rows])
            )
    return result


def _is_apart(points: Array, discs: Array, distance: float) -> Mask:
    """Tells which points are as far from all discs, at least."""
    offsets = points[:, None] - discs[:, :2]
    gaps = np.hypot(offsets[..., 0], offsets[..., 1]) - discs[:, 2]
    result: Mask = (gaps >= distance).all(axis=1)
    return result


class Areas:
    """Several areas, from which points are drawn evenly."""

    def __init__(self, areas: Sequence[Area]) -> None:
        """Constructs Areas from at least one area."""
        corners = [area.vertices() for area in areas]
        self._low = np.array([c.min(axis=0) for c in corners])
        self._high = np.array([c.max(axis=0) for c in corners])
        self._shapes = [
            shapely.Polygon(c) if len(c) > 2 else shapely.Point(c[0])
            for c in corners
        ]
        shapely.prepare(self._shapes)
        sizes = np.array([shape.area for shape in self._shapes])
        # Points are as large as each other.
        self._sizes = sizes if sizes.any() else np.ones(len(areas))
        # Whether there is no choice.
        self.is_point = len(areas) == 1 and areas[0].point is not None

    def points(self, draws: Array) -> tuple[Array, Mask]:
        """Returns points (k, 2), and which count: those that are in an area.

        Args:
            draws: Numbers in [0, 1), shape (k, 3).
        """
        which = choose(draws[:, 0], self._sizes)
        low, high = self._low[which], self._high[which]
        points = low + draws[:, 1:] * (high - low)
        inside = np.zeros(len(points), dtype=bool)
        for i in np.unique(which):
            rows = which == i
            inside[rows] = _covers(self._shapes[i], points[rows])
        return points, inside

    def cover(self, points: Array) -> Mask:
        """Tells which points (k, 2) are in one of the areas, shape (k,)."""
        return np.any([_covers(s, points) for s in self._shapes], axis=0)


def _covers(shape: shapely.Geometry, points: Array) -> Mask:
    return np.asarray(shapely.intersects_xy(shape, points))


def choose(draws: ArrayLike, weights: ArrayLike) -> NDArray[np.intp]:
    """Returns the places in a list that draws in [0, 1) choose by weights."""
    ends = np.cumsum(np.asarray(weights, dtype=float))
    chosen = np.searchsorted(ends / ends[-1], draws, side="right")
    # A sum may be rounded to less than 1.
    last = np.flatnonzero(weights)[-1]
    return np.asarray(np.minimum(chosen, last), dtype=np.intp)


def draw_point(
    areas: Areas, draws: Draws, is_free: Callable[[Array], Mask]
) -> Array | None:
    """Returns the first point drawn that is free, or None.

    Args:
        areas: Where it is.
        draws: What it is drawn by.
        is_free: Tells which of some points (k, 2) are, shape (k,).
    """
    for points in _batches(areas, draws):
        free = np.flatnonzero(is_free(points))
        if free.size:
            point: Array = points[free[0]]
            return point
    return None


def draw_points(
    areas: Areas, draws: Draws, is_free: Callable[[Array], Mask], most: int
) -> Array:
    """Returns the first points drawn that are free, shape (k, 2).

    They are `most`, or as many as are found. All else is as for `draw_point`.
    """
    found = np.zeros((0, 2))
    for points in _batches(areas, draws):
        found = np.vstack([found, points[is_free(points)]])[:most]
        if len(found) == most:
            break
    return found


def _batches(areas: Areas, draws: Draws) -> Iterator[Array]:
    """Yields points that are drawn, each once, few at first."""
    done = 0
    for count in _TRIES:
        rows = draws(3 * count).reshape(count, 3)[done:]
        points, inside = areas.points(rows)
        yield points[inside]
        done = count


def draw_group(
    areas: Areas,
    draws: Sequence[Draws],
    bodies: Sequence[float],
    is_free: Callable[[Array, float], Mask],
    spacing: float,
) -> Array | None:
    """Returns where people of a group start, near each other, or None.

    Args:
        areas: Where they are.
        draws: What the first one's place is drawn by, and where the others
            are around the first.
        bodies: The radii of their bodies.
        is_free: Tells at which of some points (k, 2) somebody with a body of
            some radius can stand, shape (k,).
        spacing: The space between two bodies, at least.

    Returns:
        The points, shape (n, 2).
    """
    first, *others = draws
    offsets = [
        _offsets(draw, bodies[0] + body + spacing, len(bodies))
        for draw, body in zip(others, bodies[1:], strict=True)
    ]
    for points in _batches(areas, first):
        for point in points[is_free(points, bodies[0])]:
            placed = np.array([[*point, bodies[0]]])
            for offset, body in zip(offsets, bodies[1:], strict=True):
                places = point + offset
                fits = areas.cover(places) & is_free(places, body)
                fits &= _is_apart(places, placed, body + spacing)
                free = np.flatnonzero(fits)
                if not free.size:
                    break
                placed = np.vstack([placed, [*places[free[0]], body]])
            else:
                return placed[:, :2]
    return None


def _offsets(draw: Draws, nearest: float, size: int) -> Array:
    """Returns places around the origin, near ones more often, shape (k, 2)."""
    rows = draw(2 * 64).reshape(64, 2)
    distance = nearest + _GROUP_REACH * np.sqrt(size - 1) * rows[:, 0]
    angle = 2 * np.pi * rows[:, 1]
    directions = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.asarray(distance[:, None] * directions)
