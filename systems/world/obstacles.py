"""Walls as arrays: what crowd, planners and metrics compute with."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Obstacles:
    """Shapes made of segments, and points as segments of no length.

    The arrays cannot be written to.

    Attributes:
        segments: Shape (s, 4), rows (x0, y0, x1, y1) in W, in meters. The
            segments of one shape follow each other.
        first: Shape (k + 1,): shape i has the segments
            ``first[i]:first[i + 1]``.
        solid: Shape (k,): whether the segments of a shape close around a
            solid inside.
    """

    segments: NDArray[np.float64]
    first: NDArray[np.int64]
    solid: NDArray[np.bool_]

    def __post_init__(self) -> None:
        # All systems of a diagram, and models that are not ours, share them.
        for field in fields(self):
            view = getattr(self, field.name).view()
            view.setflags(write=False)
            object.__setattr__(self, field.name, view)

    @classmethod
    def from_shapes(
        cls, shapes: Sequence[ArrayLike], *, solid: Sequence[bool]
    ) -> Self:
        """Makes obstacles from the vertices of each shape, each (k, 2)."""
        rows = []
        first = [0]
        for vertices, closed in zip(shapes, solid, strict=True):
            p = np.asarray(vertices, dtype=float).reshape(-1, 2)
            q = np.roll(p, -1, axis=0) if closed or len(p) == 1 else p[1:]
            rows.append(np.hstack([p[: len(q)], q]))
            first.append(first[-1] + len(q))
        return cls(
            segments=np.vstack(rows) if rows else np.zeros((0, 4)),
            first=np.array(first, dtype=np.int64),
            solid=np.array(solid, dtype=np.bool_),
        )

    @classmethod
    def from_points(cls, points: ArrayLike) -> Self:
        """Makes every point of an array (k, 2) an obstacle of its own."""
        p = np.asarray(points, dtype=float).reshape(-1, 1, 2)
        return cls.from_shapes(list(p), solid=[False] * len(p))

    def __len__(self) -> int:
        return len(self.solid)


def nearest_points(
    obstacles: Obstacles, points: ArrayLike
) -> NDArray[np.float64]:
    """Returns the nearest point of each shape to each of some points.

    Args:
        obstacles: k shapes.
        points: Shape (..., 2), in meters.

    Returns:
        Shape (..., k, 2), in meters. The outline counts, also from inside.
    """
    # Here, for a scenario can be read without loading numba.
    from hunav_drake.systems.world.nearest import nearest_on_shapes

    p = np.ascontiguousarray(points, dtype=float)
    nearest: NDArray[np.float64] = nearest_on_shapes(
        p.reshape(-1, 2), obstacles.segments, obstacles.first
    )
    return nearest.reshape(*p.shape[:-1], len(obstacles), 2)


def inside(obstacles: Obstacles, points: ArrayLike) -> NDArray[np.bool_]:
    """Tells which points lie inside each solid shape.

    Args:
        obstacles: k shapes.
        points: Shape (..., 2), in meters.

    Returns:
        Shape (..., k). Even-odd rule; a thin wall has no inside.
    """
    p = np.asarray(points, dtype=float)
    result = np.zeros((*p.shape[:-1], len(obstacles)), dtype=np.bool_)
    for i in np.flatnonzero(obstacles.solid):
        s = obstacles.segments[obstacles.first[i] : obstacles.first[i + 1]]
        x, y = p[..., None, 0], p[..., None, 1]
        straddles = (s[:, 1] > y) != (s[:, 3] > y)
        dy = np.where(s[:, 3] == s[:, 1], 1.0, s[:, 3] - s[:, 1])
        crossing = s[:, 0] + (y - s[:, 1]) / dy * (s[:, 2] - s[:, 0])
        result[..., i] = np.sum(straddles & (x < crossing), axis=-1) % 2 == 1
    return result
