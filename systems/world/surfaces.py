"""The shapes of meshes: what one walks around, and their horizontal cuts.

A mesh of a building is hollow, so its convex hull is no use. Its connected
components that are nearly convex count as their hulls; the others as what
their triangles cover, seen from above, in a range of heights.
"""

from collections.abc import Iterator
from dataclasses import dataclass
import functools
import hashlib

import numpy as np
from numpy.typing import NDArray
import shapely

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.components import connected_components
from hunav_drake.systems.common.models.mesh_files import kept
from hunav_drake.systems.world.maps.outlines import without_holes
from hunav_drake.systems.world.solids import Hull

# Corners nearer to each other are one, in meters.
_SAME = 1e-4

# The largest depth of a dent of what counts as its hull, in meters.
_DENT = 0.02

# The largest area that is missing of what counts as its hull, in square meters.
_MISSING = 0.1

# Half the drawn thickness of a surface, and the largest distance by which an
# outline is straightened, in meters.
_SKIN, _STRAIGHT = 0.005, 0.01

# The width of gaps in a mesh that are closed: too narrow for a person.
_NARROW = 0.3

# The largest number of pairs of triangles and sides of a hull that are tried.
_MOST_PAIRS = 20_000_000

# The parts of a range of heights at which its solid inside is looked for.
_LEVELS = (0.0437, 0.251, 0.5093, 0.7519, 0.9571)

# The version of the outlines that are kept.
_VERSION = 3


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles (t, 3, 3) in W, in meters, that may enclose an inside.

    Attributes:
        triangles: The corners of all.
        enclosing: Shape (t,): which ones belong to closed components.
    """

    triangles: Array
    enclosing: Mask
    closed: bool = True

    def cuts(self, height: float) -> list[Array]:
        """Returns the outlines of the cut of a plane, each (k, 2) in W."""
        return self.slices(height, height)

    @functools.cached_property
    def _known(self) -> dict[tuple[float, float], list[Array]]:
        return {}

    def slices(self, low: float, high: float) -> list[Array]:
        """Returns the outlines of the part between two heights, from above.

        They are simple polygons, and kept on the disk.
        """
        if (low, high) not in self._known:
            content = hashlib.sha256(self.triangles.tobytes())
            content.update(self.enclosing.tobytes())
            content.update(f"{low} {high} {_VERSION}".encode())
            name = f"outlines_{content.hexdigest()[:40]}"
            rows = kept(name, lambda: _rows(self._outlines(low, high)))
            self._known[low, high] = _rings(rows)
        return self._known[low, high]

    def _outlines(self, low: float, high: float) -> list[Array]:
        covered = _covered(self.triangles, low, high)
        if covered.is_empty:
            return []
        polygons = shapely.get_parts(covered)
        # What is around a room is no part of its hole.
        outside = shapely.union_all(
            shapely.polygons(shapely.get_exterior_ring(polygons))
        )
        holes = shapely.get_parts(shapely.difference(outside, covered))
        filled = [it for it in holes if self._is_filled(it, low, high)]
        whole = shapely.union_all([*polygons, *shapely.buffer(filled, _SKIN)])
        simple = shapely.simplify(whole, _STRAIGHT)
        result: list[Array] = []
        for part in shapely.get_parts(simple):
            result += [
                ring
                for ring in without_holes(part)
                if len(ring) > 2 and np.ptp(ring, axis=0).max() > 2 * _SKIN
            ]
        return result

    def _is_filled(
        self, hole: shapely.Polygon, low: float, high: float
    ) -> bool:
        if shapely.buffer(hole, -_NARROW / 2).is_empty:
            return True
        x, y = shapely.get_coordinates(hole.representative_point())[0]
        heights = low + np.array(_LEVELS) * (high - low)
        return any(self._encloses(x, y, height) for height in set(heights))

    def _encloses(self, x: float, y: float, z: float) -> bool:
        """Returns whether closed components enclose a point.

        It is the winding number, as they may overlap.
        """
        p, q = _crossings(self.triangles[self.enclosing], z)
        straddles = (p[:, 1] > y) != (q[:, 1] > y)
        p, q = p[straddles], q[straddles]
        part = (y - p[:, 1]) / (q[:, 1] - p[:, 1])
        right = p[:, 0] + part * (q[:, 0] - p[:, 0]) > x
        return bool(np.sign(q[:, 1] - p[:, 1])[right].sum())


def mesh_solids(triangles: Array) -> Iterator[Hull | Surface]:
    """Yields the solids of a mesh, given its triangles (t, 3, 3) in W."""
    sides = np.diff(triangles[:, [0, 1, 2, 0]], axis=1)
    normals = np.cross(sides[:, 0], sides[:, 1])
    triangles = triangles[(normals != 0).any(axis=1)]
    if not len(triangles):
        return
    hollow, enclosing = [], []
    for component, is_closed in _components(triangles):
        corners = _hull_corners(component)
        if corners is not None:
            yield Hull(corners)
        else:
            hollow.append(component)
            enclosing.append(np.full(len(component), is_closed))
    if hollow:
        yield Surface(np.concatenate(hollow), np.concatenate(enclosing))


def straightened(outline: Array) -> Array:
    """Returns an outline without corners that hardly are one."""
    ring = shapely.get_coordinates(
        shapely.simplify(shapely.Polygon(outline), _STRAIGHT / 2)
    )[:-1]
    return ring if len(ring) > 2 else outline


def _components(triangles: Array) -> Iterator[tuple[Array, bool]]:
    """Yields the connected components, and whether each is closed."""
    rows = np.rint(triangles.reshape(-1, 3) / _SAME)
    _, corner = np.unique(rows, axis=0, return_inverse=True)
    faces = corner.reshape(-1, 3)
    n = int(faces.max()) + 1
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    label = connected_components(n, ends.T)
    of_face = label[faces[:, 0]]
    edges = np.sort(np.concatenate([ends, faces[:, [2, 0]]]), axis=1)
    _, side, count = np.unique(
        edges, axis=0, return_inverse=True, return_counts=True
    )
    is_odd = count[side.ravel()] % 2 == 1
    leaky = set(np.tile(of_face, 3)[is_odd].tolist())
    order = np.argsort(of_face, kind="stable")
    starts = np.flatnonzero(np.diff(of_face[order], prepend=-1))
    for rows in np.split(order, starts[1:]):
        yield triangles[rows], int(of_face[rows[0]]) not in leaky


def _hull_corners(triangles: Array) -> Array | None:
    """Returns the corners of the hull of a nearly convex component."""
    from scipy.spatial import ConvexHull, QhullError

    points = np.unique(triangles.reshape(-1, 3), axis=0)
    if len(points) < 4 or np.ptp(points, axis=0).min() < _SAME:
        return None
    try:
        hull = ConvexHull(points)
    except QhullError:
        return None
    if len(hull.equations) * len(triangles) > _MOST_PAIRS:
        return None
    # A dent is deep where a corner, or the middle of a triangle or of its
    # sides, is far inside.
    sides = (triangles + triangles[:, [1, 2, 0]]).reshape(-1, 3) / 2
    middles = np.concatenate([triangles.mean(axis=1), sides, points])
    normals, offsets = hull.equations[:, :3], hull.equations[:, 3]
    depth = -(np.einsum("ij,kj->ik", middles, normals) + offsets).max(axis=1)
    if depth.max() > _DENT:
        return None
    # Nothing is missing of it: an open box is no box, and a thin wall with a
    # door is no wall.
    corners = np.cross(
        triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    )
    # (What is seen from outside counts, and of two sides of a face one.)
    middle = triangles.mean(axis=1)
    away = sum(middle[:, k, None] * normals[:, k] for k in range(3)) + offsets
    seen = (corners * normals[away.argmax(axis=1)]).sum(axis=1) / 2
    area = max(seen[seen > 0].sum(), -seen[seen < 0].sum())
    if area < max(0.9 * hull.area, hull.area - _MISSING):
        return None
    found: Array = points[hull.vertices]
    return found


def _crossings(triangles: Array, z: float) -> tuple[Array, Array]:
    """Returns the ends (m, 2) of the cuts of a plane with triangles.

    The front of a triangle is on one side, seen from the first end.
    """
    above = triangles[:, :, 2] > z
    found = np.count_nonzero(above, axis=1) % 3 != 0
    triangles, above = triangles[found], above[found]
    alone = above == (np.count_nonzero(above, axis=1) == 1)[:, None]
    first = np.argmax(alone, axis=1)
    rows = np.arange(len(triangles))
    a = triangles[rows, first]
    ends = []
    for step in (1, 2):
        b = triangles[rows, (first + step) % 3]
        part = (z - a[:, 2]) / (b[:, 2] - a[:, 2])
        ends.append(a[:, :2] + part[:, None] * (b - a)[:, :2])
    is_up = np.count_nonzero(above, axis=1)[:, None] == 1
    return np.where(is_up, *ends), np.where(is_up, *ends[::-1])


def _covered(triangles: Array, low: float, high: float) -> shapely.Geometry:
    """Returns what triangles cover between two heights, a bit wider."""
    z = triangles[:, :, 2]
    triangles = triangles[(z.min(axis=1) <= high) & (z.max(axis=1) >= low)]
    if not len(triangles):
        return shapely.Polygon()
    z = triangles[:, :, 2]
    inside = (z >= low) & (z <= high)
    points = [triangles[:, :, :2]]
    valid = [inside]
    for plane in {low, high}:
        a, b = triangles, triangles[:, [1, 2, 0]]
        height = b[:, :, 2] - a[:, :, 2]
        meets = (a[:, :, 2] < plane) != (b[:, :, 2] < plane)
        part = (plane - a[:, :, 2]) / np.where(meets, height, 1.0)
        points.append(a[:, :, :2] + part[:, :, None] * (b - a)[:, :, :2])
        valid.append(meets)
    at, ok = np.concatenate(points, axis=1), np.concatenate(valid, axis=1)
    some = ok.any(axis=1)
    at, ok = at[some], ok[some]
    # The places of others are those of one that is valid.
    first = at[np.arange(len(at)), np.argmax(ok, axis=1)]
    at = np.where(ok[:, :, None], at, first[:, None])
    shapes = shapely.convex_hull(shapely.multipoints(at))
    wide = shapely.buffer(
        shapes, _SKIN, cap_style="square", join_style="mitre", mitre_limit=2.0
    )
    return shapely.union_all(wide)


def _rows(rings: list[Array]) -> Array:
    """Returns rings as one table of rows (number of the ring, x, y)."""
    rows = [
        np.column_stack([np.full(len(ring), i), ring])
        for i, ring in enumerate(rings)
    ]
    return np.concatenate([np.zeros((0, 3)), *rows])


def _rings(rows: NDArray[np.float64]) -> list[Array]:
    starts = np.flatnonzero(np.diff(rows[:, 0], prepend=-1))
    return [it[:, 1:] for it in np.split(rows, starts[1:]) if len(it)]
