"""Texts as flat meshes, so that viewers, films and cameras can read them."""

import functools
import math

import numpy as np
import shapely

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.scene.meshes import TriangleMesh
from hunav_drake.systems.world.solids import Lettering, turned

# How far a text is in front of what it is on, in meters, and how far curves may
# be off, in the height of a line.
_FRONT, _ROUGH = 0.004, 0.01

# Texts are drawn in this size first: to it, curves are smooth.
_DRAWN = 100.0


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
    triangles = shapely.get_parts(
        shapely.constrained_delaunay_triangles(shapes)
    )
    # Each repeats its first corner at the end, and all are clockwise.
    corners = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, 2::-1]
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


def _outlines(text: str) -> Array:
    """Returns the outlines of a text's lines, which are centered."""
    # Imported here, as most scenes do without.
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    font = FontProperties(family="DejaVu Sans", weight="bold")
    found = []
    for k, line in enumerate(text.strip().split("\n")):
        # (Matplotlib draws no path without letters.)
        if not line.strip():
            continue
        # (A dollar sign is no formula.)
        shown = line.replace("$", r"\$")
        path = TextPath((0, 0), shown, size=_DRAWN, prop=font)
        rings = [
            shapely.Polygon(it)
            for it in path.to_polygons(closed_only=True)
            if len(it) > 3
        ]
        if not rings:
            continue
        # Of an outline in another one, the inside is outside.
        area = functools.reduce(shapely.symmetric_difference, rings)
        area = shapely.simplify(area, _ROUGH * _DRAWN)
        x0, _, x1, _ = area.bounds
        found.append(
            shapely.transform(
                area, lambda p, x=(x0 + x1) / 2, k=k: p - [x, 1.3 * _DRAWN * k]
            )
        )
    return np.array(found)
