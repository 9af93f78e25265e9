"""Converts triangle meshes for Drake."""

from pydrake.common import MemoryFile
from pydrake.geometry import InMemoryMesh

from hunav_drake.systems.scene.meshes import TriangleMesh


def MakeInMemoryMesh(mesh: TriangleMesh, name: str) -> InMemoryMesh:
    """Returns a mesh for `pydrake.geometry.Mesh`, as a file in memory.

    Args:
        mesh: The triangles.
        name: What Drake's messages call it.
    """
    return InMemoryMesh(mesh_file=MemoryFile(mesh.to_obj(), ".obj", name))
