"""Texts as flat meshes, so that viewers, films and cameras can read them."""

from collections.abc import Iterator
import functools
import math

import numpy as np
import shapely

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.scene.meshes import TriangleMesh, triangles_of
from hunav_drake.systems.world.solids import Lettering, turned

# How far a text is in front of what it is on, in meters; the height of a line,
# in that of the font; and how far curves may be off, in hundredths of it.
_FRONT, _LINE, _ROUGH = 0.004, 1.3, 1.0


def lettering_mesh(letters: Lettering) -> TriangleMesh:
    """Returns a text in W, as large as there is room for it.

    A text of spaces has no triangles.
    """
    shapes = _outlines(letters.text)
    if not len(shapes):
        return TriangleMesh(
            np.empty((0, 3)), np.empty((0, 3)), np.empty((0, 3), dtype=int)
        )
    x0, y0, x1, y1 = shapely.total_bounds(shapes)
    scale = min(np.array(letters.size) / np.maximum((x1 - x0, y1 - y0), 1e-9))
    corners = triangles_of(shapes)
    right, up = (corners.reshape(-1, 2) - [(x0 + x1) / 2, (y0 + y1) / 2]).T
    # (Who reads it looks along -x of its frame, so that +y is to the right.)
    flat = np.column_stack([np.full(len(right), _FRONT), scale * right])
    yaw = letters.pose[2]
    return TriangleMesh(
        np.column_stack(
            [turned(flat, letters.pose), letters.middle + scale * up]
        ),
        np.tile([math.cos(yaw), math.sin(yaw), 0.0], (len(flat), 1)),
        np.arange(len(flat)).reshape(-1, 3),
    )


@functools.lru_cache(maxsize=64)
def _outlines(text: str) -> Array:
    """Returns the outlines of a text's lines, which are centered."""
    # Imported here, as most scenes do without.
    from matplotlib.font_manager import FontProperties
    from matplotlib.path import Path
    from matplotlib.textpath import text_to_path

    font = FontProperties(family="DejaVu Sans", weight="bold")
    found: list[shapely.Geometry] = []
    for k, line in enumerate(text.strip().split("\n")):
        points, codes = text_to_path.get_text_path(font, line)
        if not len(points):
            continue
        rings = [
            shapely.Polygon(it)
            for it in Path(points, codes).to_polygons(closed_only=True)
            if len(it) > 3
        ]
        glyphs = [_filled(it) for it in _overlapping(rings)]
        x0, _, x1, _ = shapely.total_bounds(glyphs)
        offset = np.array([(x0 + x1) / 2, _LINE * text_to_path.FONT_SCALE * k])
        found += [
            shapely.transform(it, lambda p, offset=offset: p - offset)
            for it in glyphs
        ]
    return np.array(found)


def _overlapping(
    rings: list[shapely.Polygon],
) -> Iterator[list[shapely.Polygon]]:
    """Yields the rings of letters, those that overlap along a line together."""
    own: list[shapely.Polygon] = []
    end = -math.inf
    for ring in sorted(rings, key=lambda it: it.bounds[0]):
        if own and ring.bounds[0] > end:
            yield own
            own = []
        own.append(ring)
        end = max(end, ring.bounds[2])
    if own:
        yield own


def _filled(rings: list[shapely.Polygon]) -> shapely.Geometry:
    """Returns the area of outer rings without that of the rings of holes."""
    area: shapely.Geometry = shapely.Polygon()
    for ring in sorted(rings, key=lambda it: -it.area):
        # (In fonts, outer outlines are clockwise.)
        is_hole = ring.exterior.is_ccw
        ring = ring.buffer(0)
        area = area.difference(ring) if is_hole else area.union(ring)
    return shapely.simplify(area, _ROUGH)
