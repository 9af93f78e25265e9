"""Straight ways between points, compiled by numba.

The arguments have the names and units of `walls.py`.
"""

import math

import numba
from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import MATRIX, REAL, WALLS, jit, jit_as
from hunav_drake.systems.common.sorting import stable_order
from hunav_drake.systems.world.sweep import (
    crosses,
    distance_to,
    is_free,
    nearest_on_path,
)
from hunav_drake.systems.world.walls import opened, segments_near

# Lengths that differ less are the same, in meters.
_SAME = 1e-9

# The part of the clearance of ways for people or goals that are too near to
# walls.
SQUEEZED = 0.25

# The number of segments that are remembered because they hide points.
_HIDERS = 6


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


@jit_as(float64[:, ::1], MATRIX, REAL, WALLS)
def straight_ways(points, clearance, table):
    """Returns the straight ways between points (m, 2) that see each other.

    They are rows (i, j, length), j < i, in meters.
    """
    walls = opened(table)
    m = len(points)
    found = np.empty((4 * m + 8, 3))
    count = 0
    angles = np.empty(m)
    seen = np.empty(m, dtype=np.bool_)
    for i in range(m):
        px, py = points[i, 0], points[i, 1]
        for j in range(i):
            angles[j] = math.atan2(points[j, 1] - py, points[j, 0] - px)
        hiders = no_hiders()
        # A segment that hides a point mostly hides the next to the left, too.
        for j in stable_order(angles[:i]):
            qx, qy = points[j, 0], points[j, 1]
            seen[j] = sees_past(px, py, qx, qy, clearance, walls, hiders)
        for j in range(i):
            if not seen[j]:
                continue
            qx, qy = points[j, 0], points[j, 1]
            if count == len(found):
                longer = np.empty((2 * count, 3))
                for k in range(count):
                    for c in range(3):
                        longer[k, c] = found[k, c]
                found = longer
            found[count, 0] = i
            found[count, 1] = j
            found[count, 2] = math.hypot(px - qx, py - qy)
            count += 1
    return found[:count].copy()
