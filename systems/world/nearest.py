"""The nearest points of walls, compiled by numba.

Points are (x, y) in W, in meters; `walls` are `Walls`, and `table` is
`Obstacles.table`.
"""

import math

import numba
import numpy as np

from hunav_drake.systems.common.kernels import (
    INTEGER,
    MATRIX,
    REAL,
    WALLS,
    jit,
    jit_as,
)
from hunav_drake.systems.common.late import late_as
from hunav_drake.systems.common.sorting import stable_order
from hunav_drake.systems.world.walls import distance2_to_box, opened, runs_in


@jit
def nearest_on_segments(x, y, segments, lo, hi):
    """Returns the nearest point (x, y) of some segments, and its distance^2.

    They are the rows `lo` to `hi` - 1 of `segments`, shape (s, 4); with none,
    the distance is infinite.
    """
    best = math.inf
    best_x = 0.0
    best_y = 0.0
    for s in range(lo, hi):
        sx = segments[s, 0]
        sy = segments[s, 1]
        ax = segments[s, 2] - sx
        ay = segments[s, 3] - sy
        length2 = ax * ax + ay * ay
        t = 0.0
        if length2 > 0:
            t = ((x - sx) * ax + (y - sy) * ay) / length2
            t = min(max(t, 0.0), 1.0)
        px = sx + t * ax
        py = sy + t * ay
        d2 = (x - px) * (x - px) + (y - py) * (y - py)
        if d2 < best:
            best = d2
            best_x = px
            best_y = py
    return best_x, best_y, best


@jit
def _nearest_in_run(x, y, run, best, row, walls):
    """Writes the nearest point of a run, if it is nearer than the best so far.

    `row` is the best so far, as `shapes_within` gives it, and `best` its
    squared distance; that of the new best is returned. At equal distances, the
    segment with the lower number is taken.
    """
    for s in range(walls.runs[run, 0], walls.runs[run, 1]):
        px, py, d2 = nearest_on_segments(x, y, walls.segments, s, s + 1)
        if d2 < best or (d2 == best and s < row[3]):
            best = d2
            row[0] = px
            row[1] = py
            row[2] = d2
            row[3] = s
    return best


@jit
def shapes_within(x, y, reach, most, walls):
    """Returns the nearest points (n, 4) of the shapes that act on a person.

    They are the shapes within `reach` meters of the person at (x, y), at most
    the nearest `most` of them; 0 is all. Rows are (x, y, squared distance,
    segment), in the order of the shapes, or from near to far if some are left
    out.
    """
    edge = reach * (1 + 1e-12) + 1e-12 * (abs(x) + abs(y))
    runs = runs_in(x - edge, y - edge, x + edge, y + edge, walls)
    found = np.empty((len(runs), 4))
    count = 0
    lower = np.empty(len(runs))
    hi = 0
    while hi < len(runs):
        lo = hi
        shape = walls.runs[runs[lo], 2]
        nearest = lo
        while hi < len(runs) and walls.runs[runs[hi], 2] == shape:
            box = walls.runs[runs[hi], 3]
            lower[hi] = distance2_to_box(x, y, walls.boxes, box)
            if lower[hi] < lower[nearest]:
                nearest = hi
            hi += 1
        if lower[nearest] > edge * edge:
            continue
        # The nearest box first, so that few others are needed.
        best = _nearest_in_run(
            x, y, runs[nearest], math.inf, found[count], walls
        )
        for i in range(lo, hi):
            if i != nearest and lower[i] <= best:
                best = _nearest_in_run(x, y, runs[i], best, found[count], walls)
        if best <= reach * reach:
            count += 1
    found = found[:count]
    if most == 0 or most >= len(walls.solid):
        return found
    away = np.empty(count)
    for i in range(count):
        away[i] = found[i, 2]
    order = stable_order(away)
    nearest_ones = np.empty((min(most, count), 4))
    for i in range(len(nearest_ones)):
        for c in range(4):
            nearest_ones[i, c] = found[order[i], c]
    return nearest_ones


@jit
def nearest_within(x, y, bound, walls):
    """Returns the nearest point (x, y) of all walls, and its distance^2.

    Walls with a squared distance above `bound` do not count. Without any
    others, the distance is infinite.
    """
    best = bound
    best_x = 0.0
    best_y = 0.0
    best_run = len(walls.runs)
    box = 0
    while box < len(walls.boxes):
        if distance2_to_box(x, y, walls.boxes, box) > best:
            box = walls.links[box, 0]
            continue
        run = walls.links[box, 1]
        if run >= 0:
            px, py, d2 = nearest_on_segments(
                x, y, walls.segments, walls.runs[run, 0], walls.runs[run, 1]
            )
            if d2 < best or (d2 == best and run < best_run):
                best = d2
                best_x = px
                best_y = py
                best_run = run
        box += 1
    return best_x, best_y, best if best_run < len(walls.runs) else math.inf


@jit
def straddles(x, y, segments, s):
    """Returns whether a ray from a point along +x meets segment `s`.

    A point is inside a closed outline if it does so an odd number of times.
    """
    y0 = segments[s, 1]
    y1 = segments[s, 3]
    if (y0 > y) == (y1 > y):
        return False
    x0 = segments[s, 0]
    return x < x0 + (y - y0) / (y1 - y0) * (segments[s, 2] - x0)


@jit
def inside_shape(x, y, walls, k):
    """Returns whether a point is inside shape `k`; never of a thin wall."""
    if not walls.solid[k]:
        return False
    odd = False
    for s in range(walls.first[k], walls.first[k + 1]):
        odd ^= straddles(x, y, walls.segments, s)
    return odd


@jit
def inside_any(x, y, walls):
    """Returns whether a point is inside a solid."""
    runs = runs_in(x, y, math.inf, y, walls)
    odd = False
    for i in range(len(runs)):
        run = runs[i]
        shape = walls.runs[run, 2]
        if walls.solid[shape]:
            for s in range(walls.runs[run, 0], walls.runs[run, 1]):
                odd ^= straddles(x, y, walls.segments, s)
        last = i + 1 == len(runs) or walls.runs[runs[i + 1], 2] != shape
        if last and odd:
            return True
    return False


@jit_as(numba.float64[:, :, ::1], MATRIX, WALLS)
def nearest_on_shapes(points, table):
    """Returns the nearest point (m, k, 2) of each shape to points (m, 2)."""
    walls = opened(table)
    shapes = len(walls.solid)
    nearest = np.empty((len(points), shapes, 2))
    for i in range(len(points)):
        for k in range(shapes):
            x, y, _ = nearest_on_segments(
                *(points[i, 0], points[i, 1], walls.segments),
                *(walls.first[k], walls.first[k + 1]),
            )
            nearest[i, k, 0] = x
            nearest[i, k, 1] = y
    return nearest


@late_as(numba.float64[:, ::1], MATRIX, WALLS)
def nearest_on_walls(points, table):
    """Returns the nearest points (m, 2) of all walls to points (m, 2).

    They are NaN without walls.
    """
    walls = opened(table)
    nearest = np.full((len(points), 2), np.nan)
    for i in range(len(points)):
        x, y, d2 = nearest_within(points[i, 0], points[i, 1], math.inf, walls)
        if d2 < math.inf:
            nearest[i, 0] = x
            nearest[i, 1] = y
    return nearest


@jit_as(numba.boolean[:, ::1], MATRIX, WALLS)
def inside_shapes(points, table):
    """Returns which points (m, 2) lie inside each of k shapes, (m, k)."""
    walls = opened(table)
    within = np.empty((len(points), len(walls.solid)), dtype=np.bool_)
    for i in range(len(points)):
        for k in range(len(walls.solid)):
            within[i, k] = inside_shape(points[i, 0], points[i, 1], walls, k)
    return within


@jit_as(numba.float64[:, ::1], REAL, REAL, REAL, INTEGER, INTEGER, WALLS)
def signed_distances(left, bottom, resolution, rows, columns, table):
    """Returns the distances of places on a grid: see `DistanceField`.

    The first place is (left, bottom); neighbors are `resolution` meters apart.
    """
    walls = opened(table)
    result = np.empty((rows, columns))
    for i in range(rows):
        y = bottom + i * resolution
        bound = math.inf
        for j in range(columns):
            x = left + j * resolution
            _, _, d2 = nearest_within(x, y, bound, walls)
            distance = math.sqrt(d2)
            # The next place is nearer than this to the same wall.
            bound = (distance + resolution) ** 2 * (1 + 1e-9)
            result[i, j] = -distance if inside_any(x, y, walls) else distance
    return result
