"""The outlines of the objects in a world, for the map."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import TypeAdapter, ValidationError
import shapely

from hunav_drake.editor.document.plain_data import get
from hunav_drake.scenario.error import Loc
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.choice_loading import registered_only
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.common.schema import Pose
from hunav_drake.systems.people.area import Area
from hunav_drake.systems.world.furniture import FURNITURE, Furniture
from hunav_drake.systems.world.shapes import WALL_HEIGHT, WALLS
from hunav_drake.systems.world.solids import turned

Outline = dict[str, Any]

_AREA: TypeAdapter[Area] = TypeAdapter(Area)
_POSE: TypeAdapter[tuple[float, float, float]] = TypeAdapter(Pose)
_NONE: Mapping[str, Sequence[ArrayLike]] = MappingProxyType({})


class Outlines:
    """Computes outlines, and caches those of unchanged parts."""

    def __init__(self) -> None:
        """Starts with an empty cache."""
        # By the id of the data, which are kept so that the id stays valid.
        self._known: dict[int, tuple[Any, list[Outline]]] = {}

    def of(
        self,
        data: Any,
        map_outlines: Sequence[Array] = (),
        models: Mapping[str, Sequence[ArrayLike]] = _NONE,
    ) -> dict[str, Outline]:
        """Returns the outlines of a world, by path: "world/walls/3".

        Invalid parts have none. If a part has several, the paths of the others
        have a number at the end: "world/map/1".

        Args:
            data: The scenario as plain data.
            map_outlines: The walls of its map, each (k, 2) in W, in meters.
            models: The outlines of models by file, each (k, 2) in the frame of
                the model, in meters.
        """
        kept: dict[int, tuple[Any, list[Outline]]] = {}
        result: dict[str, Outline] = {}
        for loc, maker, part in _members(data):
            known = self._known.get(id(part))
            if known is None:
                # A wall type of the user must not run code here.
                with registered_only():
                    known = part, maker(part)
            kept[id(part)] = known
            _put(result, loc, known[1])
        walls = [_outline(it, "map", WALL_HEIGHT) for it in map_outlines]
        _put(result, ("world", "map"), walls)
        for i, part in _list(data, ("world", "models")):
            _put(result, ("world", "models", i), _model(part, models))
        self._known = kept
        return result


def _put(
    result: dict[str, Outline], loc: Loc, outlines: Sequence[Outline]
) -> None:
    """Adds the outlines of a part to the result."""
    path = "/".join(map(str, loc))
    for i, outline in enumerate(outlines):
        result[f"{path}/{i}" if i else path] = outline


def _outline(
    points: Array, kind: str, height: float, *, closed: bool = True
) -> Outline:
    return {
        "points": points.round(4).tolist(),
        "closed": closed,
        "kind": kind,
        "height": height,
    }


def _members(
    data: Any,
) -> Iterator[tuple[Loc, Callable[[Any], list[Outline]], Any]]:
    """Yields the path, the outline function and the data of each part."""
    for key, maker in (("walls", _wall), ("furniture", _furniture)):
        for i, part in _list(data, ("world", key)):
            yield ("world", key, i), maker, part
    for key in ("cohorts", "sources"):
        for i, _ in _list(data, ("population", key)):
            loc: Loc = ("population", key, i, "start")
            for k, part in _list(data, loc):
                yield (*loc, k), _area, part
    for i, sink in _list(data, ("population", "sinks")):
        if isinstance(sink, dict) and "area" in sink:
            yield ("population", "sinks", i, "area"), _area, sink["area"]


def _list(data: Any, loc: Loc) -> list[tuple[int, Any]]:
    items = get(data, loc)
    return list(enumerate(items)) if isinstance(items, list) else []


def _wall(data: Any) -> list[Outline]:
    try:
        wall = WALLS.make(data)
    except ValidationError:
        return []
    kind = name_of(wall)
    points, height = wall.vertices(), wall.height
    return [_outline(points, kind, height, closed=wall.solid)]


def _furniture(data: Any) -> list[Outline]:
    try:
        part = FURNITURE.make(data)
    except ValidationError:
        return []
    kind, height = name_of(part), part.height
    # (What hangs, and nobody walks around, is drawn, too.)
    whole = turned(Furniture.outlines(part)[0], (*part.center, part.yaw))
    outlines = part.footprints() or [whole]
    result = [_outline(points, kind, height) for points in outlines]
    for first in result[:1]:
        first["pieces"] = _from_above(part)
    return result


def _from_above(part: Furniture) -> list[list[Any]]:
    """Returns what is seen of furniture from above: materials and outlines.

    They are in the order in which they are drawn, from the lowest one up.
    """
    solids = sorted(part.solids(), key=lambda it: it.high)
    shapes = [shapely.Polygon(it.outline) for it in solids]
    return [
        [it.material, it.outline.round(3).tolist()]
        for i, it in enumerate(solids)
        if not any(over.covers(shapes[i]) for over in shapes[i + 1 :])
    ]


def pictures() -> list[dict[str, Any]]:
    """Returns all kinds of furniture at their usual size, seen from above."""
    return [
        {"type": kind, **picture}
        for kind in FURNITURE
        for picture in _furniture({"type": kind, "center": [0.0, 0.0]})[:1]
    ]


def _model(
    data: Any, models: Mapping[str, Sequence[ArrayLike]]
) -> list[Outline]:
    name = get(data, ("file",))
    try:
        pose = _POSE.validate_python(get(data, ("pose",), (0.0, 0.0, 0.0)))
    except ValidationError:
        return []
    return [
        _outline(turned(points, pose), "model", WALL_HEIGHT)
        for points in (models.get(name, ()) if isinstance(name, str) else ())
    ]


def _area(data: Any) -> list[Outline]:
    try:
        area = _AREA.validate_python(data)
    except ValidationError:
        return []
    points = np.asarray(area.vertices(), dtype=float)
    return [_outline(points, "area", 0.0, closed=len(points) > 2)]
