"""Makes walls of the dark cells of a background."""

from typing import Any

import shapely

from hunav_drake.editor.background import Background, BackgroundError
from hunav_drake.systems.world.maps.outlines import outlines
from hunav_drake.systems.world.solids import turned

# How far corners may be from the outlines of cells, in cells: first the usual
# distance, then less, if that is too coarse, then more, for too many corners.
_TOLERANCES = (1.0, 0.5, 0.25, 2.0, 4.0, 8.0)

# The smallest wall, in cells.
_MIN_AREA = 2.0

# More walls than these are no plan of a building, but noise.
_MAX_WALLS = 2000
_MAX_POINTS = 1000


def traced_walls(background: Background) -> list[dict[str, Any]]:
    """Returns polygons around the dark cells, as walls in plain data.

    Their corners are those of the outlines (see `maps/outlines.py`), without
    those that are nearer than one cell to the line of the others (Douglas and
    Peucker 1973). Specks of less than two cells are left out.

    Raises:
        BackgroundError: If there is nothing dark, or too much.
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
        raise BackgroundError(
            f"{background.name} has no dark places to make walls of"
        )
    if len(walls) > _MAX_WALLS:
        raise BackgroundError(
            f"{background.name} would give {len(walls)} walls, more than"
            f" {_MAX_WALLS}; clean the image of its specks first"
        )
    return walls


def _simplified(outline: Any) -> Any:
    """Returns few corners of an outline in cells; None for a speck."""
    whole = shapely.Polygon(outline)
    if whole.area < _MIN_AREA:
        return None
    for tolerance in _TOLERANCES:
        simple = whole.simplify(tolerance)
        if isinstance(simple, shapely.Polygon) and simple.is_valid:
            corners = shapely.get_coordinates(simple.exterior)[:-1]
            if 3 <= len(corners) <= _MAX_POINTS and simple.area > 0:
                return corners
    return outline if len(outline) <= _MAX_POINTS else None
