"""Lets people take turns in narrow passages, compiled by numba.

Two bodies that come towards each other through a door without room for both
would press against each other for ever. Therefore the person farther from the
passage waits beside it, or goes back a step, until the other one is out.
"""

import math

import numba
from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import MATRIX, VECTOR, WALLS, jit
from hunav_drake.systems.common.late import late_as
from hunav_drake.systems.common.layout import Command, X, Y
from hunav_drake.systems.crowd.bodies.pairs import near_pairs
from hunav_drake.systems.crowd.bodies.time_gap import DOUBT, SLIM, SOFT
from hunav_drake.systems.people.parameters import EPSILON
from hunav_drake.systems.world.nearest import nearest_on_segments
from hunav_drake.systems.world.ray_cast import first_hit
from hunav_drake.systems.world.sweep import path_distance
from hunav_drake.systems.world.walls import opened, segments_in

# The largest distance between people who take turns, in meters.
_SEEN = 3.5

# The distance behind people in which the end of a passage is searched, and the
# spacing of the places at which its width is computed, in meters.
_BEHIND, _SPACING = 2.0, 0.1

# The sine of the angle from which on a wall is beside a person, not ahead.
_SIDE = 0.3

# People farther from a passage than this walk on, in meters.
_NEAR = 1.0

# People pass each other where it is wider than both bodies by this, in meters.
_ROOM = 0.1

# The gaps of a waiting person before a passage, and beside it, in meters.
_BEFORE, _ASIDE = 0.2, 0.1

# A person in a passage, or this near before it, goes straight back, in meters.
_MOUTH = 0.1

# More than one, by more than the rounding of lengths.
_MORE = 1 + 1e-9

# Distances to a passage that differ by less than this are equal, in meters.
_TIE = 1e-9

# The goal radius of a waiting person, in meters.
_THERE = 0.1


@jit
def _width(x, y, ex, ey, limit, near, segments, posts):
    """Returns the apparent width of a place for a person going to (ex, ey).

    As in `passage_width`, walls ahead or behind, rather than beside, count as
    farther; and beyond 72 degrees, they do not count. A side on which there is
    nothing up to the limit is as wide as that. Array `posts` receives the
    nearest points on the left and on the right: (x, y, x, y).
    """
    left = limit
    right = limit
    for s in near:
        nx, ny, d2 = nearest_on_segments(x, y, segments, s, s + 1)
        beside = ex * (ny - y) - ey * (nx - x)
        # (Nothing seems nearer than it is, to rounding.)
        nearest = left if beside > 0 else right
        if d2 > _MORE * nearest * nearest:
            continue
        away = math.sqrt(d2)
        if beside == 0 or abs(beside) < _SIDE * away:
            continue
        seems = away * math.sqrt(math.sqrt(away / abs(beside)))
        if beside > 0 and seems < left:
            left = seems
            posts[0] = nx
            posts[1] = ny
        elif beside < 0 and seems < right:
            right = seems
            posts[2] = nx
            posts[3] = ny
    return left + right


@jit
def _passage(x, y, ex, ey, length, need, walls, ends):
    """Returns the begin and the end of the passage between two people.

    One is at (x, y), the other in the direction (ex, ey) at the distance
    `length`. Widths below `need` are a passage. Array `ends`, of shape (2, 4),
    receives the posts of both ends: see `_width`. The results are distances
    from the first person, in meters: negative behind the person, infinite for
    an end too far behind to be seen; both are NaN if there is no passage.
    """
    ahead = length + _BEHIND
    qx = x + ahead * ex
    qy = y + ahead * ey
    px = x - _BEHIND * ex
    py = y - _BEHIND * ey
    near = segments_in(
        *(min(px, qx) - need, min(py, qy) - need),
        *(max(px, qx) + need, max(py, qy) + need),
        walls,
    )
    if len(near) == 0:
        return math.nan, math.nan
    if first_hit(x, y, x + length * ex, y + length * ey, walls) <= 1:
        return math.nan, math.nan
    # Only walls this near make a place between the two narrow.
    close = np.empty(len(near), np.int64)
    count = 0
    for s in near:
        away = path_distance(
            x, y, x + length * ex, y + length * ey, walls.segments, s
        )
        if away < _MORE * need:
            close[count] = s
            count += 1
    posts = np.empty(4)
    places = max(int(length / _SPACING) + 1, 2)
    spacing = length / (places - 1)
    narrowest = need
    middle = -1
    for k in range(places):
        at = k * spacing
        width = _width(
            *(x + at * ex, y + at * ey, ex, ey, need),
            *(close[:count], walls.segments, posts),
        )
        if width < narrowest:
            narrowest = width
            middle = k
    if middle < 0:
        return math.nan, math.nan
    found = np.empty(2)
    for end in range(2):
        side = 2.0 * end - 1.0
        at = middle * spacing
        found[end] = side * math.inf
        inner = narrowest
        while -_BEHIND <= at <= ahead:
            width = _width(
                *(x + at * ex, y + at * ey, ex, ey, math.inf),
                *(near, walls.segments, posts),
            )
            if width >= need:
                part = (width - need) / (width - inner)
                part = 1.0 if math.isinf(width) else part
                found[end] = at - side * part * spacing
                break
            inner = width
            for k in range(len(posts)):
                ends[end, k] = posts[k]
            at += side * spacing
    return found[0], found[1]


@jit
def _wait(state, ex, ey, body, epsilon, posts, wanted):
    """Lets a person wait before a passage, with these posts at its end.

    The other person is in the direction (ex, ey).
    """
    cx = (posts[0] + posts[2]) / 2
    cy = (posts[1] + posts[3]) / 2
    tx = posts[0] - posts[2]
    ty = posts[1] - posts[3]
    width = math.hypot(tx, ty)
    if width == 0:
        return
    tx /= width
    ty /= width
    # Out of the passage, and to the left of a person who comes out of it.
    nx, ny = ty, -tx
    if nx * ex + ny * ey > 0:
        nx, ny = -nx, -ny
    tx, ty = -ny, nx
    out = (state[X] - cx) * nx + (state[Y] - cy) * ny
    aside = (state[X] - cx) * tx + (state[Y] - cy) * ty
    if out >= _MOUTH:
        # (A waiting person faces the other way: the right is the left.)
        side = np.sign(aside + DOUBT * np.sign(epsilon))
        if side == 0:
            side = 1.0
        aside = side * max(abs(aside), width / 2 + body + _ASIDE)
    out = max(out, body + _BEFORE)
    wanted[Command.GOAL_X] = cx + out * nx + aside * tx
    wanted[Command.GOAL_Y] = cy + out * ny + aside * ty
    wanted[Command.GOAL_RADIUS] = _THERE
    wanted[Command.GROUP_ID] = -1.0


@late_as(
    numba.types.UniTuple(float64[:, ::1], 2),
    *(MATRIX, VECTOR, MATRIX, MATRIX, MATRIX, WALLS),
)
def take_turns(states, bodies, command, parameters, at_walls, table):
    """Returns commands and `at_walls` of people at narrow passages.

    Of two people who come towards each other, with a passage between them that
    is too narrow for both, the one nearer to it, or deeper in it, goes first;
    at equal distances, the one with the lower x, or y. The other one waits
    beside it, on the own side, or on the right if in doubt. The one who goes
    turns the shoulders, so that walls push less. Commands have waypoints for
    goals.
    """
    n = len(states)
    wanted = command.copy()
    felt = at_walls.copy()
    goes = np.zeros(n, np.bool_)
    walls = opened(table)
    ways = np.zeros((n, 2))
    for i in range(n):
        gx = command[i, Command.GOAL_X] - states[i, X]
        gy = command[i, Command.GOAL_Y] - states[i, Y]
        far = math.hypot(gx, gy)
        if (
            command[i, Command.HAS_GOAL] != 0
            and command[i, Command.HOLD] == 0
            and command[i, Command.DESIRED_SPEED] > 0
            and far > command[i, Command.GOAL_RADIUS]
        ):
            ways[i, 0] = gx / far
            ways[i, 1] = gy / far
    # The distance of each person from the passage for which it waits.
    nearest = np.full(n, np.inf)
    ends = np.empty((2, 4))
    pairs = near_pairs(states[:, X], states[:, Y], np.full(n, _SEEN / 2))
    for p in range(len(pairs)):
        i = pairs[p, 0]
        j = pairs[p, 1]
        if ways[i, 0] * ways[j, 0] + ways[i, 1] * ways[j, 1] >= 0:
            continue
        if states[j, X] < states[i, X] or (
            states[j, X] == states[i, X] and states[j, Y] < states[i, Y]
        ):
            i, j = j, i
        ex = states[j, X] - states[i, X]
        ey = states[j, Y] - states[i, Y]
        length = math.hypot(ex, ey)
        if length == 0:
            continue
        ex /= length
        ey /= length
        if (
            ways[i, 0] * ex + ways[i, 1] * ey <= 0
            or ways[j, 0] * ex + ways[j, 1] * ey >= 0
        ):
            continue
        begin, end = _passage(
            *(states[i, X], states[i, Y], ex, ey, length),
            *(2 * (bodies[i] + bodies[j]) + _ROOM, walls, ends),
        )
        # Nobody can go back where no end is seen.
        if math.isnan(begin) or (math.isinf(begin) and math.isinf(end)):
            continue
        away = length - end
        first = begin <= away + _TIE
        goes[i] |= first and begin < _NEAR
        goes[j] |= not first and away < _NEAR
        if first and away < min(_NEAR, nearest[j]):
            nearest[j] = away
            _wait(
                *(states[j], -ex, -ey, bodies[j]),
                *(parameters[j, EPSILON], ends[1], wanted[j]),
            )
        elif not first and begin < min(_NEAR, nearest[i]):
            nearest[i] = begin
            _wait(
                *(states[i], ex, ey, bodies[i]),
                *(parameters[i, EPSILON], ends[0], wanted[i]),
            )
    for i in range(n):
        if goes[i] and math.isinf(nearest[i]):
            felt[i, 0] = min(felt[i, 0], SLIM)
            felt[i, 1] *= SOFT
    return wanted, felt
