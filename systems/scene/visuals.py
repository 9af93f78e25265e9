"""Adds visible geometry to bodies: Drake's shapes and triangle meshes."""

from pydrake.common import MemoryFile
from pydrake.geometry import (
    GeometryInstance,
    IllustrationProperties,
    InMemoryMesh,
    MakePhongIllustrationProperties,
    Mesh,
    PerceptionProperties,
    RenderLabel,
    Rgba,
    Shape,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody

from hunav_drake.systems.scene.meshes import TriangleMesh


def as_shape(mesh: TriangleMesh) -> Mesh:
    """Returns a mesh as Drake's shape."""
    file = MemoryFile(mesh.to_obj(), ".obj", "mesh")
    return Mesh(InMemoryMesh(mesh_file=file))


def AddVisual(
    plant: MultibodyPlant,
    body: RigidBody,
    name: str,
    shape: Shape | TriangleMesh,
    color: Rgba | None,
    X_BG: RigidTransform | None = None,
    *,
    perceived: bool = True,
    shown: bool = True,
) -> None:
    """Adds visible geometry to a body B; it never collides.

    Simulated cameras see it only if it is `perceived`, and viewers of Meshcat
    only if it is `shown`. Without a color, it has that of its file. A plant
    that is not registered with a SceneGraph gets nothing.
    """
    if not plant.geometry_source_is_registered():
        return
    if isinstance(shape, TriangleMesh):
        shape = as_shape(shape)
    X_BG = X_BG or RigidTransform()
    if perceived and shown and color is not None:
        plant.RegisterVisualGeometry(body, X_BG, shape, name, color.rgba)
    else:
        instance = GeometryInstance(X_BG, shape, name)
        if shown:
            instance.set_illustration_properties(
                IllustrationProperties()
                if color is None
                else MakePhongIllustrationProperties(color.rgba)
            )
        if perceived:
            properties = PerceptionProperties()
            if color is not None:
                properties.AddProperty("phong", "diffuse", color)
            instance.set_perception_properties(properties)
        plant.RegisterVisualGeometry(body, instance)


def AddLabeledVisual(
    plant: MultibodyPlant,
    body: RigidBody,
    name: str,
    shape: Shape,
    color: Rgba,
    X_BG: RigidTransform | None,
    label: int,
) -> None:
    """Adds visible geometry with a given label in label images."""
    if not plant.geometry_source_is_registered():
        return
    visual = GeometryInstance(X_BG or RigidTransform(), shape, name)
    visual.set_illustration_properties(
        MakePhongIllustrationProperties(color.rgba)
    )
    properties = PerceptionProperties()
    properties.AddProperty("phong", "diffuse", color)
    properties.AddProperty("label", "id", RenderLabel(label))
    visual.set_perception_properties(properties)
    plant.RegisterVisualGeometry(body, visual)
