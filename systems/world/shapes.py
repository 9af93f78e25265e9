"""The fixed world: walls and furniture, and the same as arrays of segments."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import field
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field, StrictBool
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.common.schema import (
    CONFIG,
    Angle,
    FilePath,
    Name,
    Point,
    Points,
    Pose,
    PositiveLength,
    Size,
)
from hunav_drake.systems.world.furniture import FURNITURE, Furniture
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.solids import Fixture, Prism, fine_disc, turned

# Corners nearer to each other than this are one, in meters.
SAME_CORNER = 1e-3

# The height of people's eyes, in meters.
EYE_HEIGHT = 1.6

# The height of walls, in meters.
WALL_HEIGHT = 2.5


@explain
@dataclass(kw_only=True, config=CONFIG)
class Wall(ABC):
    """The common options of all shapes of walls."""

    solid: ClassVar[bool] = True
    """Whether it has an inside, where nobody can be."""

    name: Name = ""
    """Name in messages and in the scene."""

    height: PositiveLength = WALL_HEIGHT
    """Height, in meters: above 1.6 m, a wall hides people. Walls higher than
    people are drawn cut, so that one sees into rooms."""

    @abstractmethod
    def vertices(self) -> Array:
        """Returns the points of its outline in W, shape (k, 2), in meters.

        For a solid shape, the last joins the first.
        """

    def solids(self) -> list[Prism]:
        """Returns its solids: one upright prism."""
        return [Prism(self.vertices(), 0.0, self.height, closed=self.solid)]


WALLS = Registry("wall shape", Wall)

register_wall = WALLS.register


@register_wall("box")
@dataclass(kw_only=True, config=CONFIG)
class Box(Wall):
    """A solid rectangle: a wall with its thickness, a block, a box."""

    center: Point
    """Center, in meters."""

    size: Size
    """Full extents along its own axes, in meters."""

    yaw: Angle = 0.0
    """Rotation about the vertical, in radians."""

    def vertices(self) -> Array:
        """Returns the four corners, counter-clockwise, shape (4, 2)."""
        half = np.array(self.size) / 2
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
        return turned(corners, (*self.center, self.yaw))


@register_wall("disc")
@dataclass(kw_only=True, config=CONFIG)
class Disc(Wall):
    """A solid disc: a column, a trunk, a bollard."""

    center: Point
    """Center, in meters."""

    radius: PositiveLength
    """Radius, in meters."""

    def vertices(self) -> Array:
        """Returns a regular polygon (k, 2) with its area, within 5 mm of it."""
        return fine_disc(*self.center, self.radius)


@register_wall("polygon")
@dataclass(kw_only=True, config=CONFIG)
class Polygon(Wall):
    """A solid simple polygon, in either direction of rotation."""

    points: Annotated[Points, Field(min_length=3)]
    """Corners, at least three, in meters; the last joins the first."""

    def vertices(self) -> Array:
        """Returns the corners, shape (k, 2); those within 1 mm are one."""
        points = np.array(self.points, dtype=float)
        kept = apart(points, closed=True)
        return kept if len(kept) > 2 else points


@register_wall("polyline")
@dataclass(kw_only=True, config=CONFIG)
class Polyline(Wall):
    """A thin wall along a line of points, drawn 5 cm thick."""

    solid: ClassVar[bool] = False

    points: Annotated[Points, Field(min_length=2)]
    """Points, at least two, in meters."""

    def vertices(self) -> Array:
        """Returns the points, shape (k, 2); those within 1 mm are one."""
        points = np.array(self.points, dtype=float)
        kept = apart(points, closed=False)
        return kept if len(kept) > 1 else points


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class Model:
    """Models of a file: SDF, a world of Gazebo, URDF or model directives.

    People and robots walk around its collision geometries between 0.05 and
    1.8 m: around meshes of worlds and models of Gazebo as they are, around
    those of other files as their convex hulls.
    """

    name: Name = ""
    """Name in messages."""

    file: FilePath
    """File: a path, relative to the scenario file, or a file in a package, as
    "package://hunav_drake/..."."""

    pose: Pose = (0.0, 0.0, 0.0)
    """Pose (x, y, yaw) in W, in meters and radians."""

    model_path: list[FilePath] = field(default_factory=list)
    """Folders in which the models that a world of Gazebo names are searched
    first: then follow those of GAZEBO_MODEL_PATH, GZ_SIM_RESOURCE_PATH and the
    like, folders named `models` near the file, and those of Fuel."""

    skip_missing: StrictBool = False
    """Whether models and meshes that a world of Gazebo names, and that are not
    there, are left out; otherwise they are faults."""


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class World:
    """Everything that does not move."""

    walls: list[Annotated[Wall, WALLS]] = field(default_factory=list)
    """Walls. Each pushes people away from its nearest point, so a room is four
    walls, not one outline."""

    furniture: list[Annotated[Furniture, FURNITURE]] = field(
        default_factory=list
    )
    """Tables, chairs, shelves, ...: see docs/worlds.md."""

    map: FilePath | None = None
    """YAML file of a map of ROS 2's map_server, relative to the scenario file:
    its occupied cells are walls of 2.5 m."""

    models: list[Model] = field(default_factory=list)
    """Models of files: racks, machines, a whole building."""

    def fixtures(self) -> list[Fixture]:
        """Returns all things in the world, each with its place in it.

        Raises:
            WorldFileError: If the map or a model cannot be read.
        """
        return [
            *(
                Fixture(("walls", i), [it.vertices()], it.solid, it.solids())
                for i, it in enumerate(self.walls)
            ),
            *(
                Fixture(
                    ("furniture", i),
                    it.footprints(),
                    True,
                    [*it.solids(), *it.letters()],
                )
                for i, it in enumerate(self.furniture)
            ),
            *self._files(),
        ]

    def _files(self) -> list[Fixture]:
        """Returns what is read from files."""
        return [
            *_map_fixtures(self.map),
            *(_model_fixture(i, it) for i, it in enumerate(self.models)),
        ]

    def obstacles(self) -> Obstacles:
        """Returns the footprints of everything, which one walks around."""
        # (As of `fixtures`, without their solids, which take longer.)
        shapes = [
            *((it.vertices(), it.solid) for it in self.walls),
            *((p, True) for it in self.furniture for p in it.footprints()),
            *((p, it.closed) for it in self._files() for p in it.footprints),
        ]
        return _obstacles(shapes)

    def obstacles_at(self, height: float) -> Obstacles:
        """Returns the cuts of a horizontal plane with everything.

        At 0.2 m, for example, they are the legs of a table, as a lidar meets
        them. At a height where one part ends and another begins, the upper one
        counts.

        Args:
            height: The height of the plane over the floor, in meters.
        """
        cuts = [
            (outline, solid.closed)
            for fixture in self.fixtures()
            for solid in fixture.solids
            for outline in solid.cuts(height)
        ]
        return _obstacles(cuts)

    def sight_obstacles(self) -> Obstacles:
        """Returns the obstacles that people cannot see over or through.

        They are those at the height of their eyes, `EYE_HEIGHT`.
        """
        return self.obstacles_at(EYE_HEIGHT)


def apart(points: Array, *, closed: bool) -> Array:
    """Returns points (k, 2) without those within 1 mm of the one before.

    If they are closed, the first comes after the last, too.
    """
    steps = np.diff(points, axis=0, append=points[:1])
    close = np.hypot(*steps.T) < SAME_CORNER
    if not close[: len(points) - (not closed)].any():
        return points
    kept = [0]
    for i, point in enumerate(points):
        if np.hypot(*(point - points[kept[-1]])) >= SAME_CORNER:
            kept.append(i)
    if closed and np.hypot(*(points[kept[-1]] - points[0])) < SAME_CORNER:
        kept = kept[:-1] or kept
    return points[kept]


def _map_fixtures(filename: str | None) -> list[Fixture]:
    if filename is None:
        return []
    # Imported here, as most worlds do without libraries that read images.
    from hunav_drake.systems.world.maps.map_file import map_outlines

    outlines = map_outlines(filename)
    walls = [Prism(it, 0.0, WALL_HEIGHT) for it in outlines]
    return [Fixture(("map",), outlines, True, walls)]


def _model_fixture(index: int, model: Model) -> Fixture:
    # Imported here, as most worlds do without Drake.
    from hunav_drake.systems.world.models import model_solids

    options = model.model_path, model.skip_missing
    found = model_solids(model.file, model.pose, *options)
    return Fixture(("models", index), found.footprints, True, found.solids)


def _obstacles(shapes: Sequence[tuple[Array, bool]]) -> Obstacles:
    return Obstacles.from_shapes(
        [outline for outline, _ in shapes],
        solid=[closed for _, closed in shapes],
    )
