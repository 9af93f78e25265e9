"""Cutting a polygon into triangles."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
import shapely


def triangulate(outline: ArrayLike) -> NDArray[np.int64]:
    """Returns triangles that cover a simple polygon.

    Args:
        outline: The corners, shape (k, 2), counter-clockwise.

    Returns:
        Shape (k - 2, 3): indices of corners, counter-clockwise. An outline
        that crosses or repeats itself gives a fan, whose triangles may
        overlap.
    """
    p = np.asarray(outline, dtype=float)
    polygon = shapely.polygons(p)
    if not polygon.is_valid or len(np.unique(p, axis=0)) < len(p):
        i = np.arange(1, len(p) - 1)
        return np.column_stack([np.zeros_like(i), i, i + 1])
    triangles = shapely.constrained_delaunay_triangles(polygon)
    # Of each, the last corner is the first again. All turn to the right.
    index = {tuple(corner): i for i, corner in enumerate(p.tolist())}
    rows = [
        [index[corner] for corner in triangle.exterior.coords[2::-1]]
        for triangle in triangles.geoms
    ]
    return np.array(rows, dtype=np.int64)
