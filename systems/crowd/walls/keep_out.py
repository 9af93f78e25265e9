"""Keeps people out of walls, compiled by numba.

Forces push people away from walls, but a step is finite: a crowd can push
people through one, and a long step can jump over it. Here the path of a step
is followed continuously until it meets a wall, and goes on along the wall.
"""

import math

from numba import boolean, float64
from numba.types import UniTuple
import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import MATRIX, REAL, VECTOR, WALLS, jit
from hunav_drake.systems.common.late import late_as
from hunav_drake.systems.common.layout import VX, VY, X, Y
from hunav_drake.systems.world.nearest import inside_any, nearest_on_segments
from hunav_drake.systems.world.route_clearance import LARGEST_CLEARANCE
from hunav_drake.systems.world.sweep import (
    distance_to,
    nearest_free,
    path_distance,
)
from hunav_drake.systems.world.walls import opened, out_of_box, segments_in

# The depth to which bodies may reach into walls, in meters: they lean on them.
LEANING = 0.01

# The least margin of a body, however small it is, in meters.
LEAST_MARGIN = 0.01

# A center nearer to a wall than this stands on it, in meters.
_SKIN = 1e-6

# The largest number of parts of a step with different directions.
_LEGS = 6

# Rounding of directions.
_TILT = 1e-12


def wall_margins(bodies: ArrayLike) -> Array:
    """Returns the distances (n,) that centers of bodies keep from walls.

    They are the radii minus 1 cm, in meters. Radii above 0.3 m, with which
    there are ways through doors of 0.7 m, count as 0.3 m: larger people turn
    sideways.
    """
    sizes = np.minimum(np.asarray(bodies, dtype=float), LARGEST_CLEARANCE)
    margins: Array = np.maximum(sizes - LEANING, LEAST_MARGIN)
    return margins


@jit
def _contact(x, y, dx, dy, keep, segments, s):
    """Returns the part of a displacement, coming nearer, up to `keep` from `s`.

    All points at that distance from the segment are two straight sides, and a
    half circle around each end.
    """
    best = math.inf
    ax = segments[s, 2] - segments[s, 0]
    ay = segments[s, 3] - segments[s, 1]
    length = math.sqrt(ax * ax + ay * ay)
    if length > 0:
        ax /= length
        ay /= length
        rx = x - segments[s, 0]
        ry = y - segments[s, 1]
        height = ax * ry - ay * rx
        climb = ax * dy - ay * dx
        if height * climb < 0:
            t = max(abs(height) - keep, 0.0) / abs(climb)
            foot = ax * (rx + t * dx) + ay * (ry + t * dy)
            if 0 <= foot <= length:
                best = t
    a = dx * dx + dy * dy
    for end in range(0, 4, 2):
        rx = x - segments[s, end]
        ry = y - segments[s, end + 1]
        b = rx * dx + ry * dy
        if b < 0:
            c = rx * rx + ry * ry - keep * keep
            if c <= 0:
                return 0.0
            root = b * b - a * c
            if root >= 0:
                best = min(best, c / (math.sqrt(root) - b))
    # Only rounding leaves no solution, for a person who touches already.
    return best if best < math.inf else 0.0


@jit
def _allowed(x, y, normals, m):
    """Returns the vector nearest to (x, y) that enters none of m walls."""
    slack = _TILT * math.sqrt(x * x + y * y)
    best_x = 0.0
    best_y = 0.0
    best = -1.0
    for i in range(-1, m):
        cx = x
        cy = y
        if i >= 0:
            into = x * normals[i, 0] + y * normals[i, 1]
            if into >= 0:
                continue
            cx -= into * normals[i, 0]
            cy -= into * normals[i, 1]
        enters = False
        for j in range(m):
            if cx * normals[j, 0] + cy * normals[j, 1] < -slack:
                enters = True
        if not enters and cx * cx + cy * cy > best:
            best = cx * cx + cy * cy
            best_x = cx
            best_y = cy
    return best_x, best_y


@jit
def _slide(x, y, dx, dy, vx, vy, margin, tolerance, walls):
    """Returns position and velocity after a displacement along walls."""
    reach = math.sqrt(dx * dx + dy * dy) + margin
    segments = walls.segments
    near = segments_in(x - reach, y - reach, x + reach, y + reach, walls)
    keep = np.empty(len(near))
    m = 0
    for s in near:
        if not out_of_box(x, y, x, y, reach, segments, s):
            near[m] = s
            # A person who is nearer already comes no nearer.
            keep[m] = min(margin, distance_to(x, y, segments, s))
            m += 1
    normals = np.empty((m, 2))
    start_x = x
    start_y = y
    for leg in range(_LEGS):
        t = 1.0
        stopped = False
        for j in range(m):
            s = near[j]
            if (
                path_distance(x, y, x + dx, y + dy, segments, s)
                < keep[j] - tolerance
            ):
                stopped = True
                t = min(t, _contact(x, y, dx, dy, keep[j], segments, s))
        to_x = x + t * dx
        to_y = y + t * dy
        if leg > 0:
            # A wall may lie between the start and where the legs lead to.
            for j in range(m):
                if (
                    path_distance(
                        start_x, start_y, to_x, to_y, segments, near[j]
                    )
                    < keep[j] - 4 * tolerance
                ):
                    return x, y, vx, vy
        x = to_x
        y = to_y
        if not stopped:
            break
        touched = 0
        for j in range(m):
            nx, ny, d2 = nearest_on_segments(
                x, y, segments, near[j], near[j] + 1
            )
            distance = math.sqrt(d2)
            if distance <= keep[j] + 1e3 * tolerance:
                normals[touched, 0] = (x - nx) / distance
                normals[touched, 1] = (y - ny) / distance
                touched += 1
        dx, dy = _allowed((1 - t) * dx, (1 - t) * dy, normals, touched)
        vx, vy = _allowed(vx, vy, normals, touched)
        if dx == 0 and dy == 0:
            break
    return x, y, vx, vy


@jit
def _touches(x, y, to_x, to_y, margin, tolerance, walls):
    """Returns whether one stands on a wall, and whether a step meets one."""
    segments = walls.segments
    stands = False
    meets = False
    box = 0
    while box < len(walls.boxes):
        if out_of_box(x, y, to_x, to_y, margin, walls.boxes, box):
            box = walls.links[box, 0]
            continue
        run = walls.links[box, 1]
        box += 1
        if run < 0:
            continue
        for s in range(walls.runs[run, 0], walls.runs[run, 1]):
            if out_of_box(x, y, to_x, to_y, margin, segments, s):
                continue
            distance = distance_to(x, y, segments, s)
            if distance < _SKIN:
                stands = True
            elif (
                path_distance(x, y, to_x, to_y, segments, s)
                < min(margin, distance) - tolerance
            ):
                meets = True
    return stands, meets


@late_as(UniTuple(float64, 4), *(REAL,) * 8, boolean, WALLS)
def _kept_out(x, y, dx, dy, vx, vy, margin, tolerance, stands, table):
    """Returns position and velocity of one who stands in or meets a wall."""
    walls = opened(table)
    if stands:
        free_x, free_y, _ = nearest_free(x, y, dx, dy, margin, walls)
        return free_x, free_y, 0.0, 0.0
    return _slide(x, y, dx, dy, vx, vy, margin, tolerance, walls)


@late_as(float64[:, ::1], MATRIX, MATRIX, VECTOR, WALLS)
def keep_out_of_walls(before, after, margins, table):
    """Returns the states of people after a step that enters no wall.

    The straight line from before to after comes no nearer to a wall than the
    margin, or than the person was before. A step that would goes as far as it
    can and then along the wall: the part of the rest of the displacement that
    leads into the wall is lost, and so is that part of the velocity. Nobody
    moves farther or faster than proposed, and people who meet no wall have
    exactly the proposed state. The yaw is always as proposed: people look where
    they want to go.

    A person inside a solid, or less than a micrometer from a wall, is put at
    the margin (less where there is no room) in front of the nearest outline
    that leads out, at rest; or stays there, at rest, if nothing does.

    States, also the result, have the shape (n, 6): x, y, yaw, vx, vy, omega.
    The margins are those of `wall_margins`.
    """
    walls = opened(table)
    result = after.copy()
    for i in range(len(before)):
        x = before[i, X]
        y = before[i, Y]
        to_x = after[i, X]
        to_y = after[i, Y]
        margin = margins[i]
        scale = abs(x) + abs(y) + abs(to_x) + abs(to_y)
        tolerance = 1e-12 + 1e-14 * scale
        stands, meets = _touches(x, y, to_x, to_y, margin, tolerance, walls)
        stands = stands or inside_any(x, y, walls)
        if stands or meets:
            result[i, X], result[i, Y], result[i, VX], result[i, VY] = (
                _kept_out(
                    *(x, y, to_x - x, to_y - y, after[i, VX], after[i, VY]),
                    *(margin, tolerance, stands, table),
                )
            )
    return result
