"""Finds the nearest free place."""

from collections.abc import Iterable, Mapping
from functools import cached_property
import math
from typing import Any

import numpy as np
import shapely

from hunav_drake.editor.document.plain_data import get
from hunav_drake.scenario.error import Loc

# The range and the step of the search, in meters, and its directions.
_FARTHEST = 6.0
_STEP = 0.1
_DIRECTIONS = 16

# The clearance around a body, in meters.
_MARGIN = 1e-3

# The default radius of a body, in meters.
_RADIUS = 0.35


class FreePlaces:
    """Finds places outside the outlines of a world."""

    def __init__(self, outlines: Mapping[str, Mapping[str, Any]]) -> None:
        """Constructs it for the outlines of the map: see `Outlines`."""
        self._outlines = [it for it in outlines.values() if it["height"] > 0]

    @cached_property
    def _tree(self) -> shapely.STRtree:
        return shapely.STRtree(
            [
                (shapely.Polygon if it["closed"] else shapely.LineString)(
                    it["points"]
                )
                for it in self._outlines
            ]
        )

    def near(
        self,
        place: tuple[float, float],
        radius: float,
        first: tuple[float, float] | None = None,
    ) -> tuple[float, float] | None:
        """Returns the nearest free place for a disc.

        Args:
            place: The center of the search, in meters.
            radius: The radius of the disc, in meters.
            first: A place that is preferred if it is free.

        Returns:
            The place in whole millimeters; None if there is none within 6 m.
        """
        if first is not None and self._are_free([first], radius)[0]:
            return first
        distances = np.arange(_STEP, _FARTHEST, _STEP)
        angles = np.arange(_DIRECTIONS) * (2 * math.pi / _DIRECTIONS)
        ring = np.column_stack([np.cos(angles), np.sin(angles)])
        around = (distances[:, None, None] * ring).reshape(-1, 2)
        candidates = np.round(np.array(place) + around, 3)
        found = np.flatnonzero(self._are_free(candidates, radius))
        if not len(found):
            return None
        x, y = candidates[found[0]].tolist()
        return x, y

    def _are_free(self, places: Any, radius: float) -> Any:
        points = shapely.points(np.asarray(places, dtype=float))
        taken, _ = self._tree.query(
            points, predicate="dwithin", distance=radius + _MARGIN
        )
        free = np.ones(len(points), dtype=bool)
        free[taken] = False
        return free


def radius_at(loc: Loc, data: Any) -> float:
    """Returns the radius of a body by its path, in meters; 0 for a goal."""
    if len(loc) > 2 and loc[2] == "goals":
        return 0.0
    depth = {"humans": 2, "robots": 3}.get(str(loc[0]), 1)
    holder: Iterable[Any] = loc[:depth]
    radius = get(data, (*holder, "radius"))
    is_number = type(radius) in (int, float) and 0 < radius < 100
    return float(radius) if is_number else _RADIUS
