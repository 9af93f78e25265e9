"""Adds what is visible of bodies: shapes of Drake, and triangle meshes."""

from pydrake.common import MemoryFile
from pydrake.geometry import (
    GeometryInstance,
    InMemoryMesh,
    MakePhongIllustrationProperties,
    Mesh,
    Rgba,
    Shape,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody

from hunav_drake.systems.scene.meshes import TriangleMesh


def MakeInMemoryMesh(mesh: TriangleMesh, name: str) -> InMemoryMesh:
    """Returns a mesh for `pydrake.geometry.Mesh`, as a file in memory.

    Args:
        mesh: The triangles.
        name: What Drake's messages call it.
    """
    return InMemoryMesh(mesh_file=MemoryFile(mesh.to_obj(), ".obj", name))


def AddVisual(
    plant: MultibodyPlant,
    body: RigidBody,
    name: str,
    shape: Shape | TriangleMesh,
    color: Rgba,
    X_BG: RigidTransform | None = None,
    *,
    perceived: bool = True,
) -> None:
    """Adds visible geometry to a body; it never collides.

    Args:
        plant: The plant of the body.
        body: The body B.
        name: What the geometry is called.
        shape: What it looks like.
        color: Its color.
        X_BG: Where it is; by default, in the frame of the body.
        perceived: Whether simulated cameras see it.
    """
    if isinstance(shape, TriangleMesh):
        shape = Mesh(MakeInMemoryMesh(shape, name))
    X_BG = X_BG or RigidTransform()
    if perceived:
        plant.RegisterVisualGeometry(body, X_BG, shape, name, color.rgba)
    else:
        mark = GeometryInstance(X_BG, shape, name)
        mark.set_illustration_properties(
            MakePhongIllustrationProperties(color.rgba)
        )
        plant.RegisterVisualGeometry(body, mark)
