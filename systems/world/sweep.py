"""The distances of straight paths from walls, compiled by numba.

The arguments have the names and units of `walls.py`.
"""

import math

import numpy as np

from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.world.nearest import (
    inside_any,
    inside_shape,
    nearest_on_segments,
)
from hunav_drake.systems.world.walls import distance2_to_box, segments_near

# The offsets at which a place near a wall is tried, the most roomy first.
_OFFSETS = (1.0, 0.25, 0.0625)

# Lengths that differ less are the same, in meters.
_SAME = 1e-9


@jit
def distance_to(x, y, segments, s):
    """Returns the distance of a point from segment `s`, in meters."""
    _, _, d2 = nearest_on_segments(x, y, segments, s, s + 1)
    return math.sqrt(d2)


@jit
def crosses(px, py, qx, qy, segments, s):
    """Returns whether the path from p to q passes through segment `s`.

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
    """Returns the distance of the path from p to q from segment `s`, and where.

    They are in meters, and as the part of the path, in [0, 1], after which it
    is reached, an end of the path if it is reached there; negative for a path
    that crosses the segment.
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
    """Returns the distance of the path from p to q from segment `s`."""
    distance, _ = nearest_on_path(px, py, qx, qy, segments, s)
    return distance


@jit
def is_free(x, y, distance, walls):
    """Returns whether a point is outside solids, and that far from walls."""
    reach = distance + 1e-12 * (abs(x) + abs(y))
    for s in segments_near(x, y, x, y, reach, walls):
        _, _, d2 = nearest_on_segments(x, y, walls.segments, s, s + 1)
        if d2 < distance * distance:
            return False
    return not inside_any(x, y, walls)


@jit
def _leaves_freely(px, py, qx, qy, walls):
    """Returns whether a path crosses no shape but those that p is inside."""
    for s in segments_near(px, py, qx, qy, 0.0, walls):
        if crosses(px, py, qx, qy, walls.segments, s):
            shape = np.searchsorted(walls.first, s, side="right") - 1
            if not inside_shape(px, py, walls, shape):
                return False
    return True


@jit
def nearest_free(x, y, hx, hy, offset, walls):
    """Returns a place near a point inside a solid, or on a wall, that is free.

    Of the nearest points and the ends of all segments, it lies beside the
    nearest that has room: `offset` meters away from it, or a quarter or a
    sixteenth of that. No other wall lies between the point and its place. The
    direction (hx, hy) decides between equally near places. The last result is
    whether there is a place; else it is the point itself.
    """
    best = math.inf
    best_along = -math.inf
    best_x = x
    best_y = y
    segments = walls.segments
    for run in range(len(walls.runs)):
        # (Rounding of the square root is less than the tolerance.)
        box2 = distance2_to_box(x, y, walls.boxes, walls.runs[run, 3])
        if math.sqrt(box2) > best + 2 * _SAME:
            continue
        for s in range(walls.runs[run, 0], walls.runs[run, 1]):
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
                        if is_free(qx, qy, room, walls) and _leaves_freely(
                            x, y, qx, qy, walls
                        ):
                            best = away
                            best_along = along
                            best_x = qx
                            best_y = qy
                            break
    return best_x, best_y, best < math.inf
