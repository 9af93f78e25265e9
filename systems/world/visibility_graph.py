"""Straight ways between points, compiled by numba.

The arguments have the names and units of `walls.py`.
"""

import math

import numba
import numpy as np

from hunav_drake.systems.common.kernels import MATRIX, REAL, WALLS, jit, jit_as
from hunav_drake.systems.world.sweep import (
    crosses,
    distance_to,
    is_free,
    nearest_on_path,
)
from hunav_drake.systems.world.walls import opened, segments_in, segments_near

# Lengths that differ less are the same, in meters.
_SAME = 1e-9

# The part of the clearance of ways for people or goals that are too near to
# walls.
SQUEEZED = 0.25

# The number of segments that are remembered because they hide points.
_HIDERS = 6

# The number of sectors around a point, and the directions of their edges: they
# part the sum of |x| and |y| equally.
_SECTORS = 1024
_TURNS = np.arange(_SECTORS) * 4 / _SECTORS
_EDGES = np.column_stack([abs(_TURNS - 2) - 1, 1 - abs((_TURNS + 1) % 4 - 2)])
_EDGES /= np.hypot(*_EDGES.T)[:, None]

# The distance at which segments around a point are looked for first, in meters.
_AROUND = 8.0

# The squared sine of an angle that is less than a sector.
_NARROW = 0.98 * (4 / _SECTORS) ** 2

# More than rounding, in meters and sectors; and the sine of an angle between a
# line of sight and a segment at which it does not matter.
_SURELY = 1e-6
_STEEP = 1e-2


@jit
def _is_nearer(x, y, px, py, qx, qy, near, segments, r):
    """Returns whether segment `r` is nearer to (x, y): see `_passes`."""
    other = distance_to(x, y, segments, r)
    return other < near - _SAME or (
        other <= near + _SAME
        and min(
            distance_to(px, py, segments, r), distance_to(qx, qy, segments, r)
        )
        <= other + _SAME
    )


@jit
def _passes(px, py, qx, qy, near, where, walls, s):
    """Returns whether a path first nears and then leaves walls at segment `s`.

    It does not where another wall is nearer, or as near and so from an end of
    the path on. Segment `s` is nearest to neither end; `near` and `where` are
    the result of `nearest_on_path` for it.
    """
    x = px + where * (qx - px)
    y = py + where * (qy - py)
    # Of a wall of many segments, mostly the one before or after is nearer.
    for r in (s - 1, s + 1):
        if 0 <= r < len(walls.segments) and _is_nearer(
            *(x, y, px, py, qx, qy, near, walls.segments, r)
        ):
            return False
    for r in segments_near(x, y, x, y, near + _SAME, walls):
        if r != s and _is_nearer(
            *(x, y, px, py, qx, qy, near, walls.segments, r)
        ):
            return False
    return True


@jit
def stops(px, py, qx, qy, clearance, walls, s):
    """Returns whether segment `s` is in the way: see `sees`."""
    segments = walls.segments
    # Both ends on one side of the line, and farther away from it than that.
    dx = qx - px
    dy = qy - py
    a = dx * (segments[s, 1] - py) - dy * (segments[s, 0] - px)
    b = dx * (segments[s, 3] - py) - dy * (segments[s, 2] - px)
    if (a > 0) == (b > 0) and min(a * a, b * b) > clearance * clearance * (
        dx * dx + dy * dy
    ):
        return False
    near, where = nearest_on_path(px, py, qx, qy, segments, s)
    if near >= clearance - _SAME:
        return False
    return where < 0 or (
        near < distance_to(px, py, segments, s) - _SAME
        and near < distance_to(qx, qy, segments, s) - _SAME
        and _passes(px, py, qx, qy, near, where, walls, s)
    )


@jit
def blocker(px, py, qx, qy, clearance, walls):
    """Returns a segment that is in the way from p to q, or -1: see `sees`."""
    for s in segments_near(px, py, qx, qy, clearance, walls):
        if stops(px, py, qx, qy, clearance, walls, s):
            return s
    return -1


@jit
def sees(px, py, qx, qy, clearance, walls):
    """Returns whether the straight way from p to q keeps its clearance.

    It may begin beside walls, and leave them, and end beside walls, and draw
    near to them, but not pass them more closely than the clearance. So a
    point that is seen is seen from the whole way to it.
    """
    return blocker(px, py, qx, qy, clearance, walls) < 0


@jit
def no_hiders():
    """Returns the memory of `sees_past` that knows nothing."""
    return np.full(_HIDERS + 1, -1)


@jit
def sees_past(px, py, qx, qy, clearance, walls, hiders):
    """Returns the result of `sees`, for one of many points seen from p.

    A segment that hid one point often hides the next. Array `hiders` keeps
    segments that hid other points, or -1, and in its last element the index of
    the one that is replaced next.
    """
    for i in range(_HIDERS):
        if hiders[i] >= 0 and crosses(
            px, py, qx, qy, walls.segments, hiders[i]
        ):
            return False
    s = blocker(px, py, qx, qy, clearance, walls)
    if s >= 0:
        hiders[-1] = (hiders[-1] + 1) % _HIDERS
        hiders[hiders[-1]] = s
    return s < 0


@jit_as(numba.boolean[::1], MATRIX, MATRIX, REAL, WALLS)
def blocked(positions, goals, clearance, table):
    """Returns for each person (n,) whether the straight way is not free.

    Rows of positions are x, y, ..., rows of goals x, y, in meters. Nothing
    would be in the way of a body without extent: there must be a clearance.
    """
    if not clearance > _SAME:
        raise ValueError("the clearance of a straight way must be positive")
    walls = opened(table)
    result = np.empty(len(positions), dtype=np.bool_)
    for i in range(len(positions)):
        result[i] = not sees(
            *(positions[i, 0], positions[i, 1], goals[i, 0], goals[i, 1]),
            *(clearance, walls),
        )
    return result


@jit_as(numba.boolean[::1], MATRIX, REAL, WALLS)
def free_points(points, clearance, table):
    """Returns which points (m, 2) have their clearance from every wall."""
    walls = opened(table)
    result = np.empty(len(points), dtype=np.bool_)
    for i in range(len(points)):
        result[i] = is_free(points[i, 0], points[i, 1], clearance, walls)
    return result


@jit
def _sector(dx, dy):
    """Returns in which of the sectors around a point a direction is.

    Its integer part is the sector; it grows with the angle, from 0 along x.
    """
    part = dy / (abs(dx) + abs(dy))
    turn = part if dx >= 0 else 2.0 - part
    return (turn if turn >= 0 else turn + 4.0) * (_SECTORS / 4)


@jit
def _free_distances(px, py, walls):
    """Returns how far (px, py) sees at most in each sector, in meters.

    Where one segment lies across a whole sector, all that is beyond it is
    surely hidden, also by the rounding of `crosses`. Segments that are farther
    than others lie in all sectors are not looked at.
    """
    reach = _AROUND
    while True:
        near = segments_in(
            px - reach, py - reach, px + reach, py + reach, walls
        )
        free = _free_of(px, py, near, walls.segments)
        if len(near) == len(walls.segments) or free.max() <= reach:
            return free
        reach *= 4


@jit
def _free_of(px, py, near, segments):
    """Returns the result of `_free_distances` for some segments."""
    free = np.full(_SECTORS, np.inf)
    for s in near:
        ax = segments[s, 0] - px
        ay = segments[s, 1] - py
        bx = segments[s, 2] - px
        by = segments[s, 3] - py
        cross = ax * by - ay * bx
        a2 = ax * ax + ay * ay
        b2 = bx * bx + by * by
        # Most segments are too short, and too far away, to fill a sector.
        if ax * bx + ay * by > 0 and cross * cross < _NARROW * a2 * b2:
            continue
        ex = bx - ax
        ey = by - ay
        length = math.sqrt(ex * ex + ey * ey)
        if abs(cross) <= _SURELY * length:
            continue
        if cross > 0:
            first = _sector(ax, ay)
            last = _sector(bx, by)
        else:
            first = _sector(bx, by)
            last = _sector(ax, ay)
        if last < first:
            last += _SECTORS
        begin = math.ceil(first + _SURELY)
        before = math.inf
        for k in range(begin, math.floor(last - _SURELY) + 1):
            edge = _EDGES[k % _SECTORS]
            # The sine of the angle at which the edge meets the segment.
            sine = (edge[0] * ey - edge[1] * ex) / length
            far = math.inf
            if abs(sine) > _STEEP:
                far = cross / (sine * length) + _SURELY
            if k > begin:
                behind = (k - 1) % _SECTORS
                free[behind] = min(free[behind], max(before, far))
            before = far
    return free


@jit
def seen_from(v, points, clearance, walls, seen):
    """Writes which of points (m, 2) point `v` sees; returns their number.

    Of two points, it is the one with the larger index that looks at the other:
    so what they see does not depend on which is asked first.
    """
    px = points[v, 0]
    py = points[v, 1]
    free = _free_distances(px, py, walls)
    far = free.max()
    hiders = no_hiders()
    count = 0
    for u in range(len(points)):
        qx = points[u, 0]
        qy = points[u, 1]
        dx = qx - px
        dy = qy - py
        if abs(dx) > far or abs(dy) > far or u == v:
            continue
        away2 = dx * dx + dy * dy
        if away2 > 0:
            limit = free[int(_sector(dx, dy)) % _SECTORS]
            if away2 > limit * limit:
                continue
        if u < v:
            is_seen = sees_past(px, py, qx, qy, clearance, walls, hiders)
        else:
            is_seen = sees_past(qx, qy, px, py, clearance, walls, hiders)
        if is_seen:
            seen[count] = u
            count += 1
    return count
