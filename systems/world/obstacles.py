"""Walls as arrays, for crowd, planners and metrics."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache
import hashlib
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.components import connected_components
from hunav_drake.systems.world.wall_table import wall_table

if TYPE_CHECKING:
    from hunav_drake.systems.world.distance_field import DistanceField

# Directions that differ by less are the same, in radians.
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class Obstacles:
    """Shapes made of segments, and points as segments of no length.

    The arrays cannot be written to. Obstacles with the same content are equal.

    Attributes:
        segments: Shape (s, 4), rows (x0, y0, x1, y1) in W, in meters. The
            segments of one shape follow each other.
        first: Shape (k + 1,): shape i has the segments
            ``first[i]:first[i + 1]``.
        solid: Shape (k,): whether the segments of a shape close around a
            solid inside.
    """

    segments: Array
    first: NDArray[np.int64]
    solid: Mask

    def __post_init__(self) -> None:
        # All systems of a diagram, and users' models, share them.
        for field in fields(self):
            view = getattr(self, field.name).view()
            view.setflags(write=False)
            object.__setattr__(self, field.name, view)

    @classmethod
    def from_shapes(
        cls, shapes: Sequence[ArrayLike], *, solid: Sequence[bool]
    ) -> Self:
        """Makes obstacles from the vertices of each shape, each (k, 2)."""
        rings = [
            np.asarray(vertices, dtype=float).reshape(-1, 2)
            for vertices in shapes
        ]
        counts = np.array([len(ring) for ring in rings], dtype=np.int64)
        closed = np.array(solid, dtype=np.bool_) | (counts == 1)
        ends = np.cumsum(counts)
        p = np.vstack(rings) if rings else np.zeros((0, 2))
        following = np.arange(1, len(p) + 1)
        last = ends[counts > 0] - 1
        following[last] = (ends - counts)[counts > 0]
        kept = np.ones(len(p), dtype=np.bool_)
        kept[last] = closed[counts > 0]
        sides = np.where(closed, counts, np.maximum(counts - 1, 0))
        return cls(
            segments=np.hstack([p, p[following]])[kept],
            first=np.concatenate([[0], np.cumsum(sides)]),
            solid=np.array(solid, dtype=np.bool_),
        )

    @classmethod
    def from_points(cls, points: ArrayLike) -> Self:
        """Makes every point of an array (k, 2) an obstacle of its own."""
        p = np.asarray(points, dtype=float).reshape(-1, 1, 2)
        return cls.from_shapes(list(p), solid=[False] * len(p))

    def __len__(self) -> int:
        return len(self.solid)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Obstacles):
            return NotImplemented
        return self is other or self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def __reduce__(self) -> tuple[Any, ...]:
        # Data derived from the arrays are not sent to other processes.
        return type(self), (self.segments, self.first, self.solid)

    @cached_property
    def table(self) -> Array:
        """The walls, and an index of them, for compiled code: `wall_table`."""
        return wall_table(self.segments, self.first, self.solid)

    @cached_property
    def joined(self) -> Self:
        """The outlines, with a shape for each straight wall; none is solid.

        Walls that share an end and lie on one line are one: so the result does
        not depend on how many pieces, or shapes, a wall has.
        """
        ends = self.segments.reshape(-1, 2)
        along = self.segments[:, 2:] - self.segments[:, :2]
        angle = np.arctan2(along[:, 1], along[:, 0])
        line = np.rint(angle % np.pi / _SAME) % np.rint(np.pi / _SAME)
        line[~along.any(axis=1)] = -1  # A point is on no line.
        rows = np.column_stack([ends.round(9), np.repeat(line, 2)])
        _, place = np.unique(rows, axis=0, return_inverse=True)
        n = len(self.segments)
        meets = np.repeat(np.arange(n), 2), n + place.ravel()
        wall = connected_components(3 * n, meets)
        _, first_of, wall = np.unique(
            wall[:n], return_index=True, return_inverse=True
        )
        wall = np.repeat(wall, 2)
        ahead = (ends * along[first_of[wall]]).sum(axis=1)
        order = np.lexsort((ahead, wall))
        last = np.searchsorted(wall[order], np.arange(len(first_of)), "right")
        first = np.append(0, last)[:-1]
        return type(self)(
            segments=np.hstack([ends[order[first]], ends[order[last - 1]]]),
            first=np.arange(len(last) + 1),
            solid=np.zeros(len(last), dtype=np.bool_),
        )

    @cached_property
    def digest(self) -> str:
        """A hash of the content, the same in every process."""
        content = hashlib.sha256()
        for field in fields(self):
            array = np.ascontiguousarray(getattr(self, field.name))
            content.update(f"{array.shape}{array.dtype.str}".encode())
            content.update(array.tobytes())
        return content.hexdigest()

    def distance_field(
        self, resolution: float, bounds: tuple[float, float, float, float]
    ) -> "DistanceField":
        """Returns the distances to the nearest wall on a grid, computed once.

        Args:
            resolution: The distance between two places, in meters.
            bounds: The least x and y and the largest x and y that the grid
                covers, in W, in meters. It begins at the first two.

        Raises:
            ValueError: If the resolution is not positive, the bounds are not
                in order, or the grid has more than 25 million places.
        """
        return _distance_field(self, resolution, tuple(bounds))


@lru_cache(maxsize=8)
def _distance_field(
    obstacles: Obstacles,
    resolution: float,
    bounds: tuple[float, float, float, float],
) -> "DistanceField":
    """Returns a distance field; the last ones are cached."""
    # Imported here, so that a scenario can be read without loading numba.
    from hunav_drake.systems.world.distance_field import distance_field

    return distance_field(obstacles.table, resolution, bounds)


def nearest_points(obstacles: Obstacles, points: ArrayLike) -> Array:
    """Returns the nearest points of k shapes, (..., k, 2), to points (..., 2).

    All are in W, in meters. The outline counts, also from inside.
    """
    # Imported here, so that a scenario can be read without loading numba.
    from hunav_drake.systems.world.nearest import nearest_on_shapes

    p = np.ascontiguousarray(points, dtype=float)
    nearest = nearest_on_shapes(p.reshape(-1, 2), obstacles.table)
    return np.reshape(nearest, (*p.shape[:-1], len(obstacles), 2))


def nearest_wall(obstacles: Obstacles, points: ArrayLike) -> Array:
    """Returns the nearest points of all walls, (..., 2), to points (..., 2).

    All are in W, in meters; NaN if there are no walls. The outline counts,
    also from inside.
    """
    from hunav_drake.systems.world.nearest import nearest_on_walls

    p = np.ascontiguousarray(points, dtype=float)
    nearest: Array = nearest_on_walls(p.reshape(-1, 2), obstacles.table)
    return nearest.reshape(p.shape)


def inside(obstacles: Obstacles, points: ArrayLike) -> Mask:
    """Returns which points (..., 2) lie inside which of k shapes: (..., k).

    Even-odd rule; a thin wall has no inside. Points are in W, in meters.
    """
    from hunav_drake.systems.world.nearest import inside_shapes

    p = np.ascontiguousarray(points, dtype=float)
    within: Mask = inside_shapes(p.reshape(-1, 2), obstacles.table)
    return within.reshape(*p.shape[:-1], len(obstacles))
