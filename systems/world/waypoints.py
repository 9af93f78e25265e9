"""The next corner of the world to walk to, compiled by numba.

Most corners are hidden from a person by walls that hide them from all around.
The segment that hid a corner from a cell of the floor is remembered, and tried
first when the cell is asked about again: see `Hidden`. That saves time, and
never changes a result.

The arguments have the names and units of `walls.py`.
"""

import math
from typing import NamedTuple

import numba
from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import (
    INTEGERS,
    MATRIX,
    REAL,
    WALLS,
    jit,
    jit_as,
    unowned,
)
from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.common.sorting import heap_between, pop_least
from hunav_drake.systems.world.sweep import crosses
from hunav_drake.systems.world.visibility_graph import (
    SQUEEZED,
    blocker,
    sees,
    stops,
)
from hunav_drake.systems.world.walls import opened, out_of_box, segments_near

# Ways whose lengths differ less are equal, in meters.
_SAME = 1e-9

# The part of the clearance with which ways lead on where they would turn back.
_SLACK = 0.8

# A person nearer to a vertex than this part of the clearance does not step
# aside to it.
_NEAR = 0.2

# The side of a cell, in meters, and how far around it a wall must hide a
# corner, so that rounding does not matter.
_CELL = 0.25
_MARGIN = 1e-6

# The largest number of remembered numbers: 16 MB.
_MOST = 2**22

# The memory of a corner and a cell: a segment that hid it from a place there
# counts from 1.
_UNKNOWN = 0
_HIDDEN = -1


class Hidden(NamedTuple):
    """The segments that hide the vertices of a map from cells of the floor.

    Attributes:
        cells: Shape (c, 2): the column and row of the cell that is remembered
            in each place.
        hiders: Shape (c, m): _HIDDEN for a vertex that is seen from nowhere in
            the cell, 1 + the number of a segment that hid it from somewhere
            in it, or _UNKNOWN.
    """

    cells: np.ndarray
    hiders: np.ndarray


def nothing_hidden(vertices: int) -> Hidden:
    """Returns an empty memory for a number of vertices."""
    places = max(_MOST // max(vertices, 1), 1)
    # (Pages that nobody writes to take no memory.)
    return Hidden(
        np.zeros((places, 2), dtype=np.int64),
        np.zeros((places, vertices), dtype=np.int32),
    )


@jit
def _remembered(x, y, hidden):
    """Returns the cell of a place, and the hiders of vertices from there."""
    column = math.floor(x / _CELL)
    row = math.floor(y / _CELL)
    place = (column * 7919 + row * 104729) % len(hidden.cells)
    cell = hidden.cells[place]
    hiders = hidden.hiders[place]
    if cell[0] != column or cell[1] != row:
        cell[0] = column
        cell[1] = row
        hiders[:] = _UNKNOWN
    return column, row, hiders


@jit
def _side_of(x, y, qx, qy, cell):
    """Returns the side of all lines from (qx, qy) to a cell that has (x, y).

    1 is left, -1 is right, and 0 is neither.
    """
    dx = x - qx
    dy = y - qy
    left = 0
    right = 0
    for i in range(0, 4, 2):
        for j in range(1, 4, 2):
            turn = (cell[i] - qx) * dy - (cell[j] - qy) * dx
            left += turn > 0
            right += turn < 0
    return int(left == 4) - int(right == 4)


@jit
def _is_beside(cell, segments, s):
    """Returns whether segment `s` surely lies outside of a cell."""
    x0, y0, x1, y1 = cell
    if out_of_box(x0, y0, x1, y1, 0.0, segments, s):
        return True
    ax = segments[s, 0]
    ay = segments[s, 1]
    return _side_of(segments[s, 2], segments[s, 3], ax, ay, cell) != 0


@jit
def _hides_from_all(column, row, qx, qy, walls, s):
    """Returns whether the wall of segment `s` hides a point from a whole cell.

    It does if it goes on, to both ends of the segment, without a gap and
    beside the cell, until it has left the lines from the point to all places of
    the cell on different sides. So it lies across all of them.
    """
    x0 = column * _CELL - _MARGIN
    y0 = row * _CELL - _MARGIN
    side = _CELL + 2 * _MARGIN
    cell = (x0, y0, x0 + side, y0 + side)
    segments = walls.segments
    if not _is_beside(cell, segments, s):
        return False
    shape = np.searchsorted(walls.first, s, side="right") - 1
    begin = walls.first[shape]
    count = walls.first[shape + 1] - begin
    sides = 0
    for step in (1, -1):
        end = 1 + step
        at = s
        while True:
            x = segments[at, end]
            y = segments[at, end + 1]
            left = _side_of(x, y, qx, qy, cell)
            if left != 0:
                break
            at = begin + (at - begin + step) % count
            if (
                at == s
                or segments[at, 2 - end] != x
                or segments[at, 3 - end] != y
                or not _is_beside(cell, segments, at)
            ):
                return False
        sides += left
    return sides == 0


@jit
def _hider(x, y, vertex, clearance, vertices, known, walls):
    """Returns the hider of a vertex: see `Hidden`; _UNKNOWN if it is seen."""
    column, row, _ = known
    vx = vertices[vertex, 0]
    vy = vertices[vertex, 1]
    across = -1
    for s in segments_near(x, y, vx, vy, 0.0, walls):
        if crosses(x, y, vx, vy, walls.segments, s):
            if _hides_from_all(column, row, vx, vy, walls, s):
                return _HIDDEN
            across = s
    if across < 0:
        across = blocker(x, y, vx, vy, clearance, walls)
    return across + 1


@jit
def _is_hidden(x, y, vertex, clearance, vertices, known, walls):
    """Returns whether a vertex cannot be seen from (x, y): see `sees`.

    `known` is the result of `_remembered` for the place.
    """
    hiders = known[2]
    hider = hiders[vertex]
    if hider == _HIDDEN:
        return True
    vx = vertices[vertex, 0]
    vy = vertices[vertex, 1]
    if hider != _UNKNOWN and stops(x, y, vx, vy, clearance, walls, hider - 1):
        return True
    hider = _hider(x, y, vertex, clearance, vertices, known, walls)
    if hider == _UNKNOWN:
        return False
    hiders[vertex] = hider
    return True


@jit
def _turns_back(x, y, vx, vy, ox, oy, clearance):
    """Returns whether one goes back to v before o, or, near v, aside to it.

    In a door that is barely wide enough, nobody should turn back for so little.
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
def _leading(x, y, to_place, hiders, vertices):
    """Returns the vertices that may be seen from (x, y) and lead to the place.

    After them come arrays of their distances, and of the lengths of the ways to
    the place by way of them, in meters.
    """
    numbers = np.empty(len(vertices), dtype=np.int64)
    legs = np.empty(len(vertices))
    ways = np.empty(len(vertices))
    count = 0
    for v in range(len(vertices)):
        if hiders[v] != _HIDDEN and to_place[v] < math.inf:
            numbers[count] = v
            legs[count] = math.hypot(vertices[v, 0] - x, vertices[v, 1] - y)
            ways[count] = legs[count] + to_place[v]
            count += 1
    return numbers[:count], legs[:count], ways[:count]


@jit
def _choice(x, y, leading, clearance, vertices, known, walls):
    """Returns the vertex in sight of (x, y) with the shortest way, or -1.

    It is an index in the arrays of `leading`, the result of `_leading`;
    `known` is the result of `_remembered`.
    """
    numbers, legs, ways = leading
    if len(ways) == 0:
        return -1
    # A near one is likely to be seen, and spares tests of many others.
    shortest = math.inf
    nearest = np.argmin(legs)
    if not _is_hidden(
        x, y, numbers[nearest], clearance, vertices, known, walls
    ):
        shortest = ways[nearest]
    # Of the others with shorter ways, the first in sight is the one.
    heap = np.empty(len(ways), dtype=np.int64)
    for count in range(heap_between(0.0, shortest, ways, heap), 0, -1):
        i = pop_least(ways, heap, count)
        if not _is_hidden(x, y, numbers[i], clearance, vertices, known, walls):
            shortest = ways[i]
            break
    if shortest == math.inf:
        return -1
    alike = heap_between(shortest, shortest + 1e3 * _SAME, ways, heap)
    if alike == 1:
        return heap[0]
    choice = -1
    for count in range(alike, 0, -1):
        i = pop_least(ways, heap, count)
        if choice >= 0 and ways[i] > ways[choice] + _SAME:
            break
        # Of equal ways, the one with the farther waypoint: a person who
        # stands on a vertex looks on to the next.
        if (choice < 0 or legs[i] > legs[choice]) and not _is_hidden(
            x, y, numbers[i], clearance, vertices, known, walls
        ):
            choice = i
    return choice


@jit
def _waypoint(
    x, y, goal_x, goal_y, ways_to, clearance, vertices, hidden, walls
):
    """Returns the point to walk to next from (x, y), on the way to a goal.

    The goal itself is not in sight, with the clearance. The other arguments
    are those of `guided`.
    """
    place_x, place_y, last_clearance = ways_to[:3]
    elsewhere = place_x != goal_x or place_y != goal_y
    if (elsewhere or last_clearance != clearance) and sees(
        x, y, place_x, place_y, last_clearance, walls
    ):
        # In front of the furniture that the goal is in, people lean towards
        # the goal, and come to rest there.
        if math.hypot(place_x - x, place_y - y) < 2 * clearance:
            return goal_x, goal_y
        return place_x, place_y
    known = _remembered(x, y, hidden)
    leading = _leading(x, y, ways_to[3:], known[2], vertices)
    numbers, legs, _ = leading
    choice = _choice(x, y, leading, clearance, vertices, known, walls)
    if choice >= 0 and legs[choice] < 2 * clearance:
        slack = _SLACK * clearance
        vx, vy = vertices[numbers[choice]]
        other = _choice(x, y, leading, slack, vertices, known, walls)
        ox, oy = vertices[numbers[other]]
        if _turns_back(x, y, vx, vy, ox, oy, clearance):
            choice = other
    if choice < 0:
        squeezed = SQUEEZED * clearance
        choice = _choice(x, y, leading, squeezed, vertices, known, walls)
    if choice < 0:
        return goal_x, goal_y
    return vertices[numbers[choice], 0], vertices[numbers[choice], 1]


@jit_as(
    float64[:, ::1],
    *(MATRIX, MATRIX, INTEGERS, MATRIX, REAL, MATRIX),
    *(numba.int64[:, ::1], numba.int32[:, ::1], WALLS),
)
def guided(
    positions, command, who, ways_to, clearance, vertices, cells, hiders, table
):
    """Returns commands with the next waypoints, if the goal is not seen.

    A waypoint that is not the goal has a radius of zero. `who` (k,) are the
    rows of people who do not see the goal, with the clearance. `ways_to`
    (k, 3 + m) holds for the goal of each x and y of its `standing_place`; the
    clearance of the last leg; and the length of the shortest way from each
    vertex to the place, infinity if there is none. `cells` and `hiders` are
    those of `Hidden`, and are updated.
    """
    walls = opened(table)
    hidden = Hidden(unowned(cells), unowned(hiders))
    vertices = unowned(vertices)
    ways_to = unowned(ways_to)
    result = command.copy()
    for k in range(len(who)):
        i = who[k]
        goal_x = command[i, Command.GOAL_X]
        goal_y = command[i, Command.GOAL_Y]
        x, y = _waypoint(
            *(positions[i, 0], positions[i, 1], goal_x, goal_y, ways_to[k]),
            *(clearance, vertices, hidden, walls),
        )
        if x != goal_x or y != goal_y:
            result[i, Command.GOAL_X] = x
            result[i, Command.GOAL_Y] = y
            result[i, Command.GOAL_RADIUS] = 0.0
    return result
