"""The places around corners: the vertices of a visibility graph."""

from collections.abc import Iterator
import itertools
import math

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.world import visibility_graph
from hunav_drake.systems.world.obstacles import Obstacles

# Smaller angles are straight on, in radians.
_STRAIGHT = 1e-6


def corner_vertices(
    obstacles: Obstacles, clearance: float, sight: float
) -> Array:
    """Returns places (m, 2) around the convex corners of a world.

    No segment of the walls has length zero. The places are at the clearance
    around corners, and have at least the distance `sight` from all walls.
    """
    corners = [
        corner
        for solid, (lo, hi) in zip(
            obstacles.solid, itertools.pairwise(obstacles.first), strict=True
        )
        for corner in _corners(obstacles.segments[lo:hi], bool(solid))
    ]
    rows = np.array([[*place, *rest] for place, *rest in corners])
    found = [(np.zeros(0, dtype=np.int64), np.zeros((0, 2)))]
    left = np.arange(len(corners))
    # Where there is no room for the points of a wide bend, those of a closer
    # one may still have it.
    for parts in (1, 2, 4):
        which, bends = _bends(rows[left], clearance, parts)
        free = visibility_graph.free_points(bends, sight, obstacles.table)
        found.append((left[which[free]], bends[free]))
        left = left[np.bincount(which[~free], minlength=len(left)) > 0]
    order = np.argsort(
        np.concatenate([which for which, _ in found]), kind="stable"
    )
    vertices = np.vstack([places for _, places in found])[order]
    _, which = np.unique(vertices.round(9), axis=0, return_index=True)
    return vertices[np.sort(which)]


def _corners(
    segments: Array, solid: bool
) -> Iterator[tuple[Array, float, float]]:
    """Yields the convex corners of a shape (s, 4) that people walk around.

    Each (2,) comes with the direction of the normal of the wall before it, and
    the angle by which that turns there, in radians: pi at the end of a thin
    wall.
    """
    if len(segments) == 0:
        return
    if solid and _area(segments) < 0:
        segments = segments[::-1, [2, 3, 0, 1]]
    angles = np.arctan2(
        segments[:, 3] - segments[:, 1], segments[:, 2] - segments[:, 0]
    )
    closed = bool((segments[0, :2] == segments[-1, 2:]).all())
    if not closed:
        yield segments[0, :2], angles[0] + math.pi / 2, math.pi
        yield segments[-1, 2:], angles[-1] - math.pi / 2, math.pi
    for i in range(0 if closed else 1, len(segments)):
        turn = math.remainder(angles[i] - angles[i - 1], 2 * math.pi)
        # The inside of a solid is to the left of its outline.
        if turn > _STRAIGHT or (turn < -_STRAIGHT and not solid):
            side = math.copysign(math.pi / 2, turn)
            yield segments[i, :2], angles[i - 1] - side, turn


def _area(segments: Array) -> float:
    """Returns twice the area of an outline, positive if it turns left."""
    x0, y0, x1, y1 = (segments - np.tile(segments[0, :2], 2)).T
    return float(np.sum(x0 * y1 - x1 * y0))


def _bends(
    corners: Array, clearance: float, parts: int
) -> tuple[NDArray[np.int64], Array]:
    """Returns the points of ways around corners, at the clearance from them.

    They are the corners of polygons around the arcs with that radius, with
    `parts` of them for each quarter turn or less. Rows of corners are x, y,
    normal and turn: see `_corners`.

    Returns:
        The row of the corner of each point (k,), and the points (k, 2).
    """
    corners = corners.reshape(-1, 4)
    turns = corners[:, 3]
    quarters = np.ceil(np.abs(turns) / (math.pi / 2) - _STRAIGHT)
    counts = parts * np.maximum(quarters, 1).astype(np.int64)
    which = np.repeat(np.arange(len(corners)), counts)
    step = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
    x, y, normal, turn = corners[which].T
    angles = normal + turn * (step + 0.5) / counts[which]
    # (NumPy's cosine has other last bits.)
    radii = np.array(
        [
            clearance / math.cos(t / n / 2)
            for t, n in zip(turns.tolist(), counts.tolist(), strict=True)
        ]
    )
    r = radii[which] if len(which) else np.zeros(0)
    points = np.column_stack([x + r * np.cos(angles), y + r * np.sin(angles)])
    return which, points
