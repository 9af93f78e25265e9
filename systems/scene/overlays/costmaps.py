"""Flat boards that show costmaps in Meshcat."""

import base64
import io
import json

import numpy as np
from pydrake.common import MemoryFile
from pydrake.geometry import InMemoryMesh, Mesh, Meshcat

from hunav_drake.systems.world.maps.cost_picture import costmap_picture
from hunav_drake.systems.world.maps.costs import Costmap

# OpenGL constants, which glTF uses.
_NEAREST, _LINEAR, _CLAMP = 9728, 9729, 33071
_FLOAT, _UNSIGNED_SHORT = 5126, 5123


# The number of pictures kept for slow browsers. A browser fetches a picture
# after it is announced, which may take longer than the next one takes to come.
_KEPT = 8


def ShowCostmap(
    meshcat: Meshcat, path: str, count: int, costmap: Costmap, height: float
) -> None:
    """Shows a costmap in a live view, replacing the previous one.

    Its pictures are below the Meshcat path `path`; `count` is the number of
    costmaps shown before, `height` that above the floor, in meters.
    """
    if not costmap.costs.size:
        meshcat.Delete(f"{path}/shown")
        return
    board = CostmapBoard(costmap, height)
    meshcat.SetObject(f"{path}/kept/{count % _KEPT}", board)
    meshcat.SetProperty(f"{path}/kept", "visible", False)
    meshcat.SetObject(f"{path}/shown", board)


def RecordCostmap(
    meshcat: Meshcat,
    path: str,
    count: int,
    costmap: Costmap,
    height: float,
    times: tuple[float, float],
) -> None:
    """Shows a costmap in a recording from a start to an end time.

    `times` are in seconds; the rest is as in `ShowCostmap`.
    """
    if not costmap.costs.size:
        return
    place = f"{path}/{count}"
    begin, end = times
    meshcat.SetObject(place, CostmapBoard(costmap, height))
    meshcat.SetProperty(place, "visible", False, end)
    meshcat.SetProperty(place, "visible", begin == 0.0, 0.0)
    meshcat.SetProperty(place, "visible", True, begin)


def CostmapBoard(costmap: Costmap, height: float) -> Mesh:
    """Returns a costmap as a flat board at its position, for Meshcat.

    It has at least one cell; `height` is that above the floor, in meters.
    """
    rows, columns = costmap.costs.shape
    x, y = costmap.origin
    ends = (x + columns * costmap.resolution, y + rows * costmap.resolution)
    # glTF has y up, and the first row of a picture on top.
    corners = [[px, height, -py] for py in (y, ends[1]) for px in (x, ends[0])]
    places = np.array(corners, dtype="<f4")
    texture = np.array([[0, 1], [1, 1], [0, 0], [1, 0]], dtype="<f4")
    faces = np.array([0, 1, 3, 0, 3, 2], dtype="<u2")
    parts = [part.tobytes() for part in (places, texture, faces)]
    png = io.BytesIO()
    costmap_picture(costmap).save(png, "PNG")
    starts = np.cumsum([0, *map(len, parts)]).tolist()
    gltf = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [
            {
                "primitives": [
                    {
                        "attributes": {"POSITION": 0, "TEXCOORD_0": 1},
                        "indices": 2,
                        "material": 0,
                    }
                ]
            }
        ],
        # Unlit, so that it has the brightness of the picture.
        "extensionsUsed": ["KHR_materials_unlit"],
        "materials": [
            {
                "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
                "alphaMode": "BLEND",
                "extensions": {"KHR_materials_unlit": {}},
            }
        ],
        # Cells with sharp edges.
        "samplers": [
            {
                "magFilter": _NEAREST,
                "minFilter": _LINEAR,
                "wrapS": _CLAMP,
                "wrapT": _CLAMP,
            }
        ],
        "textures": [{"sampler": 0, "source": 0}],
        "images": [{"uri": _data(png.getvalue(), "image/png")}],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": _FLOAT,
                "count": 4,
                "type": "VEC3",
                "min": places.min(axis=0).tolist(),
                "max": places.max(axis=0).tolist(),
            },
            {
                "bufferView": 1,
                "componentType": _FLOAT,
                "count": 4,
                "type": "VEC2",
            },
            {
                "bufferView": 2,
                "componentType": _UNSIGNED_SHORT,
                "count": 6,
                "type": "SCALAR",
            },
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": len(part)}
            for start, part in zip(starts, parts, strict=False)
        ],
        "buffers": [
            {
                "byteLength": starts[-1],
                "uri": _data(b"".join(parts), "application/octet-stream"),
            }
        ],
    }
    text = json.dumps(gltf, separators=(",", ":"))
    return Mesh(InMemoryMesh(mesh_file=MemoryFile(text, ".gltf", "costmap")))


def _data(content: bytes, kind: str) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"
