"""The collision geometry of models of files, as obstacles of people.

Drake reads models; each collision geometry counts as its convex hull, as in
Drake's contacts of meshes. Worlds of Gazebo, and models with meshes or other
models in them, have a reader of their own, and meshes their true shapes.
"""

from collections.abc import Sequence
import functools
import os
from typing import NamedTuple

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    Role,
    SceneGraph,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder
import shapely

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.models.apart import ModelFault
from hunav_drake.systems.common.models.gazebo import (
    GazeboFile,
    is_gazebo_file,
    read_gazebo,
)
from hunav_drake.systems.common.models.mesh_files import MeshFile
from hunav_drake.systems.common.models.reading import AddModelFile
from hunav_drake.systems.world.solids import (
    Hull,
    WorldFileError,
    disc,
    fine_disc,
    rectangle,
)
from hunav_drake.systems.world.surfaces import (
    Surface,
    mesh_solids,
    straightened,
)

# The range of heights in which a geometry is an obstacle, in meters: a step of
# 5 cm is none.
_WALKING_HEIGHTS = (0.05 + 1e-9, 1.8 - 1e-9)

# The farthest that something may be, in meters.
_FARTHEST = 1e5

# The largest number of sides of a ball: one of 5 m is off by 6 mm.
_MOST_SIDES = 64


class ModelSolids(NamedTuple):
    """The solids of a file, and their outlines at walking heights, in W."""

    solids: Sequence[Hull | Surface]
    footprints: Sequence[Array]


def model_solids(
    file: str,
    pose: tuple[float, float, float],
    model_path: Sequence[str] = (),
    skip_missing: bool = False,
) -> ModelSolids:
    """Returns the collision geometries of a file.

    Those of the files read last are cached, as long as these do not change. The
    arguments are the fields of `Model`.

    Raises:
        WorldFileError: If the file cannot be read, or has no collision
            geometry.
    """
    if is_gazebo_file(file):
        try:
            found = read_gazebo(file, model_path, skip_missing)
        except ModelFault as fault:
            raise WorldFileError(f"{file}: {fault}") from fault
        try:
            return _gazebo_solids(found, pose)
        except (ValueError, shapely.GEOSException) as error:
            raise WorldFileError(f"{file}: {error}") from error
    try:
        stamp = os.stat(file).st_mtime_ns
    except (OSError, ValueError):
        stamp = 0
    return _drake_solids(file, pose, stamp)


@functools.lru_cache(maxsize=64)
def _gazebo_solids(
    found: GazeboFile, pose: tuple[float, float, float]
) -> ModelSolids:
    X_WM = RigidTransform(RollPitchYaw(0, 0, pose[2]), [*pose[:2], 0.0])
    solids: list[Hull | Surface] = []
    footprints: list[Array] = []
    for part in found.collisions:
        X_WG = X_WM @ part.X_WG
        if isinstance(part.shape, MeshFile):
            corners = part.shape.triangles.reshape(-1, 3) * part.scale
            placed = (X_WG @ corners.T).T.reshape(-1, 3, 3)
            if not np.abs(placed).max() <= _FARTHEST:
                raise ValueError(
                    f"{part.place}: the mesh reaches farther than"
                    f" {_FARTHEST:g} m; correct <scale> or <pose>"
                )
            parts = list(mesh_solids(placed))
            footprints += map(straightened, _footprints(parts))
        else:
            parts = [Hull((X_WG @ _points(part.shape).T).T)]
            footprints += _footprints(parts)
        solids += parts
    return ModelSolids(solids, footprints)


def _footprints(solids: Sequence[Hull | Surface]) -> list[Array]:
    """Returns the outlines of solids at walking heights."""
    found = []
    for solid in solids:
        if isinstance(solid, Surface):
            found += solid.slices(*_WALKING_HEIGHTS)
        elif (outline := solid.slice(*_WALKING_HEIGHTS)) is not None:
            found.append(outline)
    return found


@functools.lru_cache(maxsize=64)
def _drake_solids(
    filename: str, pose: tuple[float, float, float], stamp: int
) -> ModelSolids:
    builder = DiagramBuilder()
    scene_graph = builder.AddSystem(SceneGraph())
    plant = builder.AddSystem(MultibodyPlant(time_step=0.0))
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    builder.Connect(
        plant.get_geometry_pose_output_port(),
        scene_graph.get_source_pose_port(plant.get_source_id()),
    )
    try:
        AddModelFile(plant, filename, pose)
        plant.Finalize()
    except (ValueError, RuntimeError) as error:
        raise WorldFileError(str(error)) from error
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    query = scene_graph.get_query_output_port().Eval(
        scene_graph.GetMyContextFromRoot(context)
    )
    inspector = query.inspector()
    hulls: list[Hull | Surface] = []
    for geometry in inspector.GetAllGeometryIds(Role.kProximity):
        shape = inspector.GetShape(geometry)
        try:
            points = _points(shape)
        except RuntimeError as error:
            line = " ".join(str(error).split())
            raise WorldFileError(f"{filename}: {line:.300}") from error
        X_WG = query.GetPoseInWorld(geometry)
        hulls.append(Hull((X_WG @ points.T).T))
    if not hulls:
        raise WorldFileError(
            f"{filename}: must have collision geometry, which people and robots"
            " walk around"
        )
    return ModelSolids(hulls, _footprints(hulls))


def _points(shape: Shape) -> Array:
    """Returns points (k, 3) in G of which a geometry is the convex hull."""
    if isinstance(shape, Box):
        x, y, z = shape.size() / 2
        return _stack(
            [(-z, rectangle(-x, -y, x, y)), (z, rectangle(-x, -y, x, y))]
        )
    if isinstance(shape, Cylinder):
        z, ring = shape.length() / 2, fine_disc(0, 0, shape.radius())
        return _stack([(-z, ring), (z, ring)])
    if isinstance(shape, Sphere | Capsule | Ellipsoid):
        half = 0.0
        if isinstance(shape, Ellipsoid):
            radii = np.array([shape.a(), shape.b(), shape.c()])
        else:
            radii = np.full(3, shape.radius())
            half = shape.length() / 2 if isinstance(shape, Capsule) else 0.0
        sides = min(len(fine_disc(0, 0, radii.max())), _MOST_SIDES)
        ball = _stack(
            [
                (np.sin(angle), disc(0, 0, max(np.cos(angle), 1e-9), sides))
                for angle in np.linspace(-np.pi / 2, np.pi / 2, sides // 2 + 1)
            ]
        )
        return np.vstack(
            [ball * radii + [0, 0, end] for end in sorted({-half, half})]
        )
    surface = shape.GetConvexHull()
    return np.array(
        [surface.vertex(i) for i in range(surface.num_vertices())]
    ).reshape(-1, 3)


def _stack(rings: list[tuple[float, Array]]) -> Array:
    """Returns rings (k, 2), each at its height, as points."""
    return np.vstack(
        [np.column_stack([ring, np.full(len(ring), z)]) for z, ring in rings]
    )
