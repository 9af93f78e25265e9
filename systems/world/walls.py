"""Queries of the walls nearby, compiled by numba: they read `wall_table`.

A query goes through the boxes of the table in their order. A box out of reach
is skipped with all that is in it, by `links[box, 0]`; the others lead to runs
of segments. Skipping never changes a result, not even its last bit.

Kernels call the start of a path (px, py) and its end (qx, qy), in meters;
`reach` and `clearance` are distances, in meters; `walls` are `Walls`, and
`table` is `Obstacles.table`.
"""

from typing import NamedTuple

import numpy as np

from hunav_drake.systems.common.kernels import jit, jit_generator, unowned
from hunav_drake.systems.common.sorting import stable_order

# The part of coordinates that rounding may change.
_ROUNDING = 1e-12


class Walls(NamedTuple):
    """The parts of a table: see `wall_table`.

    Attributes:
        segments: Shape (s, 4): see `Obstacles`.
        first: Shape (k + 1,): see `Obstacles`.
        solid: Shape (k,): 1 for a solid shape, else 0.
        boxes: Shape (m, 4): rows (x0, y0, x1, y1), in meters.
        runs: Shape (r, 4): rows (first segment, end, shape, box).
        links: Shape (m, 2): rows (next box outside of this one, run or -1).
    """

    segments: np.ndarray
    first: np.ndarray
    solid: np.ndarray
    boxes: np.ndarray
    runs: np.ndarray
    links: np.ndarray


@jit
def opened(table):
    """Returns the parts of a table, as views: see `unowned`."""
    table = unowned(table)
    sizes = table[:4].view(np.int64)
    segments = 4 + 4 * sizes[0]
    boxes = segments + 4 * sizes[3]
    first = boxes + sizes[1] + 1
    solid = first + sizes[1]
    runs = solid + 4 * sizes[2]
    links = runs + 2 * sizes[3]
    return Walls(
        table[4:segments].reshape((sizes[0], 4)),
        table[boxes:first].view(np.int64),
        table[first:solid].view(np.int64),
        table[segments:boxes].reshape((sizes[3], 4)),
        table[solid:runs].view(np.int64).reshape((sizes[2], 4)),
        table[runs:links].view(np.int64).reshape((sizes[3], 2)),
    )


@jit
def out_of_box(px, py, qx, qy, reach, rows, i):
    """Returns whether a path is farther than `reach` by its bounds alone.

    It is compared with row `i` of segments or boxes, shape (m, 4).
    """
    x0 = rows[i, 0]
    y0 = rows[i, 1]
    x1 = rows[i, 2]
    y1 = rows[i, 3]
    return (
        min(x0, x1) > max(px, qx) + reach
        or max(x0, x1) < min(px, qx) - reach
        or min(y0, y1) > max(py, qy) + reach
        or max(y0, y1) < min(py, qy) - reach
    )


@jit
def beyond(px, py, qx, qy, reach, boxes, box):
    """Returns whether a box is surely farther than `reach` from a path."""
    reach += _ROUNDING * (abs(px) + abs(py) + abs(qx) + abs(qy))
    if out_of_box(px, py, qx, qy, reach, boxes, box):
        return True
    # The corners of the box are all on one side of the path.
    dx = qx - px
    dy = qy - py
    rx = 0.5 * (boxes[box, 0] + boxes[box, 2]) - px
    ry = 0.5 * (boxes[box, 1] + boxes[box, 3]) - py
    wide = abs(dx) * (boxes[box, 3] - boxes[box, 1])
    high = abs(dy) * (boxes[box, 2] - boxes[box, 0])
    reach += _ROUNDING * (abs(rx) + abs(ry))
    # (The length of the path is at most the sum of both parts.)
    return abs(dx * ry - dy * rx) > 0.5 * (wide + high) + reach * (
        abs(dx) + abs(dy)
    )


@jit_generator
def segments_near(px, py, qx, qy, reach, walls):
    """Yields the segments that may be within `reach` of a path.

    All others are farther away by their bounds alone.
    """
    box = 0
    while box < len(walls.boxes):
        if beyond(px, py, qx, qy, reach, walls.boxes, box):
            box = walls.links[box, 0]
            continue
        run = walls.links[box, 1]
        box += 1
        if run >= 0:
            for s in range(walls.runs[run, 0], walls.runs[run, 1]):
                if not out_of_box(px, py, qx, qy, reach, walls.segments, s):
                    yield s


@jit
def distance2_to_box(x, y, boxes, box):
    """Returns a lower bound of a point's squared distance from all in a box."""
    dx = max(boxes[box, 0] - x, x - boxes[box, 2], 0.0)
    dy = max(boxes[box, 1] - y, y - boxes[box, 3], 0.0)
    return (dx * dx + dy * dy) * (1 - _ROUNDING)


@jit
def runs_in(x0, y0, x1, y1, walls):
    """Returns the runs with a box that meets a rectangle, in their order."""
    found = np.empty(len(walls.runs), dtype=np.int64)
    count = 0
    ascending = True
    box = 0
    while box < len(walls.boxes):
        if (
            walls.boxes[box, 0] > x1
            or walls.boxes[box, 2] < x0
            or walls.boxes[box, 1] > y1
            or walls.boxes[box, 3] < y0
        ):
            box = walls.links[box, 0]
            continue
        run = walls.links[box, 1]
        if run >= 0:
            ascending = ascending and (count == 0 or found[count - 1] < run)
            found[count] = run
            count += 1
        box += 1
    if not ascending:
        numbers = np.empty(count)
        for i in range(count):
            numbers[i] = found[i]
        order = stable_order(numbers)
        for i in range(count):
            found[i] = np.int64(numbers[order[i]])
    return found[:count]


@jit
def segments_in(x0, y0, x1, y1, walls):
    """Returns the segments of the runs in a rectangle: see `runs_in`."""
    runs = runs_in(x0, y0, x1, y1, walls)
    count = 0
    for run in runs:
        count += walls.runs[run, 1] - walls.runs[run, 0]
    segments = np.empty(count, dtype=np.int64)
    count = 0
    for run in runs:
        for s in range(walls.runs[run, 0], walls.runs[run, 1]):
            segments[count] = s
            count += 1
    return segments
