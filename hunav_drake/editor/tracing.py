"""Converts the dark cells of a background to walls."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import shapely

from hunav_drake.editor.background import Background, BackgroundError
from hunav_drake.systems.world.maps.outlines import outlines
from hunav_drake.systems.world.solids import turned

# The tolerances of simplification, in cells: first the usual one, then smaller
# ones, if that is too coarse.
_TOLERANCES = (1.0, 0.5, 0.25)

# How much of its area a wall may win or lose by that.
_CHANGE = 0.2

# The smallest wall, in cells.
_MIN_AREA = 2.0

# Dark cells that are this near to a wall, in cells, are traced.
_NEAR = 2.0

# With more walls, the image is probably noise.
_MAX_WALLS = 2000


def traced_walls(background: Background) -> list[dict[str, Any]]:
    """Returns polygons around the dark cells, as walls in plain data.

    Their corners are those of the outlines (see `maps/outlines.py`), without
    those that are within one cell of the line through the others (Douglas and
    Peucker 1973). Specks of less than two cells are left out.

    Raises:
        BackgroundError: If there are no dark cells, or too many walls.
    """
    try:
        found = outlines(background.occupied)
    except ValueError as error:
        raise BackgroundError(f"{background.name}: {error}") from error
    walls = []
    for outline in found:
        if (corners := _simplified(outline)) is None:
            continue
        points = turned(corners * background.cell, background.origin)
        walls.append({"type": "polygon", "points": points.round(3).tolist()})
    if not walls:
        raise BackgroundError(f"{background.name} has no dark areas for walls")
    if len(walls) > _MAX_WALLS:
        raise BackgroundError(
            f"{background.name} would give {len(walls)} walls, more than"
            f" {_MAX_WALLS}; remove specks from the image first"
        )
    return walls


def is_traced(background: Background, outlines: Iterable[Any]) -> bool:
    """Returns whether walls are at most of the dark cells of a background.

    Args:
        background: The background; without dark cells, it is traced.
        outlines: Of all walls, points (x, y) in W, in meters.
    """
    if not len(background.sample):
        return True
    places = turned(background.sample * background.cell, background.origin)
    shapes = [
        (shapely.Polygon if len(points) > 2 else shapely.LineString)(points)
        for points in outlines
    ]
    reach = _NEAR * background.cell
    at, _ = shapely.STRtree(shapes).query(
        shapely.points(places), predicate="dwithin", distance=reach
    )
    return len(np.unique(at)) > len(places) / 2


def _simplified(outline: Any) -> Any:
    """Returns a simplified outline, in cells; None for a speck."""
    whole = shapely.Polygon(outline)
    if whole.area < _MIN_AREA:
        return None
    for tolerance in _TOLERANCES:
        simple = whole.simplify(tolerance)
        if isinstance(simple, shapely.Polygon) and simple.is_valid:
            corners = shapely.get_coordinates(simple.exterior)[:-1]
            # A thin wall must not lose its thickness.
            kept = abs(simple.area - whole.area) < _CHANGE * whole.area
            if len(corners) >= 3 and kept:
                return corners
    return outline
