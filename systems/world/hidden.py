"""The corners of the world that nobody sees from a cell of the floor.

Most corners are hidden from a person by walls that hide them from all around.
The segment that hid a corner from a cell of the floor is remembered, and tried
first when the cell is asked about again: see `Hidden`. That saves time, and
never changes a result.

The arguments have the names and units of `walls.py`.
"""

import math
from typing import NamedTuple

import numpy as np

from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.world.sweep import crosses
from hunav_drake.systems.world.visibility_graph import blocker, stops
from hunav_drake.systems.world.walls import out_of_box, segments_near

# The side of a cell, in meters, and how far around it a wall must hide a
# corner, so that rounding does not matter.
_CELL = 0.25
_MARGIN = 1e-6

# The largest number of remembered numbers: 16 MB.
_MOST = 2**22

# The memory of a corner and a cell: a segment that hid it from a place there
# counts from 1.
_UNKNOWN = 0
HIDDEN = -1


class Hidden(NamedTuple):
    """The segments that hide the vertices of a map from cells of the floor.

    Attributes:
        cells: Shape (c, 2): the column and row of the cell that is remembered
            in each place.
        hiders: Shape (c, m): HIDDEN for a vertex that is seen from nowhere in
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
def remembered(x, y, hidden):
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
                return HIDDEN
            across = s
    if across < 0:
        across = blocker(x, y, vx, vy, clearance, walls)
    return across + 1


@jit
def is_hidden(x, y, vertex, clearance, vertices, known, walls):
    """Returns whether a vertex cannot be seen from (x, y): see `sees`.

    `known` is the result of `remembered` for the place.
    """
    hiders = known[2]
    hider = hiders[vertex]
    if hider == HIDDEN:
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
