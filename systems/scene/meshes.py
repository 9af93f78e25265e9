"""Procedural triangle meshes: lofts, ellipsoids, prisms, flat tiles.

Primitive shapes alone make stick figures; a few lofted sections make a torso, a
thigh or a shoe. The meshes are plain arrays, which can be tested and joined
without Drake, and are converted to OBJ text at the end.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
import shapely

from hunav_drake.systems.common.arrays import Array


@dataclass(frozen=True)
class TriangleMesh:
    """A surface of triangles, counterclockwise seen from outside.

    Attributes:
        vertices: Shape (v, 3), in meters.
        normals: Shape (v, 3): the unit normals for shading.
        faces: Shape (f, 3): indices into the vertices.
    """

    vertices: Array
    normals: Array
    faces: NDArray[np.int64]

    def moved(self, offset: ArrayLike, pitch: float = 0.0) -> "TriangleMesh":
        """Returns the mesh rotated about +y by `pitch` radians, then moved."""
        c, s = np.cos(pitch), np.sin(pitch)
        rotation = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
        return TriangleMesh(
            self.vertices @ rotation.T + np.asarray(offset, dtype=float),
            self.normals @ rotation.T,
            self.faces,
        )

    def to_obj(self) -> str:
        """Returns the mesh as Wavefront OBJ text without duplicate rows."""
        v, corner = _unique(self.vertices.round(4))
        n, normal = _unique(self.normals.round(2))
        names = [
            f"{a + 1}//{b + 1}" for a, b in zip(corner, normal, strict=True)
        ]
        # (Short numbers keep replays small.)
        lines = [f"v {x:z.10g} {y:z.10g} {z:z.10g}" for x, y, z in v.tolist()]
        lines += [f"vn {x:z.10g} {y:z.10g} {z:z.10g}" for x, y, z in n.tolist()]
        lines += [
            f"f {names[a]} {names[b]} {names[c]}"
            for a, b, c in self.faces.tolist()
        ]
        return "\n".join(lines) + "\n"


def join(meshes: Sequence[TriangleMesh]) -> TriangleMesh:
    """Returns several meshes as one."""
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes[:-1])])
    return TriangleMesh(
        np.vstack([m.vertices for m in meshes]),
        np.vstack([m.normals for m in meshes]),
        np.vstack([m.faces + k for m, k in zip(meshes, starts, strict=True)]),
    )


def loft(
    sections: ArrayLike, *, sides: int = 16, power: float = 2.0
) -> TriangleMesh:
    """Returns a smooth closed surface through horizontal sections.

    They have shape (k, 5), from the lowest to the highest: the center (x, y, z)
    and the half widths along x and y of each, in meters. A section has `sides`
    corners; power 2 gives ellipses, more gives rounded rectangles (Lamé curves,
    |x/a|^p + |y/b|^p = 1).
    """
    rows = np.asarray(sections, dtype=float)
    angle = np.arange(sides) * (2 * np.pi / sides)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    ring = np.sign(circle) * np.abs(circle) ** (2 / power)
    rings = np.empty((len(rows), sides, 3))
    rings[:, :, :2] = rows[:, None, :2] + ring * rows[:, None, 3:5]
    rings[:, :, 2] = rows[:, None, 2]
    bottom, top = rows[0, :3], rows[-1, :3]
    vertices = np.vstack([rings.reshape(-1, 3), bottom, top])

    lower = np.arange(sides)
    after = (lower + 1) % sides
    bottom_center = np.full(sides, len(vertices) - 2)
    faces = [np.column_stack([bottom_center, after, lower])]
    for k in range(len(rows) - 1):
        a, b = lower + k * sides, after + k * sides
        faces.append(np.column_stack([a, b, b + sides]))
        faces.append(np.column_stack([a, b + sides, a + sides]))
    last = (len(rows) - 1) * sides
    top_center = bottom_center + 1
    faces.append(np.column_stack([top_center, lower + last, after + last]))
    triangles = np.vstack(faces)
    return TriangleMesh(
        vertices, _smooth_normals(vertices, triangles), triangles
    )


def ellipsoid(
    center: ArrayLike, radii: ArrayLike, *, sides: int = 16
) -> TriangleMesh:
    """Returns an ellipsoid with its axes along x, y and z, in meters."""
    c = np.asarray(center, dtype=float)
    r = np.asarray(radii, dtype=float)
    polar = np.linspace(-np.pi / 2, np.pi / 2, sides // 2 + 1)[1:-1]
    rows = [
        [*c[:2], c[2] + r[2] * np.sin(a), *(r[:2] * np.cos(a))] for a in polar
    ]
    mesh = loft(rows, sides=sides)
    vertices = mesh.vertices.copy()
    pole = np.array([0.0, 0.0, r[2]])
    vertices[-2:] = c - pole, c + pole
    normals = (vertices - c) / r**2
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return TriangleMesh(vertices, normals, mesh.faces)


def extrude(outline: ArrayLike, low: float, high: float) -> TriangleMesh:
    """Returns the upright prism over a simple polygon, between two heights."""
    p = np.asarray(outline, dtype=float)
    k = len(p)
    i = np.arange(k)
    after = np.append(i[1:], 0)
    (x, y), (xq, yq) = p.T, p[after].T
    if np.sum(x * yq - xq * y) < 0:
        p = p[::-1]
    q = p[after]
    lid = triangulate(p)
    along = q - p
    length = np.sqrt((along * along).sum(axis=1))
    length[length == 0] = 1.0

    # The sides have separate corners, so that edges stay sharp.
    vertices = np.empty((6, k, 3))
    vertices[:, :, :2] = p, p, p, q, q, p
    vertices[:, :, 2] = np.array([[low, high, low, low, high, high]]).T
    normals = np.zeros((6, k, 3))
    normals[:2, :, 2] = [[-1.0], [1.0]]
    normals[2:, :, 0] = along[:, 1] / length
    normals[2:, :, 1] = -along[:, 0] / length
    faces = np.empty((2, k, 3), dtype=np.int64)
    faces[:, :, 0] = i + 2 * k
    faces[0, :, 1], faces[0, :, 2] = i + 3 * k, i + 4 * k
    faces[1, :, 1], faces[1, :, 2] = i + 4 * k, i + 5 * k
    return TriangleMesh(
        vertices.reshape(-1, 3),
        normals.reshape(-1, 3),
        np.concatenate([lid[:, ::-1], lid + k, faces.reshape(-1, 3)]),
    )


def lay(quads: ArrayLike, height: float) -> TriangleMesh:
    """Returns flat, counterclockwise quads (m, 4, 2) that face upwards."""
    p = np.asarray(quads, dtype=float).reshape(-1, 2)
    first = np.arange(0, len(p), 4)[:, None]
    return TriangleMesh(
        np.column_stack([p, np.full(len(p), height)]),
        np.tile([0.0, 0.0, 1.0], (len(p), 1)),
        np.vstack([first + np.array(half) for half in ((0, 1, 2), (0, 2, 3))]),
    )


def disc(radius: float, height: float, *, sides: int = 40) -> TriangleMesh:
    """Returns a flat disc around the z axis that faces upwards, in meters."""
    return plate(circle(radius, sides), height)


def ring(
    inner: float, outer: float, height: float, *, sides: int = 48
) -> TriangleMesh:
    """Returns a flat ring around the z axis that faces upwards, in meters."""
    a, b = circle(inner, sides), circle(outer, sides)
    quads = [a, b, np.roll(b, -1, axis=0), np.roll(a, -1, axis=0)]
    return lay(np.stack(quads, axis=1), height)


def circle(radius: float, sides: int) -> Array:
    """Returns the corners (sides, 2) of a regular polygon, from angle 0."""
    angle = np.arange(sides) * (2 * np.pi / sides)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def plate(outline: ArrayLike, height: float) -> TriangleMesh:
    """Returns a simple counterclockwise polygon (k, 2) that faces upwards."""
    p = np.asarray(outline, dtype=float)
    return TriangleMesh(
        np.column_stack([p, np.full(len(p), height)]),
        np.tile([0.0, 0.0, 1.0], (len(p), 1)),
        triangulate(p),
    )


def triangulate(outline: ArrayLike) -> NDArray[np.int64]:
    """Returns triangles that cover a simple counterclockwise polygon (k, 2).

    They are counterclockwise indices of its corners. An outline that crosses or
    repeats itself gives a fan, whose triangles may overlap.
    """
    p = np.asarray(outline, dtype=float)
    index = {tuple(corner): i for i, corner in enumerate(p.tolist())}
    polygon = shapely.polygons(p)
    if len(index) < len(p) or not polygon.is_valid:
        i = np.arange(1, len(p) - 1)
        return np.column_stack([np.zeros_like(i), i, i + 1])
    corners = triangles_of(polygon).reshape(-1, 2).tolist()
    rows = [index[tuple(it)] for it in corners]
    return np.array(rows, dtype=np.int64).reshape(-1, 3)


def triangles_of(areas: shapely.Geometry | ArrayLike) -> Array:
    """Returns counterclockwise triangles (t, 3, 2) that cover areas."""
    triangles = shapely.constrained_delaunay_triangles(areas)
    # Each repeats its first corner at the end, and all are clockwise.
    corners: Array = shapely.get_coordinates(triangles).reshape(-1, 4, 2)
    return corners[:, 2::-1]


def _unique(rows: Array) -> tuple[Array, NDArray[np.int64]]:
    """Returns the unique rows and the index of each row among them."""
    # (Adding 0 turns -0 into 0.)
    rows = rows + 0.0
    order = np.lexsort(rows.T[::-1])
    rows = rows[order]
    is_new = np.append(True, (rows[1:] != rows[:-1]).any(axis=1))
    which = np.empty(len(rows), dtype=np.int64)
    which[order] = np.cumsum(is_new) - 1
    return rows[is_new], which


def _smooth_normals(vertices: Array, faces: NDArray[np.int64]) -> Array:
    """Returns the area-weighted mean of face normals at each vertex."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    area = np.cross(b - a, c - a)
    normals = np.zeros_like(vertices)
    for i in range(3):
        np.add.at(normals, faces[:, i], area)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.where(length > 0, length, 1.0)
