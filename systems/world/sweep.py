"""How near a straight path comes to walls, compiled by numba.

Walls are the arrays of `Obstacles`: `segments`, `first` and `solid`.
"""

import math

from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.world.nearest import nearest_on_segments

# The offsets that a place near a wall is tried at, the most roomy first.
_OFFSETS = (1.0, 0.25, 0.0625)

# Lengths that differ less are the same, in meters.
_SAME = 1e-9


@jit
def distance_to(x, y, segments, s):
    """Returns the distance of a point from segment `s`, in meters."""
    _, _, d2 = nearest_on_segments(x, y, segments, s, s + 1)
    return math.sqrt(d2)


@jit
def out_of_box(px, py, qx, qy, reach, segments, s):
    """Tells whether a path is farther than `reach` by its bounds alone."""
    x0 = segments[s, 0]
    y0 = segments[s, 1]
    x1 = segments[s, 2]
    y1 = segments[s, 3]
    return (
        min(x0, x1) > max(px, qx) + reach
        or max(x0, x1) < min(px, qx) - reach
        or min(y0, y1) > max(py, qy) + reach
        or max(y0, y1) < min(py, qy) - reach
    )


@jit
def crosses(px, py, qx, qy, segments, s):
    """Tells whether the path from p to q passes through segment `s`.

    Touching is not crossing.
    """
    ax = segments[s, 0]
    ay = segments[s, 1]
    ex = segments[s, 2] - ax
    ey = segments[s, 3] - ay
    dx = qx - px
    dy = qy - py
    a = dx * (ay - py) - dy * (ax - px)
    b = dx * (segments[s, 3] - py) - dy * (segments[s, 2] - px)
    if not ((a < 0 and b > 0) or (a > 0 and b < 0)):
        return False
    p = ex * (py - ay) - ey * (px - ax)
    q = ex * (qy - ay) - ey * (qx - ax)
    return (p < 0 and q > 0) or (p > 0 and q < 0)


@jit
def nearest_on_path(px, py, qx, qy, segments, s):
    """Returns how near the path from p to q comes to segment `s`, and where.

    Returns:
        The least distance, in meters; and the part of the path, in [0, 1],
        after which it is reached, an end of the path if it is so there. It is
        negative for a path that crosses the segment.
    """
    if crosses(px, py, qx, qy, segments, s):
        return 0.0, -1.0
    _, _, best = nearest_on_segments(px, py, segments, s, s + 1)
    where = 0.0
    _, _, d2 = nearest_on_segments(qx, qy, segments, s, s + 1)
    if d2 < best:
        best = d2
        where = 1.0
    dx = qx - px
    dy = qy - py
    length2 = dx * dx + dy * dy
    if length2 > 0:
        for end in range(0, 4, 2):
            rx = segments[s, end] - px
            ry = segments[s, end + 1] - py
            t = min(max((rx * dx + ry * dy) / length2, 0.0), 1.0)
            rx -= t * dx
            ry -= t * dy
            d2 = rx * rx + ry * ry
            if d2 < best:
                best = d2
                where = t
    return math.sqrt(best), where


@jit
def path_distance(px, py, qx, qy, segments, s):
    """Returns how near the path from p to q comes to segment `s`."""
    distance, _ = nearest_on_path(px, py, qx, qy, segments, s)
    return distance


@jit
def straddles(x, y, segments, s):
    """Tells whether a ray from a point along +x meets segment `s`.

    A point is inside a closed outline if it does so an odd number of times.
    """
    y0 = segments[s, 1]
    y1 = segments[s, 3]
    if (y0 > y) == (y1 > y):
        return False
    x0 = segments[s, 0]
    return x < x0 + (y - y0) / (y1 - y0) * (segments[s, 2] - x0)


@jit
def inside_shape(x, y, segments, first, solid, k):
    """Tells whether a point is inside shape `k`; a thin wall has no inside."""
    if not solid[k]:
        return False
    odd = False
    for s in range(first[k], first[k + 1]):
        odd ^= straddles(x, y, segments, s)
    return odd


@jit
def is_free(x, y, distance, segments, first, solid):
    """Tells whether a point is outside all solids, and that far from walls."""
    for k in range(len(solid)):
        _, _, d2 = nearest_on_segments(x, y, segments, first[k], first[k + 1])
        if d2 < distance * distance:
            return False
        if inside_shape(x, y, segments, first, solid, k):
            return False
    return True


@jit
def _leaves_freely(px, py, qx, qy, segments, first, solid):
    """Tells whether a path crosses no shape but those that p is inside."""
    for k in range(len(solid)):
        if inside_shape(px, py, segments, first, solid, k):
            continue
        for s in range(first[k], first[k + 1]):
            if crosses(px, py, qx, qy, segments, s):
                return False
    return True


@jit
def nearest_free(x, y, hx, hy, offset, segments, first, solid):
    """Returns a place near a point inside a solid, or on a wall, that is free.

    Of the nearest points and the ends of all segments, it lies beside the
    nearest that has room: `offset` away from it, or a quarter or a sixteenth
    of that. No other wall lies between the point and its place.

    Args:
        x: The point, in meters.
        y: Likewise.
        hx: A direction that decides between equally near places.
        hy: Likewise.
        offset: The distance from the walls that the place has if it can.
        segments: Shape (s, 4): see `Obstacles`.
        first: Shape (k + 1,): see `Obstacles`.
        solid: Shape (k,): see `Obstacles`.

    Returns:
        The place (x, y) and whether there is one; else the point itself.
    """
    best = math.inf
    best_along = -math.inf
    best_x = x
    best_y = y
    for s in range(len(segments)):
        ex = segments[s, 2] - segments[s, 0]
        ey = segments[s, 3] - segments[s, 1]
        for which in range(3):
            bx, by, _ = nearest_on_segments(x, y, segments, s, s + 1)
            if which > 0:
                bx = segments[s, 2 * which - 2]
                by = segments[s, 2 * which - 1]
            nx = -ey
            ny = ex
            if nx == 0 and ny == 0:
                nx = x - bx
                ny = y - by
            if nx == 0 and ny == 0:
                nx = hx
                ny = hy
            length = math.hypot(nx, ny)
            if length == 0:
                nx = length = 1.0
            away = math.hypot(bx - x, by - y)
            for side in (-1.0, 1.0):
                gx = side * offset * nx / length
                gy = side * offset * ny / length
                along = (bx + gx - x) * hx + (by + gy - y) * hy
                if away > best + _SAME or (
                    away > best - _SAME and along <= best_along
                ):
                    continue
                for fraction in _OFFSETS:
                    qx = bx + fraction * gx
                    qy = by + fraction * gy
                    room = fraction * offset * (1 - _SAME)
                    if is_free(
                        qx, qy, room, segments, first, solid
                    ) and _leaves_freely(x, y, qx, qy, segments, first, solid):
                        best = away
                        best_along = along
                        best_x = qx
                        best_y = qy
                        break
    return best_x, best_y, best < math.inf
