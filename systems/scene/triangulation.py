"""Cutting a polygon into triangles."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def triangulate(outline: ArrayLike) -> NDArray[np.int64]:
    """Returns triangles that cover a simple polygon, by cutting off its ears.

    An ear is a convex corner whose triangle holds no other corner. Every
    simple polygon has two (Meisters, "Polygons have ears", Am. Math. Monthly
    82, 1975), so one can be cut off until a triangle is left.

    Args:
        outline: The corners, shape (k, 2), counter-clockwise.

    Returns:
        Shape (k - 2, 3): indices of corners, counter-clockwise. An outline
        that crosses itself gives triangles too, but some may overlap.
    """
    p = np.asarray(outline, dtype=float)
    left = list(range(len(p)))
    triangles = []
    at = 0
    while len(left) > 3:
        # From where the last ear was, so that a fan does not form. Only a
        # polygon that is not simple has no ear; any corner will do then.
        turns = range(at, at + len(left))
        at = next((i for i in turns if _is_ear(p, left, i % len(left))), at)
        at %= len(left)
        triangles.append((left[at - 1], left[at], left[(at + 1) % len(left)]))
        del left[at]
    triangles.append((left[0], left[1], left[2]))
    return np.array(triangles, dtype=np.int64)


def _is_ear(p: NDArray[np.float64], left: list[int], i: int) -> bool:
    a, b, c = left[i - 1], left[i], left[(i + 1) % len(left)]
    if _turn(p[a], p[b], p[c]) <= 0:
        return False
    others = p[[k for k in left if k not in (a, b, c)]]
    # Corners that lie on the ear's own corners do not spoil it: outlines with
    # a hole touch themselves there.
    others = others[~(others[:, None] == p[[a, b, c]]).all(axis=-1).any(axis=1)]
    within = (
        (_turn(p[a], p[b], others) >= 0)
        & (_turn(p[b], p[c], others) >= 0)
        & (_turn(p[c], p[a], others) >= 0)
    )
    return not within.any()


def _turn(
    a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Returns twice the signed area of (a, b, c), positive to the left."""
    result: NDArray[np.float64] = (b[0] - a[0]) * (c[..., 1] - a[1]) - (
        b[1] - a[1]
    ) * (c[..., 0] - a[0])
    return result
