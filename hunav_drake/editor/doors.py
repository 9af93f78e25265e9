"""Cuts doors into the walls of a scenario."""

from collections.abc import Iterator, Sequence
import math
from typing import Any, NamedTuple

import numpy as np
from pydantic import ValidationError
import shapely

from hunav_drake.editor.document.plain_data import OperationError, get
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.choice_loading import registered_only
from hunav_drake.systems.world.maps.outlines import without_holes
from hunav_drake.systems.world.shapes import WALLS, Box, Disc
from hunav_drake.systems.world.solids import turned

# The width of a door, and the least wall on each side of it, in meters.
DOOR = 0.9
_JAMB = 0.1

# Walls with less room between them are one wall, and the thickest one that a
# door is cut into, in meters.
_GAP = 0.35
_THICKEST = 0.8

# The free floor before and behind a door, in meters.
_BEFORE = 0.4

# How far a door may be from the click, and the step of the search, in meters.
_FARTHEST = 1.2
_STEP = 0.05

# A shorter piece of a wall, in meters, is left out, and walls that only touch
# an opening are not cut.
_LEAST_LENGTH = 0.02
_TOUCH = 0.005


class _Wall(NamedTuple):
    """A wall: its number in the list, its data and its footprint."""

    number: int
    data: dict[str, Any]
    made: Any
    shape: Any


def door_operations(
    data: Any, place: Sequence[float], reach: float
) -> list[tuple[Any, ...]]:
    """Returns the operations that cut a door into all walls at a place.

    The door is as near to the place as there is wall on both of its sides, and
    free floor before and behind it.

    Args:
        data: The scenario as plain data.
        place: The place (x, y) in W, in meters.
        reach: How far the nearest wall may be, in meters.

    Raises:
        OperationError: If there is no wall, or no room for a door.
    """
    walls = list(_walls(data))
    point = shapely.Point(place)
    near = min(walls, key=lambda it: it.shape.distance(point), default=None)
    where = f"({place[0]:.2f}, {place[1]:.2f})"
    if near is None or near.shape.distance(point) > reach:
        raise OperationError(
            f"there is no wall at {where}; click a wall. Those of a picture or"
            " a map are walls once they are traced"
        )
    opening = _opening(walls, near, point)
    if opening is None:
        raise OperationError(
            f"the wall at {where} has no room for a door: it takes"
            f" {DOOR + 2 * _JAMB:.1f} m of straight wall, at most"
            f" {_THICKEST:g} m thick, and free floor on both sides; click"
            " another place"
        )
    names = {str(it.data.get("name", "")) for it in walls}
    operations: list[tuple[Any, ...]] = []
    for wall in reversed(walls):
        if _share(wall.shape, opening) <= 0:
            continue
        path = ["world", "walls", wall.number]
        pieces = list(_pieces(wall, opening))
        if not pieces:
            operations.append(("remove", path))
        for k, piece in enumerate(pieces):
            if k and piece.get("name"):
                piece["name"] = _free_name(piece["name"], names)
            here = [*path[:2], wall.number + k]
            operations.append(("insert" if k else "set", here, piece))
    return operations


def _walls(data: Any) -> Iterator[_Wall]:
    listed = get(data, ("world", "walls"))
    for i, part in enumerate(listed if isinstance(listed, list) else []):
        try:
            with registered_only():
                wall = WALLS.make(part)
            points = wall.vertices()
            kind = shapely.Polygon if wall.solid else shapely.LineString
            shape = kind(points)
        except (ValidationError, ValueError):
            continue
        if shape.is_valid:
            yield _Wall(i, part, wall, shape)


def _opening(walls: list[_Wall], near: _Wall, point: Any) -> Any:
    """Returns the rectangle of a door, or None if there is no room."""
    around = point.buffer(_FARTHEST + 2 * _THICKEST + DOOR)
    shapes = [it.shape for it in walls if it.shape.intersects(around)]
    solid = shapely.union_all([it.buffer(1e-3) for it in shapes])
    round_ones = shapely.union_all(
        [it.shape for it in walls if isinstance(it.made, Disc)]
    )
    along = _direction(near.shape, point)
    foot = shapely.shortest_line(near.shape, point)
    start = shapely.get_coordinates(foot)[0]
    frame = math.atan2(along[1], along[0])
    for k in range(round(_FARTHEST / _STEP) + 1):
        for sign in (1, -1)[: 2 if k else 1]:
            x, y = (start + sign * k * _STEP * along).tolist()
            span = _span(solid, (x, y, frame))
            if span is None:
                continue
            door = _rectangle((x, y, frame), DOOR / 2, *span)
            if not door.intersects(round_ones):
                return door
    return None


def _direction(shape: Any, point: Any) -> Array:
    """Returns the unit vector along the longest side near a point."""
    lines = shape.boundary if shape.geom_type == "Polygon" else shape
    points = shapely.get_coordinates(lines)
    sides = shapely.linestrings(np.stack([points[:-1], points[1:]], axis=1))
    away = shapely.distance(sides, point)
    lengths = np.where(away <= away.min() + _GAP, shapely.length(sides), 0.0)
    best = int(lengths.argmax())
    way = points[best + 1] - points[best]
    return np.asarray(way / np.hypot(*way))


def _rectangle(
    pose: tuple[float, float, float], half: float, low: float, high: float
) -> Any:
    corners = [(-half, low), (half, low), (half, high), (-half, high)]
    return shapely.Polygon(turned(np.array(corners), pose))


def _span(
    solid: Any, pose: tuple[float, float, float]
) -> tuple[float, float] | None:
    """Returns from where to where a door cuts, across the wall.

    It is None if there is no wall to cut on its whole width, no wall on both
    sides, or another wall before it.
    """
    reach = _THICKEST + _GAP
    low, high = 0.0, 0.0
    half = DOOR / 2
    for x in (-half - _JAMB, -half + 0.01, 0.0, half - 0.01, half + _JAMB):
        ends = turned(np.array([(x, -reach), (x, reach)]), pose)
        cut = shapely.intersection(shapely.LineString(ends), solid)
        first = shapely.Point(ends[0])
        stretches = sorted(
            (first.distance(shapely.Point(a)) - reach, it.length)
            for it in shapely.get_parts(cut)
            if not it.is_empty
            for a in [min(it.coords, key=lambda c: math.dist(c, ends[0]))]
        )
        merged: list[list[float]] = []
        for begin, length in stretches:
            if merged and begin - merged[-1][1] < _GAP:
                merged[-1][1] = begin + length
            else:
                merged.append([begin, begin + length])
        mine = [it for it in merged if it[0] < _GAP and it[1] > -_GAP]
        if not mine:
            return None
        low = min(low, *(it[0] for it in mine))
        high = max(high, *(it[1] for it in mine))
    if high - low > _THICKEST:
        return None
    low, high = low - _TOUCH, high + _TOUCH
    for side in ((high, high + _BEFORE), (low - _BEFORE, low)):
        if _rectangle(pose, half - 0.01, *side).intersects(solid):
            return None
    return low, high


def _share(shape: Any, opening: Any) -> float:
    """Returns how much of a wall is in an opening, in m^2 or m."""
    inside = shapely.intersection(shape, opening)
    if shape.geom_type == "LineString":
        return float(inside.length)
    return float(inside.area) if _longest(inside) > _LEAST_LENGTH else 0.0


def _longest(shape: Any) -> float:
    """Returns the length of the diagonal of a shape's box, in meters."""
    low_x, low_y, high_x, high_y = shape.bounds
    return math.hypot(high_x - low_x, high_y - low_y)


def _pieces(wall: _Wall, opening: Any) -> Iterator[dict[str, Any]]:
    """Yields what is left of a wall, as data."""
    for rest in shapely.get_parts(shapely.difference(wall.shape, opening)):
        if rest.geom_type == "LineString":
            if rest.length > _LEAST_LENGTH:
                yield {**wall.data, "points": _rounded(rest)}
        elif rest.is_empty or _longest(rest) <= _LEAST_LENGTH:
            continue
        elif isinstance(wall.made, Box) and (box := _box(wall.made, rest)):
            yield {**wall.data, **box}
        else:
            kept = {
                key: it
                for key, it in wall.data.items()
                if key not in ("type", "center", "size", "yaw", "points")
            }
            for polygon in without_holes(rest):
                ring = shapely.Polygon(polygon).exterior
                points = _rounded(ring)[:-1]
                yield {"type": "polygon", **kept, "points": points}


def _box(wall: Box, rest: Any) -> dict[str, Any] | None:
    """Returns center and size of a rectangle in the frame of a wall."""
    x, y = wall.center
    moved = shapely.get_coordinates(rest) - (x, y)
    local = turned(moved, (0.0, 0.0, -wall.yaw))
    low, high = local.min(axis=0), local.max(axis=0)
    if not math.isclose(np.prod(high - low), rest.area, rel_tol=1e-3):
        return None
    middle = turned(((low + high) / 2)[None], (x, y, wall.yaw))[0]
    return {
        "center": middle.round(3).tolist(),
        "size": (high - low).round(3).tolist(),
    }


def _rounded(line: Any) -> list[list[float]]:
    points: list[list[float]]
    points = shapely.get_coordinates(line).round(3).tolist()
    return points


def _free_name(name: str, taken: set[str]) -> str:
    """Returns a name with a free number at its end, and takes it."""
    stem, _, number = name.rpartition("_")
    stem = stem if number.isdigit() and stem else name
    count = next(
        n for n in range(2, len(taken) + 3) if f"{stem}_{n}" not in taken
    )
    taken.add(f"{stem}_{count}")
    return f"{stem}_{count}"
