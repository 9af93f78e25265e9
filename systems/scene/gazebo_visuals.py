"""Shows worlds and models of Gazebo: meshes with their textures."""

from functools import partial

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    Mesh,
    Rgba,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.models.gazebo import GREY, Part, read_gazebo
from hunav_drake.systems.common.models.mesh_files import MeshFile, obj_of
from hunav_drake.systems.scene.visuals import AddVisual
from hunav_drake.systems.world.shapes import Model


def AddGazeboVisuals(
    plant: MultibodyPlant,
    model: Model,
    stem: str,
    *,
    highest: float,
    cut: float,
    whole: str,
) -> None:
    """Adds what one sees of a file of Gazebo to the world body.

    Args:
        plant: The plant, which is not finalized.
        model: The model, whose file can be read.
        stem: The start of the geometries' names: a number follows.
        highest: What is higher, in meters, is whole for cameras only.
        cut: The height at which viewers see it cut, in meters.
        whole: The end of the names of what cameras see whole.
    """
    found = read_gazebo(model.file, model.model_path, model.skip_missing)
    x, y, yaw = model.pose
    X_WM = RigidTransform(RollPitchYaw(0, 0, yaw), [x, y, 0.0])
    add = partial(AddVisual, plant, plant.world_body())
    for i, part in enumerate(found.visuals):
        X_WG = X_WM @ part.X_WG
        is_mesh = isinstance(part.shape, MeshFile)
        color = None if is_mesh else Rgba(*(part.color or GREY))
        low, high = _heights(part, X_WG)
        name, shape = f"{stem}_{i}", _shape(part)
        if high <= highest:
            add(name, shape, color, X_WG)
            continue
        add(name + whole, shape, color, X_WG, shown=False)
        if low < cut:
            rest, X_WG = _cut(part, X_WG, low, high, cut)
            if rest is not None:
                add(name, rest, color, X_WG, perceived=False)


def _heights(part: Part, X_WG: RigidTransform) -> tuple[float, float]:
    """Returns the lowest and the highest z of a part in W, in meters."""
    up, z = X_WG.rotation().matrix()[2], X_WG.translation()[2]
    if isinstance(part.shape, MeshFile):
        points = part.shape.triangles.reshape(-1, 3) * part.scale
        heights = (points * up).sum(axis=1) + z
        return float(heights.min()), float(heights.max())
    reach = float((np.abs(up) * _half(part.shape)).sum())
    return z - reach, z + reach


def _half(shape: Shape) -> list[float]:
    """Returns half the sizes of a box around a shape, in meters."""
    if isinstance(shape, Box):
        return list(shape.size() / 2)
    if isinstance(shape, Ellipsoid):
        return [shape.a(), shape.b(), shape.c()]
    if isinstance(shape, Convex):
        hull = shape.GetConvexHull()
        rows = [hull.vertex(i) for i in range(hull.num_vertices())]
        return list(np.abs(rows).max(axis=0))
    r = shape.radius()
    if isinstance(shape, Sphere):
        return [r, r, r]
    return [r, r, shape.length() / 2 + r * isinstance(shape, Capsule)]


def _shape(part: Part) -> Shape:
    return _mesh(part) if isinstance(part.shape, MeshFile) else part.shape


def _mesh(part: Part, cut: tuple[Array, float] | None = None) -> Mesh | None:
    """Returns the mesh of a part, or what is left of it: see `obj_of`."""
    x, y, z = np.sign(part.scale).tolist()
    file = obj_of(part.shape, part.color, cut, (x, y, z))
    return Mesh(str(file), scale3=np.abs(part.scale)) if file else None


def _cut(
    part: Part, X_WG: RigidTransform, low: float, high: float, cut: float
) -> tuple[Shape | None, RigidTransform]:
    """Returns the part below a height, and its pose."""
    shape = part.shape
    if isinstance(shape, MeshFile):
        matrix = X_WG.GetAsMatrix4()
        matrix[:, :3] *= part.scale
        return _mesh(part, (matrix, cut)), X_WG
    upright = abs(X_WG.rotation().matrix()[2, 2]) > 1 - 1e-6
    if not upright or not isinstance(shape, Box | Cylinder):
        return shape, X_WG
    x, y, z = X_WG.translation()
    moved = RigidTransform(X_WG.rotation(), [x, y, z - (high - cut) / 2])
    if isinstance(shape, Box):
        return Box(shape.width(), shape.depth(), cut - low), moved
    return Cylinder(shape.radius(), cut - low), moved
