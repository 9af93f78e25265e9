"""Small worlds and meshes of Gazebo, written for tests."""

import itertools

import numpy as np
import shapely

BOX = "<geometry><box><size>1 1 1</size></box></geometry>"


def mesh(uri: str, more: str = "") -> str:
    return f"<geometry><mesh><uri>{uri}</uri>{more}</mesh></geometry>"


def model(geometry: str = BOX, name: str = "thing", more: str = "") -> str:
    return (
        f'<model name="{name}"><static>1</static>{more}<link name="l">\n'
        f'<collision name="c">{geometry}</collision>\n'
        f'<visual name="v">{geometry}</visual></link></model>'
    )


def sdf(inner: str, version: str = "1.6") -> str:
    return (
        f'<?xml version="1.0"?>\n<sdf version="{version}">\n{inner}\n</sdf>\n'
    )


def world(inner: str, version: str = "1.6") -> str:
    return sdf(f'<world name="w">\n{inner}\n</world>', version)


def block(low, high) -> np.ndarray:
    """The triangles (12, 3, 3) of an upright block between two corners."""
    (x, y, z), (u, v, w) = low, high
    p = np.array(
        [(a, b, c) for c in (z, w) for a, b in ((x, y), (u, y), (u, v), (x, v))]
    )
    quads = [(0, 3, 2, 1), (4, 5, 6, 7)]
    quads += [(i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4) for i in range(4)]
    return p[[(q[0], q[i], q[i + 1]) for q in quads for i in (1, 2)]]


def room() -> np.ndarray:
    """One mesh: a room of 4 x 4 m inside, walls of 0.2 m, a door at +x.

    The door is 1 m wide and 2 m high, below a lintel.
    """
    parts = [
        block((-2.2, -2.2, 0), (2.2, -2.0, 2.5)),
        block((-2.2, 2.0, 0), (2.2, 2.2, 2.5)),
        block((-2.2, -2.0, 0), (-2.0, 2.0, 2.5)),
        block((2.0, -2.0, 0), (2.2, -0.5, 2.5)),
        block((2.0, 0.5, 0), (2.2, 2.0, 2.5)),
        block((2.0, -0.5, 2.0), (2.2, 0.5, 2.5)),
    ]
    return np.concatenate(parts)


def stl(triangles) -> str:
    lines = ["solid s"]
    for corners in np.asarray(triangles).tolist():
        lines.append("facet normal 0 0 0\nouter loop")
        lines += ["vertex {} {} {}".format(*it) for it in corners]
        lines.append("endloop\nendfacet")
    return "\n".join([*lines, "endsolid s"]) + "\n"


def obj(triangles) -> str:
    points = np.asarray(triangles).reshape(-1, 3).tolist()
    lines = ["v {} {} {}".format(*it) for it in points]
    lines += [f"f {i} {i + 1} {i + 2}" for i in range(1, len(points), 3)]
    return "\n".join(lines) + "\n"


def dae(
    triangles, unit='<unit meter="0.01" name="cm"/>', name="part", node="n"
) -> str:
    points = np.asarray(triangles).reshape(-1, 3)
    numbers = " ".join(map(str, points.ravel().tolist()))
    order = " ".join(map(str, range(len(points))))
    return (
        '<?xml version="1.0"?><COLLADA version="1.4.1"'
        ' xmlns="http://www.collada.org/2005/11/COLLADASchema">'
        f"<asset>{unit}<up_axis>Z_UP</up_axis></asset>"
        f'<library_geometries><geometry id="{name}" name="{name}"><mesh>'
        f'<source id="p"><float_array id="a" count="{points.size}">{numbers}'
        '</float_array><technique_common><accessor source="#a"'
        f' count="{len(points)}" stride="3"><param name="X" type="float"/>'
        '<param name="Y" type="float"/><param name="Z" type="float"/>'
        '</accessor></technique_common></source><vertices id="v"><input'
        ' semantic="POSITION" source="#p"/></vertices><triangles'
        f' count="{len(points) // 3}"><input semantic="VERTEX" source="#v"'
        f' offset="0"/><p>{order}</p></triangles></mesh></geometry>'
        '</library_geometries><library_visual_scenes><visual_scene id="s">'
        f'<node id="n" name="{node}"><instance_geometry url="#{name}"/></node>'
        "</visual_scene></library_visual_scenes>"
        '<scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    )


def extruded(polygon, height: float) -> np.ndarray:
    """The triangles (t, 3, 3) of a closed upright solid with rooms."""
    polygon = shapely.orient_polygons(polygon)
    triangles = []
    flat = shapely.constrained_delaunay_triangles(polygon)
    for it in shapely.get_parts(shapely.orient_polygons(flat)):
        a, b, c = shapely.get_coordinates(it)[:3].tolist()
        triangles.append([(*a, height), (*b, height), (*c, height)])
        triangles.append([(*a, 0), (*c, 0), (*b, 0)])
    for ring in shapely.get_rings(polygon):
        for a, b in itertools.pairwise(shapely.get_coordinates(ring).tolist()):
            triangles.append([(*a, 0), (*b, 0), (*b, height)])
            triangles.append([(*a, 0), (*b, height), (*a, height)])
    return np.array(triangles, dtype=float)
