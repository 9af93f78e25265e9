"""The outlines of all that stands in a world, as the map draws them."""

from collections.abc import Iterator
from typing import Any

from pydantic import ValidationError

from hunav_drake.scenario.error import Loc, child
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.world.furniture import FURNITURE
from hunav_drake.systems.world.shapes import WALLS

Outline = dict[str, Any]

_LISTS: dict[str, Registry] = {"walls": WALLS, "furniture": FURNITURE}


class Outlines:
    """Makes outlines, and keeps those of parts that stay the same."""

    def __init__(self) -> None:
        """Starts without any."""
        # By the identity of the data, which are kept so that it stays.
        self._known: dict[int, tuple[Any, list[Outline]]] = {}

    def of(self, world: Any) -> dict[str, Outline]:
        """Returns the outlines of a world, given as plain data, by path.

        What does not fit the schema has none. Where a part has several, their
        paths go on with a number: "world/furniture/3/1".
        """
        kept, result = {}, {}
        for loc, registry, data in _members(world):
            known = self._known.get(id(data))
            if known is None:
                known = data, _outlines(registry, data)
            kept[id(data)] = known
            path = "/".join(map(str, loc))
            for i, outline in enumerate(known[1]):
                result[f"{path}/{i}" if i else path] = outline
        self._known = kept
        return result


def _members(world: Any) -> Iterator[tuple[Loc, Registry, Any]]:
    for key, registry in _LISTS.items():
        members = child(world, key)
        for i, data in enumerate(members if isinstance(members, list) else []):
            yield ("world", key, i), registry, data


def _outlines(registry: Registry, data: Any) -> list[Outline]:
    try:
        part = registry.make(data)
    except ValidationError:
        return []
    kind = data if isinstance(data, str) else data[registry.tag]
    if registry is WALLS:
        shapes, closed = [part.vertices()], part.solid
    else:
        shapes, closed = part.footprints(), True
    return [
        {
            "points": shape.round(4).tolist(),
            "closed": closed,
            "kind": kind,
            "height": part.height,
        }
        for shape in shapes
    ]
