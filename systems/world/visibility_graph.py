"""Who can walk straight to where, compiled by numba."""

import math

import numba
from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import (
    FLAGS,
    INDICES,
    MATRIX,
    REAL,
    VECTOR,
    jit,
    jit_as,
)
from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.world.sweep import (
    distance_to,
    is_free,
    nearest_free,
    nearest_on_path,
    out_of_box,
)

# Lengths that differ less are the same, in meters.
_SAME = 1e-9

# Where people or goals are too near to walls for a way with the clearance, one
# with this part of it may lead on.
SQUEEZED = 0.25

# With this part of the clearance, ways lead on where they would turn back.
_SLACK = 0.8

# Who is nearer to a vertex than this part of the clearance does not step aside
# to it.
_NEAR = 0.2


@jit
def _passes(px, py, qx, qy, near, where, segments, s):
    """Tells whether a path first nears and then leaves walls at segment `s`.

    It does not where another wall is nearer, or as near and so from an end of
    the path on.

    Args:
        px: The path from p to q, in meters.
        py: Likewise.
        qx: Likewise.
        qy: Likewise.
        near: What `nearest_on_path` gives for segment `s`.
        where: Likewise.
        segments: Shape (s, 4): see `Obstacles`.
        s: A segment that is nearest to neither end.
    """
    x = px + where * (qx - px)
    y = py + where * (qy - py)
    for r in range(len(segments)):
        if r != s and not out_of_box(x, y, x, y, near + _SAME, segments, r):
            other = distance_to(x, y, segments, r)
            if other < near - _SAME or (
                other <= near + _SAME
                and min(
                    distance_to(px, py, segments, r),
                    distance_to(qx, qy, segments, r),
                )
                <= other + _SAME
            ):
                return False
    return True


@jit
def sees(px, py, qx, qy, clearance, segments):
    """Tells whether the straight way from p to q keeps its clearance.

    It may begin beside walls, and leave them, and end beside walls, and draw
    near to them, but not pass them more closely than the clearance. So
    whoever sees a point sees it from the whole way to it.
    """
    for s in range(len(segments)):
        if out_of_box(px, py, qx, qy, clearance, segments, s):
            continue
        near, where = nearest_on_path(px, py, qx, qy, segments, s)
        if near >= clearance - _SAME:
            continue
        if where < 0:
            return False
        if (
            near < distance_to(px, py, segments, s) - _SAME
            and near < distance_to(qx, qy, segments, s) - _SAME
            and _passes(px, py, qx, qy, near, where, segments, s)
        ):
            return False
    return True


@jit_as(numba.boolean[::1], MATRIX, MATRIX, REAL, MATRIX)
def blocked(positions, goals, clearance, segments):
    """Tells whose straight way is not free.

    Args:
        positions: Shape (n, 2 or more): x, y, ..., in meters.
        goals: Shape (n, 2), in meters.
        clearance: In meters.
        segments: Shape (s, 4): see `Obstacles`.

    Returns:
        Shape (n,).
    """
    result = np.empty(len(positions), dtype=np.bool_)
    for i in range(len(positions)):
        result[i] = not sees(
            *(positions[i, 0], positions[i, 1], goals[i, 0], goals[i, 1]),
            *(clearance, segments),
        )
    return result


@jit_as(numba.boolean[::1], MATRIX, MATRIX, REAL, MATRIX)
def needs_way(positions, command, clearance, segments):
    """Tells who has a goal, is not there, and cannot walk straight to it.

    Args:
        positions: Shape (n, 2 or more): x, y, ..., in meters.
        command: Shape (n, COMMAND_SIZE).
        clearance: In meters.
        segments: Shape (s, 4): see `Obstacles`.

    Returns:
        Shape (n,).
    """
    result = np.empty(len(positions), dtype=np.bool_)
    for i in range(len(positions)):
        x = positions[i, 0]
        y = positions[i, 1]
        gx = command[i, Command.GOAL_X]
        gy = command[i, Command.GOAL_Y]
        result[i] = (
            command[i, Command.HAS_GOAL] != 0
            and math.hypot(gx - x, gy - y) > command[i, Command.GOAL_RADIUS]
            and not sees(x, y, gx, gy, clearance, segments)
        )
    return result


@jit_as(numba.boolean[::1], MATRIX, REAL, MATRIX, INDICES, FLAGS)
def free_points(points, clearance, segments, first, solid):
    """Tells which points (m, 2) have their clearance from every wall."""
    result = np.empty(len(points), dtype=np.bool_)
    for i in range(len(points)):
        result[i] = is_free(
            points[i, 0], points[i, 1], clearance, segments, first, solid
        )
    return result


@jit_as(float64[:, ::1], MATRIX, REAL, MATRIX)
def straight_lengths(points, clearance, segments):
    """Returns the lengths of the straight ways between points (m, 2).

    Returns:
        Shape (m, m), in meters; infinity where there is no way.
    """
    m = len(points)
    lengths = np.full((m, m), np.inf)
    for i in range(m):
        for j in range(i):
            px, py = points[i, 0], points[i, 1]
            qx, qy = points[j, 0], points[j, 1]
            if sees(px, py, qx, qy, clearance, segments):
                lengths[i, j] = lengths[j, i] = math.hypot(px - qx, py - qy)
    return lengths


@jit_as(float64[::1], REAL, REAL, REAL, MATRIX, MATRIX, MATRIX)
def lengths_to_goal(gx, gy, clearance, vertices, lengths, segments):
    """Returns the length of the shortest way from each vertex to a goal.

    Args:
        gx: The goal, in meters.
        gy: Likewise.
        clearance: That of the last leg, in meters.
        vertices: Shape (m, 2), in meters.
        lengths: Shape (m, m): the shortest ways between them.
        segments: Shape (s, 4): see `Obstacles`.

    Returns:
        Shape (m,), in meters; infinity where there is no way.
    """
    m = len(vertices)
    result = np.full(m, np.inf)
    for u in range(m):
        ux = vertices[u, 0]
        uy = vertices[u, 1]
        if sees(gx, gy, ux, uy, clearance, segments):
            last = math.hypot(gx - ux, gy - uy)
            for v in range(m):
                result[v] = min(result[v], lengths[u, v] + last)
    return result


@jit_as(float64[::1], REAL, REAL, REAL, MATRIX, INDICES, FLAGS)
def standing_place(gx, gy, clearance, segments, first, solid):
    """Returns the place (2,) to go to for a goal: itself, or outside solids."""
    if is_free(gx, gy, 0.0, segments, first, solid):
        return np.array([gx, gy])
    x, y, _ = nearest_free(gx, gy, 0.0, 0.0, clearance, segments, first, solid)
    return np.array([x, y])


@jit
def _turns_back(x, y, vx, vy, ox, oy, clearance):
    """Tells whether one goes back to v before o, or, near v, aside to it.

    In a door that is just a way, nobody should turn back for a hair.
    """
    vx -= x
    vy -= y
    ox -= x
    oy -= y
    leg = math.hypot(vx, vy)
    along = vx * ox + vy * oy
    cosine = 0.0 if leg < _NEAR * clearance else -0.5
    return along < cosine * leg * math.hypot(ox, oy)


@jit
def _choice(x, y, legs, ways, order, clearance, vertices, segments):
    """Returns the vertex in sight with the shortest way, or -1.

    Args:
        x: Where the person is, in meters.
        y: Likewise.
        legs: Shape (m,): how far the vertices are, in meters.
        ways: Shape (m,): how far the place is by way of them, in meters.
        order: Shape (m,): the vertices, those with shorter ways first.
        clearance: That of the legs, in meters.
        vertices: Shape (m, 2), in meters.
        segments: Shape (s, 4): see `Obstacles`.
    """
    choice = -1
    for v in order:
        if choice >= 0 and ways[v] > ways[choice] + _SAME:
            break
        # Of equal ways the one with the farther waypoint: a person who
        # stands on a vertex looks on to the next.
        if ways[v] < math.inf and (choice < 0 or legs[v] > legs[choice]):
            vx = vertices[v, 0]
            vy = vertices[v, 1]
            if sees(x, y, vx, vy, clearance, segments):
                choice = v
    return choice


@jit_as(
    float64[::1],
    *(VECTOR, VECTOR, VECTOR, REAL, VECTOR, REAL, MATRIX, MATRIX),
)
def waypoint(
    p, goal, place, last_clearance, to_place, clearance, vertices, segments
):
    """Returns the point (2,) to walk to next, on the way to a goal.

    Args:
        p: Shape (2 or more,): where the person is, in meters.
        goal: Shape (2,), in meters.
        place: Shape (2,): what `standing_place` gives for the goal.
        last_clearance: That of the last leg, in meters.
        to_place: Shape (m,): what `lengths_to_goal` gives for the place.
        clearance: That of the other legs, in meters.
        vertices: Shape (m, 2), in meters.
        segments: Shape (s, 4): see `Obstacles`.
    """
    x = p[0]
    y = p[1]
    if sees(x, y, place[0], place[1], last_clearance, segments):
        # In front of the furniture that the goal is in, people lean towards
        # the goal, and come to rest there.
        near = math.hypot(place[0] - x, place[1] - y) < 2 * clearance
        return goal.copy() if near else place.copy()
    count = len(vertices)
    legs = np.empty(count)
    for v in range(count):
        legs[v] = math.hypot(vertices[v, 0] - x, vertices[v, 1] - y)
    ways = legs + to_place
    order = np.argsort(ways)
    choice = _choice(x, y, legs, ways, order, clearance, vertices, segments)
    if choice >= 0 and legs[choice] < 2 * clearance:
        slack = _SLACK * clearance
        vx, vy = vertices[choice]
        other = _choice(x, y, legs, ways, order, slack, vertices, segments)
        ox, oy = vertices[other]
        if _turns_back(x, y, vx, vy, ox, oy, clearance):
            choice = other
    if choice < 0:
        squeezed = SQUEEZED * clearance
        choice = _choice(x, y, legs, ways, order, squeezed, vertices, segments)
    return vertices[choice].copy() if choice >= 0 else goal.copy()
