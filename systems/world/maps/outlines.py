"""Outlines of cells: few polygons around the occupied cells of a grid.

Lines that a grid draws as stairs become straight again. Along a straight line
all steps of a grid are one cell high, and their centers lie on the line; so
the outline goes through points on the steps instead of around their corners.
"""

from collections import defaultdict
from collections.abc import Iterator
import math

import numpy as np
from numpy.typing import NDArray
import shapely

from hunav_drake.systems.common.arrays import Array, Mask

# The part of a step that is cut off its convex corner: a little less than half,
# so that centers of cells stay inside.
_CUT = 0.45

# The largest distances of a corner of a cell outside of an outline, and inside,
# in cells. With less than half a cell, the centers of occupied cells stay
# inside.
_LOST = 0.47
_GAINED = 0.63

# The largest distance from the line of its neighbors of a vertex that is left
# out, in cells.
_STRAIGHT = 0.02

# The largest number of sides of occupied cells: those of a hall of 1 km with
# shelves, in cells of 5 cm.
MAX_SIDES = 1_000_000

# The directions of sides, with the cells on their left: +x, +y, -x, -y.
_DX = np.array([1, 0, -1, 0])
_DY = np.array([0, 1, 0, -1])
_LEFT = ((0, 0), (-1, 0), (-1, -1), (0, -1))


def outlines(occupied: Mask) -> list[Array]:
    """Returns polygons around the occupied cells of a grid.

    Cells that touch, even only by a corner, are in one solid. The outlines are
    less than 0.7 cells from those of the cells, mostly less than half a cell;
    the centers of occupied cells are inside, those of free cells next to no
    occupied one are outside.

    Args:
        occupied: Shape (rows, columns); cell (i, j) covers [j, j + 1] along x
            and [i, i + 1] along y.

    Returns:
        Simple polygons without holes, counter-clockwise, each (k, 2), in
        cells: a solid around a hole is cut into pieces.

    Raises:
        ValueError: If the occupied cells have more sides than `MAX_SIDES`.
    """
    from scipy import ndimage

    rings: dict[int, list[Array]] = defaultdict(list)
    labels, _ = ndimage.label(occupied, structure=np.ones((3, 3)))
    for ring, cell in _rings(occupied):
        rings[int(labels[cell])].append(ring)
    result = []
    for solid in rings.values():
        if len(solid) == 1 and len(solid[0]) == 4:
            # A rectangle of cells, as most noise is, stays as it is.
            result.append(solid[0])
            continue
        for polygon in _polygons(solid):
            result += list(without_holes(polygon))
    return result


def _rings(occupied: Mask) -> Iterator[tuple[Array, tuple[int, int]]]:
    """Yields the corners (k, 2) of each ring of sides, with a cell in it.

    The occupied cells are on the left. Where two of them touch by a corner,
    the ring goes on along the other one.
    """
    grid = np.pad(occupied, 1)
    inner = grid[1:-1, 1:-1]
    free = (grid[:-2, 1:-1], grid[1:-1, 2:], grid[2:, 1:-1], grid[1:-1, :-2])
    columns = occupied.shape[1] + 1
    has = np.zeros((4, (occupied.shape[0] + 1) * columns), dtype=bool)
    for way in range(4):
        rows, cols = np.nonzero(inner & ~free[way])
        dx, dy = _LEFT[way]
        has[way, (rows - dy) * columns + cols - dx] = True
    direction, start = np.nonzero(has)
    if len(start) > MAX_SIDES:
        raise ValueError(
            f"the occupied cells must have at most {MAX_SIDES} sides, got"
            f" {len(start)}; remove the noise from the map"
        )
    end = start + _DX[direction] + columns * _DY[direction]
    right, left = (direction - 1) % 4, (direction + 1) % 4
    turn = np.where(has[right, end], right, left)
    turn = np.where(has[direction, end] & ~has[right, end], direction, turn)
    number = np.full(has.shape, -1)
    number[direction, start] = np.arange(len(start))
    after = number[turn, end].tolist()
    seen = bytearray(len(after))
    for first in range(len(after)):
        if seen[first]:
            continue
        sides = []
        side = first
        while not seen[side]:
            seen[side] = 1
            sides.append(side)
            side = after[side]
        chain = np.array(sides)
        ways, starts = direction[chain], start[chain]
        corners = ways != np.roll(ways, 1)
        y, x = np.divmod(starts, columns)
        dx, dy = _LEFT[ways[0]]
        yield (
            np.column_stack([x, y])[corners].astype(float),
            (int(y[0]) + dy, int(x[0]) + dx),
        )


def _smooth(ring: Array) -> tuple[Array, Array]:
    """Returns a ring (k, 2) of sides along the grid without its stairs.

    The second result is the positions (n,) of its points along the ring: a
    corner is at its number, a point on the side after it between this and the
    next one.
    """
    ahead = np.roll(ring, -1, axis=0) - ring
    before = np.roll(ahead, 1, axis=0)
    convex = before[:, 0] * ahead[:, 1] - before[:, 1] * ahead[:, 0] > 0
    step = (np.abs(ahead).sum(axis=1) == 1) & (convex != np.roll(convex, -1))
    part = np.where(convex, _CUT, 1 - _CUT)
    points = np.stack([ring, ring + part[:, None] * ahead], axis=1)
    number = np.arange(len(ring))
    places = np.stack([number, number + part], axis=1)
    kept = np.stack([~step & ~np.roll(step, 1), step], axis=1)
    return points[kept], places[kept]


def _straight(ring: Array) -> Array:
    """Returns a ring (k, 2) of sides along the grid with few corners.

    From one point of the smooth ring, it goes straight to the farthest one for
    which no corner of the ring is too far aside; and so on.
    """
    points, places = _smooth(ring)
    # A corner that stays is a good start.
    first = int(np.argmax(places == places.round()))
    points = np.roll(points, -first, axis=0)
    places = np.roll(places, -first)
    places = np.where(places < places[0], places + len(ring), places)
    points = np.vstack([points, points[:1]])
    places = np.append(places, places[0] + len(ring))
    corners = np.vstack([ring, ring, ring])

    def is_near(i: int, j: int) -> bool:
        along = points[j] - points[i]
        length = float(np.hypot(*along))
        low, high = math.floor(places[i]) + 1, math.ceil(places[j])
        between = corners[low:high] - points[i]
        if length == 0:
            return False
        # Their distances to the right, where it is free.
        right = (between[:, 0] * along[1] - between[:, 1] * along[0]) / length
        ahead = (between * along).sum(axis=1) / length
        return bool(
            (right <= _LOST).all()
            and (right >= -_GAINED).all()
            and (ahead >= -1).all()
            and (ahead <= length + 1).all()
        )

    kept = [0]
    last = len(points) - 1
    while kept[-1] < last:
        i = kept[-1]
        # The next point is always near enough.
        good, stride = i + 1, 2
        while good < last and stride:
            j = min(good + stride, last)
            if is_near(i, j):
                good, stride = j, 2 * stride
            else:
                stride //= 2
        kept.append(good)
    return points[kept[:-1]]


def _polygons(rings: list[Array]) -> list[shapely.Polygon]:
    """Returns the polygons of one solid, given its rings."""
    outer = next(i for i, ring in enumerate(rings) if _area(ring) > 0)
    rings = [rings[outer], *rings[:outer], *rings[outer + 1 :]]
    # Rings that are too small to be straightened stay as they are.
    outlines = [
        line if len(line := _straight(ring)) > 2 else ring for ring in rings
    ]
    polygon = shapely.Polygon(outlines[0], outlines[1:])
    if not polygon.is_valid:
        # Where walls nearly touch, straight ones may overlap.
        polygon = shapely.make_valid(
            polygon, method="structure", keep_collapsed=False
        )
    parts = shapely.get_parts(shapely.simplify(polygon, _STRAIGHT))
    return [part for part in parts if part.geom_type == "Polygon"]


def _area(ring: Array) -> float:
    x, y = ring.T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def without_holes(polygon: shapely.Polygon) -> Iterator[Array]:
    """Yields pieces of a polygon without holes, counter-clockwise."""
    todo = [polygon]
    while todo:
        part = todo.pop()
        if part.geom_type != "Polygon" or part.area <= 0:
            continue
        if not part.interiors:
            ring = shapely.get_coordinates(part.exterior)[:-1]
            yield ring if part.exterior.is_ccw else ring[::-1]
            continue
        todo.extend(_halves(part))


def _halves(polygon: shapely.Polygon) -> NDArray[np.object_]:
    """Cuts a polygon straight through its largest hole.

    It cuts along x or y through the center of the hole, where the cut within
    the polygon is shorter.
    """
    hole = max(polygon.interiors, key=lambda it: shapely.Polygon(it).area)
    x0, y0, x1, y1 = hole.bounds
    left, low, right, high = polygon.bounds
    x, y = (x0 + x1) / 2, (y0 + y1) / 2
    lines = shapely.linestrings(
        [[[x, low - 1], [x, high + 1]], [[left - 1, y], [right + 1, y]]]
    )
    across = shapely.length(shapely.intersection(lines, polygon))
    if across[0] <= across[1]:
        sides = [
            shapely.box(left - 1, low - 1, x, high + 1),
            shapely.box(x, low - 1, right + 1, high + 1),
        ]
    else:
        sides = [
            shapely.box(left - 1, low - 1, right + 1, y),
            shapely.box(left - 1, y, right + 1, high + 1),
        ]
    halves: NDArray[np.object_] = shapely.get_parts(
        shapely.intersection(polygon, sides)
    )
    return halves
