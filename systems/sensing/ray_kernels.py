"""Ray casting in a horizontal plane, compiled by numba."""

import math

from numba import boolean
import numpy as np

from hunav_drake.systems.common.kernels import (
    INTEGER,
    MATRIX,
    REAL,
    VECTOR,
    WALLS,
    jit,
    jit_as,
)
from hunav_drake.systems.common.layout import RADIUS, STATE_SIZE, X, Y
from hunav_drake.systems.world.ray_cast import first_hit
from hunav_drake.systems.world.walls import distance2_to_box, opened


@jit
def _ray_span(turn, half, fan):
    """Returns the indices (first, end) of rays within `half` of a turn.

    Both are in radians; the turn is relative to the first ray. `fan` is the
    step from ray to ray, in radians, and the number of steps of a full turn,
    rounded up: indices of rays are modulo that.
    """
    step, full_turn = fan
    turn -= 2 * math.pi * math.floor(turn / (2 * math.pi))
    # One more at each end: a full turn may not be a whole number of steps, and
    # numbers are rounded.
    first = math.floor((turn - half) / step) - 1
    end = math.floor((turn + half) / step) + 3
    return first, min(end, first + full_turn)


@jit
def _to_ellipse(px, py, ux, uy, a, b):
    """Returns the distance along a ray to an ellipse around the origin.

    The ray begins at (px, py) with the unit direction (ux, uy), in the axes of
    the ellipse with semi-axes a and b. 0 from inside, infinity for a miss.
    """
    # Scale the ellipse to a circle of radius a.
    py *= a / b
    uy *= a / b
    inside = px * px + py * py - a * a
    if inside <= 0.0:
        return 0.0
    aside = ux * py - uy * px
    ahead = -(ux * px + uy * py)
    left = a * a * (ux * ux + uy * uy) - aside * aside
    if left < 0.0 or ahead <= 0.0:
        return math.inf
    # The difference ahead - sqrt(left) would lose digits.
    return inside / (ahead + math.sqrt(left))


@jit
def _scan_ellipse(x, y, start, fan, directions, ellipse, distances):
    """Shortens distances at an ellipse: see `ray_distances`."""
    a, b = ellipse[3], ellipse[4]
    if min(a, b) <= 0.0:
        return
    dx, dy = x - ellipse[0], y - ellipse[1]
    away = math.hypot(dx, dy)
    radius = max(a, b)
    half = math.asin(radius / away) if away > radius else math.pi
    first, end = _ray_span(math.atan2(-dy, -dx) - start, half, fan)
    c, s = math.cos(ellipse[2]), math.sin(ellipse[2])
    px, py = c * dx + s * dy, c * dy - s * dx
    for k in range(first, end):
        i = k % fan[1]
        if i < len(distances):
            ux, uy = directions[i, 0], directions[i, 1]
            found = _to_ellipse(px, py, c * ux + s * uy, c * uy - s * ux, a, b)
            distances[i] = min(distances[i], found)


@jit
def _scan_segment(ax, ay, bx, by, turns, fan, directions, distances):
    """Shortens distances at a segment a to b, relative to the rays' start.

    `turns` are the directions of its ends, in radians from the first ray.
    """
    span = turns[1] - turns[0]
    span -= 2 * math.pi * math.floor(span / (2 * math.pi) + 0.5)
    if abs(span) > math.pi - 1e-3:
        # So near that its side is uncertain because of rounding.
        first, end = 0, len(distances)
    else:
        middle = turns[0] + 0.5 * span
        first, end = _ray_span(middle, 0.5 * abs(span), fan)
    for k in range(first, end):
        i = k % fan[1]
        if i >= len(distances):
            continue
        ux, uy = directions[i, 0], directions[i, 1]
        # The sides of the ends, computed as in `ray_cast`, so that no ray
        # passes through the joint of two segments.
        a = ux * ay - uy * ax
        b = ux * by - uy * bx
        if (a >= 0) == (b >= 0):
            continue
        part = a / (a - b)
        along = ux * (ax + part * (bx - ax)) + uy * (ay + part * (by - ay))
        if 0.0 <= along < distances[i]:
            distances[i] = along


@jit_as(VECTOR, REAL, REAL, REAL, VECTOR, INTEGER, REAL, MATRIX, WALLS)
def ray_distances(x, y, yaw, rays, count, range_max, ellipses, table):
    """Returns the distances along rays from a point to the first hits.

    `rays` are the angle of the first of `count` rays, relative to `yaw`, and
    the positive step to the next one; together less than a turn. They meet
    walls and `ellipses`, shape (k, 5): rows (x, y, yaw of the first axis, both
    semi-axes) in W; ellipses without extent are ignored. A wall segment or an
    ellipse is tested only against rays that point at it. The distances are
    infinite without a hit up to `range_max`. In meters and radians.
    """
    walls = opened(table)
    start = yaw + rays[0]
    step = rays[1]
    fan = (step, max(math.ceil(2 * math.pi / step - 1e-9), count))
    distances = np.full(count, math.inf)
    directions = np.empty((count, 2))
    for i in range(count):
        directions[i, 0] = math.cos(start + i * step)
        directions[i, 1] = math.sin(start + i * step)
    for k in range(len(ellipses)):
        _scan_ellipse(x, y, start, fan, directions, ellipses[k], distances)
    turns = np.empty(2)
    box = 0
    while box < len(walls.boxes):
        if distance2_to_box(x, y, walls.boxes, box) > range_max * range_max:
            box = walls.links[box, 0]
            continue
        run = walls.links[box, 1]
        box += 1
        if run < 0:
            continue
        bx = by = math.nan
        for s in range(walls.runs[run, 0], walls.runs[run, 1]):
            ax, ay = walls.segments[s, 0] - x, walls.segments[s, 1] - y
            # Most segments begin at the end of the previous one.
            if ax == bx and ay == by:
                turns[0] = turns[1]
            else:
                turns[0] = math.atan2(ay, ax) - start
            bx, by = walls.segments[s, 2] - x, walls.segments[s, 3] - y
            turns[1] = math.atan2(by, bx) - start
            _scan_segment(ax, ay, bx, by, turns, fan, directions, distances)
    for i in range(count):
        if distances[i] > range_max:
            distances[i] = math.inf
    return distances


@jit
def _meets_other(px, py, qx, qy, human_states, person):
    """Returns whether another person than `person` is on a line, p to q."""
    dx, dy = qx - px, qy - py
    length2 = dx * dx + dy * dy
    for k in range(human_states.size // STATE_SIZE):
        if k == person:
            continue
        row = k * STATE_SIZE
        ox, oy = human_states[row + X] - px, human_states[row + Y] - py
        along = (ox * dx + oy * dy) / length2 if length2 > 0.0 else 0.0
        along = min(max(along, 0.0), 1.0)
        away = math.hypot(ox - along * dx, oy - along * dy)
        if away < human_states[row + RADIUS]:
            return True
    return False


@jit_as(boolean[::1], REAL, REAL, REAL, REAL, REAL, boolean, VECTOR, WALLS)
def people_in_view(
    x, y, yaw, sight_range, field_of_view, others_hide, human_states, table
):
    """Returns which people are in view from a point (x, y), shape (n,).

    A person is in view if the center is in range and in the field of view
    around `yaw`, and at least one of three lines is free: to the center, and to
    the points half a radius to its left and right. `others_hide` is whether
    people occlude people behind them; `human_states` has shape (7n,). In meters
    and radians.
    """
    walls = opened(table)
    n = human_states.size // STATE_SIZE
    c, s = math.cos(yaw), math.sin(yaw)
    result = np.zeros(n, dtype=np.bool_)
    for i in range(n):
        row = i * STATE_SIZE
        dx, dy = human_states[row + X] - x, human_states[row + Y] - y
        distance = math.hypot(dx, dy)
        if distance > sight_range:
            continue
        if distance > 0.0:
            bearing = math.atan2(c * dy - s * dx, c * dx + s * dy)
            if abs(bearing) > 0.5 * field_of_view:
                continue
        # Half a radius perpendicular to the line.
        half = 0.5 * human_states[row + RADIUS]
        across = half / distance if distance > 0.0 else 0.0
        for side in range(3):
            shift = across * (0.0 if side == 0 else 2.0 * side - 3.0)
            qx = x + dx - shift * dy
            qy = y + dy + shift * dx
            if first_hit(x, y, qx, qy, walls) <= 1.0:
                continue
            if others_hide and _meets_other(x, y, qx, qy, human_states, i):
                continue
            result[i] = True
            break
    return result
