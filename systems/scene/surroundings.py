"""Floor, walls, furniture and goal marks."""

from collections.abc import Iterable, Sequence
from functools import lru_cache, partial
import itertools
import math
from typing import NamedTuple

import numpy as np
from pydrake.geometry import (
    Box as BoxShape,
    GeometrySet,
    Mesh,
    PerceptionProperties,
    Rgba,
    Role,
    SceneGraph,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.models.gazebo import is_gazebo_file
from hunav_drake.systems.common.models.reading import AddModelFile
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.scene.bounds import Bounds, Robots, by_name, figure_of
from hunav_drake.systems.scene.gazebo_visuals import AddGazeboVisuals
from hunav_drake.systems.scene.lettering import lettering_mesh
from hunav_drake.systems.scene.meshes import (
    TriangleMesh,
    disc,
    ellipsoid,
    extrude,
    join,
    lay,
    ring,
)
from hunav_drake.systems.scene.palette import (
    FLOOR,
    MATERIALS,
    WALL,
    WALL_CUT,
    accent,
    top_of,
)
from hunav_drake.systems.scene.visuals import AddVisual, as_shape
from hunav_drake.systems.world.shapes import World
from hunav_drake.systems.world.solids import Lettering, Prism

# The depth of the slab below the tiles, enough not to shine through, and its
# thickness, in meters.
_SLAB_DEPTH = 0.01
_SLAB_THICKNESS = 0.05

# The drawn thickness of walls without thickness, in meters.
POLYLINE_THICKNESS = 0.05

# The maximum number of floor tiles along a side. They are 1 m long, or 10, 100,
# ... m in larger worlds.
_MAX_TILES = 100

# Objects higher than a door are drawn cut at this height, with a lid of this
# thickness, in meters; among cut walls, so is furniture higher than a counter.
CUT_HEIGHT = 1.1
_HIGHEST, _COUNTER = 2.2, 1.5

# What is above this height everywhere hangs, in meters.
_KNEE = 0.5
_LID = 0.004
_WHOLE, _SECTION = "_whole", "_cut"

Quad = list[tuple[float, float]]

# Marks on the floor lie between these heights, in meters.
_MARK_LOW, _MARK_HIGH = 0.001, 0.004

# The number of goals at one place that are visible as rings of their colors.
_GOAL_LEVELS = 6

# The width of the ring around a goal, and the radius of the dot, in meters.
GOAL_WIDTH, GOAL_DOT = 0.035, 0.055


def AddFloor(
    plant: MultibodyPlant, bounds: Bounds, world: World | None = None
) -> None:
    """Adds a floor of two shades of tiles, with its top at z = 0.

    It is 1 cm lower in worlds of Gazebo, which have floors of their own.

    The tiles are 1 m wide (a power of ten in large worlds) and lie at multiples
    of that in W, so that the floor is a scale.
    """
    tile = 1.0
    while max(bounds.size) / tile > _MAX_TILES:
        tile *= 10.0
    xs = _cuts(bounds.x_min, bounds.x_max, tile)
    ys = _cuts(bounds.y_min, bounds.y_max, tile)
    shades: tuple[list[Quad], list[Quad]] = ([], [])
    for i, (x, x_next) in enumerate(itertools.pairwise(xs)):
        for k, (y, y_next) in enumerate(itertools.pairwise(ys)):
            # The first cuts differ from world to world; the pattern does not.
            odd = (
                i + k + math.floor(xs[0] / tile) + math.floor(ys[0] / tile)
            ) % 2
            shades[odd].append(
                [(x, y), (x_next, y), (x_next, y_next), (x, y_next)]
            )
    models = world.models if world else ()
    top = -0.01 if any(is_gazebo_file(it.file) for it in models) else 0.0
    body = plant.world_body()
    for i, (tiles, color) in enumerate(zip(shades, FLOOR, strict=True)):
        if tiles:
            AddVisual(plant, body, f"tiles_{i}", lay(tiles, top), color)
    slab = BoxShape(*bounds.size, _SLAB_THICKNESS)
    z = top - _SLAB_DEPTH - _SLAB_THICKNESS / 2
    X_WG = RigidTransform([*bounds.center, z])
    AddVisual(plant, body, "floor", slab, FLOOR[1], X_WG)


def AddWorld(plant: MultibodyPlant, world: World) -> None:
    """Adds all objects of a world to the world body.

    Walls are "wall_0", "wall_1", ...; furniture is "furniture_0_wood", ..., one
    part per material, and "furniture_0_text_0", ... for what is written on it.
    Viewers see objects higher than a door cut at `CUT_HEIGHT`, walls with a
    dark section, to look into rooms; cameras see them whole, unless `ShowCut`
    is called. What hangs, and what has a text, is never cut. Models from files
    have their own appearance.
    """
    fixtures = list(world.fixtures())
    cut_walls = any(
        it.place[0] == "walls" and _height(it.solids) > _HIGHEST
        for it in fixtures
    )
    for fixture in fixtures:
        kind, *index = fixture.place
        # The tree of the scene distinguishes walls from furniture.
        stem = "_".join(
            [{"walls": "wall"}.get(str(kind), str(kind)), *map(str, index)]
        )
        parts: dict[str, list[Prism]] = {}
        for solid in fixture.solids:
            if isinstance(solid, Prism):
                parts.setdefault(solid.material, []).append(solid)
        among_walls = cut_walls and kind == "furniture"
        limit = _COUNTER if among_walls else _HIGHEST
        high = _height(fixture.solids) > limit
        texts = [it for it in fixture.solids if isinstance(it, Lettering)]
        hangs = all(p.low > _KNEE for it in parts.values() for p in it)
        for material, prisms in parts.items():
            plain = kind == "walls"
            name = stem if plain else f"{stem}_{material.replace(' ', '_')}"
            color = MATERIALS.get(material, WALL)
            if high and not hangs and not texts:
                # (Of things on a shelf, one sees what they are.)
                section = color if kind == "furniture" else WALL_CUT
                _AddCutPrisms(plant, name, prisms, color, section)
            else:
                _AddPrisms(plant, name, prisms, color)
        for k, text in enumerate(texts):
            mesh = lettering_mesh(text)
            color = MATERIALS.get(text.material, WALL)
            if len(mesh.faces):
                at = plant.world_body()
                AddVisual(plant, at, f"{stem}_text_{k}", mesh, color)
    for i, model in enumerate(world.models):
        if is_gazebo_file(model.file):
            sizes = {"highest": _HIGHEST, "cut": CUT_HEIGHT}
            AddGazeboVisuals(plant, model, f"models_{i}", **sizes, whole=_WHOLE)
            continue
        for instance in AddModelFile(plant, model.file, model.pose):
            # (People and robots may have the name of a model.)
            own = plant.GetModelInstanceName(instance)
            plant.RenameModelInstance(instance, f"models_{i}_{own}")


def _height(solids: Iterable[object]) -> float:
    """Returns the height of the top of prisms, in meters."""
    highs = (it.high for it in solids if isinstance(it, Prism))
    return max(highs, default=0.0)


def _AddPrisms(
    plant: MultibodyPlant, name: str, prisms: Sequence[Prism], color: Rgba
) -> None:
    """Adds prisms as one geometry."""
    shape = _shapes(prisms, is_cut=False).whole
    AddVisual(plant, plant.world_body(), name, shape, color)


def _AddCutPrisms(
    plant: MultibodyPlant,
    name: str,
    prisms: Sequence[Prism],
    color: Rgba,
    section: Rgba,
) -> None:
    """Adds prisms as one geometry for cameras, and cut for viewers."""
    add = partial(AddVisual, plant, plant.world_body())
    shapes = _shapes(prisms, is_cut=True)
    if shapes.cut:
        add(name, shapes.cut, color, perceived=False)
    if shapes.lid:
        add(name + _SECTION, shapes.lid, section, perceived=False)
    add(name + _WHOLE, shapes.whole, color, shown=False)


class _Shapes(NamedTuple):
    """Prisms as one geometry: whole, cut, and the lid on the cut."""

    whole: Mesh
    cut: Mesh | None
    lid: Mesh | None


def _shapes(prisms: Iterable[Prism], *, is_cut: bool) -> _Shapes:
    def row(it: Prism) -> tuple[bytes, float, float, str, bool]:
        outline = np.asarray(it.outline, dtype=float).tobytes()
        return outline, it.low, it.high, it.material, it.closed

    return _shapes_of(tuple(map(row, prisms)), is_cut)


# (Many diagrams have the same world, as those of the seeds of a suite.)
@lru_cache(maxsize=1024)
def _shapes_of(
    rows: tuple[tuple[bytes, float, float, str, bool], ...], is_cut: bool
) -> _Shapes:
    prisms = [
        Prism(np.frombuffer(row[0]).reshape(-1, 2), *row[1:]) for row in rows
    ]
    full = {p: _mesh(p, p.low, p.high) for p in prisms}
    whole = as_shape(join([*full.values()]))
    if not is_cut:
        return _Shapes(whole, None, None)
    low = [p for p in prisms if p.low < CUT_HEIGHT]
    cut = [_part(p, full[p], p.low, min(p.high, CUT_HEIGHT)) for p in low]
    lid = [
        _part(p, full[p], CUT_HEIGHT, CUT_HEIGHT + _LID)
        for p in low
        if p.high > CUT_HEIGHT
    ]
    return _Shapes(
        whole,
        as_shape(join(cut)) if cut else None,
        as_shape(join(lid)) if lid else None,
    )


def ShowCut(plant: MultibodyPlant, scene_graph: SceneGraph) -> None:
    """Shows high objects to cameras as to viewers: cut.

    For pictures from outside, in which walls would hide the scene. The plant
    has the geometry of `AddWorld`; no Context of the SceneGraph may exist yet.
    """
    inspector = scene_graph.model_inspector()
    source = plant.get_source_id()
    assert source is not None
    world = GeometrySet(inspector.world_frame_id())
    seen = {
        inspector.GetName(it): it
        for it in inspector.GetGeometryIds(world, Role.kPerception)
    }
    shown = {
        inspector.GetName(it): it
        for it in inspector.GetGeometryIds(world, Role.kIllustration)
    }
    for name, whole in seen.items():
        stem = name.removesuffix(_WHOLE)
        # Models from files may have any names.
        if name in shown or name == stem:
            continue
        parts = [it for it in (stem, stem + _SECTION) if it in shown]
        scene_graph.RemoveRole(source, whole, Role.kPerception)
        for part in parts:
            properties = inspector.GetIllustrationProperties(shown[part])
            perception = PerceptionProperties()
            if properties.HasProperty("phong", "diffuse"):
                color = properties.GetProperty("phong", "diffuse")
                perception.AddProperty("phong", "diffuse", color)
            scene_graph.AssignRole(source, shown[part], perception)


def _mesh(prism: Prism, low: float, high: float) -> TriangleMesh:
    """Returns the part of a prism between two heights."""
    if prism.material == "leaf":
        x0, y0 = prism.outline.min(axis=0)
        x1, y1 = prism.outline.max(axis=0)
        center = [(x0 + x1) / 2, (y0 + y1) / 2, (low + high) / 2]
        radii = [(x1 - x0) / 2, (y1 - y0) / 2, (high - low) / 2]
        return ellipsoid(center, radii, sides=12)
    if prism.closed:
        return extrude(prism.outline, low, high)
    return join([extrude(it, low, high) for it in _strips(prism.outline)])


def _part(
    prism: Prism, whole: TriangleMesh, low: float, high: float
) -> TriangleMesh:
    """Returns `_mesh` between two heights, given that of the whole prism."""
    if prism.material == "leaf":
        return _mesh(prism, low, high)
    z = np.where(whole.vertices[:, 2] == prism.low, low, high)
    return TriangleMesh(
        np.column_stack([whole.vertices[:, :2], z]), whole.normals, whole.faces
    )


def AddGoalMarks(
    plant: MultibodyPlant, humans: Sequence[HumanConfig], robot: Robots
) -> None:
    """Adds flat marks at the goals of people and robots.

    A robot's goal is a ring of its radius with an arrow along the final
    heading, "robot_goal", or, of several, the name and "_goal"; the goals of
    person i are targets, a ring with a dot, in the color of the shirt,
    "human_i_goal_k". Marks have no
    perception role, so simulated cameras do not see them.
    """
    mark = partial(AddVisual, plant, plant.world_body(), perceived=False)
    for i, human in enumerate(humans):
        level = i % _GOAL_LEVELS
        color = top_of(i)
        height, radius = _MARK_HIGH + 0.001 * level, goal_radius(i)
        target = as_shape(
            join(
                [
                    ring(radius - GOAL_WIDTH, radius, height),
                    disc(GOAL_DOT, height, sides=24),
                ]
            )
        )
        for k, (x, y) in enumerate(human.goals):
            X_WG = RigidTransform([x, y, 0.0])
            mark(f"human_{i}_goal_{k}", target, color, X_WG)
    for k, (name, it) in enumerate(by_name(robot).items()):
        if it.goal is not None:
            x, y, yaw = it.goal
            X_WG = RigidTransform(RollPitchYaw(0, 0, yaw), [x, y, 0])
            around = _goal_ring(it.radius)
            mark(f"{figure_of(name)}_goal", around, accent(k), X_WG)


def goal_radius(index: int) -> float:
    """Returns the radius of the marks at the goals of a person, in meters.

    Several people may have goals at one place.
    """
    return 0.19 - 0.015 * (index % _GOAL_LEVELS)


def _cuts(low: float, high: float, tile: float) -> list[float]:
    """Returns low, high, and the multiples of a tile's width between them."""
    first, last = math.floor(low / tile) + 1, math.ceil(high / tile) - 1
    return [low, *(k * tile for k in range(first, last + 1)), high]


def _strips(line: Array) -> list[Array]:
    """Returns a rectangle around each segment, half a thickness longer."""
    half = POLYLINE_THICKNESS / 2
    strips = []
    for p, q in itertools.pairwise(line):
        length = np.linalg.norm(q - p)
        along = (q - p) / length if length > 0 else np.array([1.0, 0.0])
        across = np.array([-along[1], along[0]])
        corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ends = {-1: p, 1: q}
        strips.append(
            np.array(
                [ends[a] + half * (a * along + b * across) for a, b in corners]
            )
        )
    return strips


def _goal_ring(radius: float) -> TriangleMesh:
    """Returns a ring around the origin and an arrow head along +x."""
    around = ring(0.86 * radius, radius, _MARK_HIGH)
    head = radius * np.array(
        [[0.62, 0], [-0.30, 0.42], [-0.10, 0], [-0.30, -0.42]]
    )
    return join([around, extrude(head, _MARK_LOW, _MARK_HIGH)])
