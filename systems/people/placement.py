"""Places on the floor that are free, drawn from areas."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
import shapely

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.people.area import Area
from hunav_drake.systems.world.obstacles import Obstacles

# The numbers of places of an area that are tried, until one is free. (The first
# mostly is, and each place is compared with all bodies.)
_TRIES = (1, 16, 256, 4096)

# The range of the gaps between the first of a group of two and the other one at
# the start, in meters.
_GROUP_REACH = 0.3

# Returns numbers in [0, 1), always the same ones, as many as requested.
Draws = Callable[[int], Array]


class Floor:
    """The floor with the walls, discs and bodies that occupy it."""

    def __init__(
        self, obstacles: Obstacles, taken: ArrayLike, most_bodies: int
    ) -> None:
        """Constructs a Floor without bodies.

        Args:
            obstacles: The walls.
            taken: Discs, shape (k, 3), rows (x, y, radius) in W, in meters.
            most_bodies: The largest number of bodies.
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
        """The number of bodies."""
        return self._num_bodies

    def keep_bodies(self, count: int) -> None:
        """Removes all bodies but the first ones."""
        self._num_bodies = count

    def is_clear_of_walls(self, points: Array, radius: float) -> Mask:
        """Returns which discs around points (k, 2) meet no wall, shape (k,)."""
        result = np.ones(len(points), dtype=bool)
        hits, _ = self._walls.query(
            shapely.points(points), predicate="dwithin", distance=radius
        )
        result[hits] = False
        return result

    def is_free(
        self, points: Array, radius: float, body: float, spacing: float
    ) -> Mask:
        """Returns at which points (k, 2) a person can stand, shape (k,).

        The disc of the radius meets no wall and no disc there, and the gap of
        the body to other bodies is at least the spacing.
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
    """Returns which points have at least a distance from all discs."""
    offsets = points[:, None] - discs[:, :2]
    gaps = np.hypot(offsets[..., 0], offsets[..., 1]) - discs[:, 2]
    result: Mask = (gaps >= distance).all(axis=1)
    return result


class Areas:
    """Several areas, from which points are drawn uniformly."""

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
        # Points have equal weights.
        self._sizes = sizes if sizes.any() else np.ones(len(areas))
        # Whether there is only one point to draw.
        self.is_point = len(areas) == 1 and areas[0].point is not None

    def points(self, draws: Array) -> tuple[Array, Mask]:
        """Returns points (k, 2), and whether each is in an area.

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
        """Returns which points (k, 2) are in one of the areas, shape (k,)."""
        return np.any([_covers(s, points) for s in self._shapes], axis=0)


def _covers(shape: shapely.Geometry, points: Array) -> Mask:
    return np.asarray(shapely.intersects_xy(shape, points))


def choose(draws: ArrayLike, weights: ArrayLike) -> NDArray[np.intp]:
    """Returns the indices that draws in [0, 1) choose by weights."""
    ends = np.cumsum(np.asarray(weights, dtype=float))
    chosen = np.searchsorted(ends / ends[-1], draws, side="right")
    # A sum may be rounded to less than 1.
    last = np.flatnonzero(weights)[-1]
    return np.asarray(np.minimum(chosen, last), dtype=np.intp)


def draw_point(
    areas: Areas, draws: Draws, is_free: Callable[[Array], Mask]
) -> Array | None:
    """Returns the first drawn point that is free, or None.

    `is_free` returns which of some points (k, 2) are free, shape (k,).
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
    """Returns the first drawn points that are free, shape (k, 2).

    They are at most `most`. The other arguments are those of `draw_point`.
    """
    found = np.zeros((0, 2))
    for points in _batches(areas, draws):
        found = np.vstack([found, points[is_free(points)]])[:most]
        if len(found) == most:
            break
    return found


def _batches(areas: Areas, draws: Draws) -> Iterator[Array]:
    """Yields drawn points, each once, few at first."""
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
    """Returns the starts (n, 2) of people of a group near each other, or None.

    The draws are those of the first one's place, and of the places of each
    other one around it. `is_free` returns at which of some points (k, 2) a
    person with a body of some radius can stand, shape (k,); the spacing is the
    least gap between two bodies.
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
    """Returns places around the origin, denser near it, shape (k, 2)."""
    rows = draw(2 * 64).reshape(64, 2)
    distance = nearest + _GROUP_REACH * np.sqrt(size - 1) * rows[:, 0]
    angle = 2 * np.pi * rows[:, 1]
    directions = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.asarray(distance[:, None] * directions)
