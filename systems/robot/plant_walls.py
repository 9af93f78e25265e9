"""The floor and the walls of a world as collision geometry."""

import math

import numpy as np
from pydrake.geometry import Box, Cylinder, GeometryId
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.solids import as_disc

# Friction of rubber on a floor, and of a shell on a wall.
_FLOOR_FRICTION = CoulombFriction(0.9, 0.9)
_WALL_FRICTION = CoulombFriction(0.3, 0.3)

# The height of walls, the thickness of the shell of solids, to the inside, and
# that of lines, in meters.
_HEIGHT, _SHELL, _LINE = 2.0, 0.02, 0.002

# The width and the thickness of the floor, in meters. (An infinite half space
# crashes Drake's contact search with about 50 other geometries.)
_FLOOR_SIZE, _FLOOR_THICKNESS = 20e3, 10.0


def AddFloorAndWalls(
    plant: MultibodyPlant, obstacles: Obstacles, middle: tuple[float, float]
) -> GeometryId:
    """Adds the floor at z = 0 and an upright box for each wall segment.

    A round solid is a cylinder. The floor ends 10 km from `middle`, (x, y) in
    W, in meters. Solids have their surface at their outline; a line is 2 mm
    thick. The plant is registered with a SceneGraph and not finalized yet. The
    floor is returned.
    """
    world = plant.world_body()
    floor: GeometryId = plant.RegisterCollisionGeometry(
        world,
        RigidTransform([*middle, -_FLOOR_THICKNESS / 2]),
        Box(_FLOOR_SIZE, _FLOOR_SIZE, _FLOOR_THICKNESS),
        "floor",
        _FLOOR_FRICTION,
    )
    first = obstacles.first.tolist()
    count = 0
    for solid, begin, end in zip(
        obstacles.solid, first[:-1], first[1:], strict=True
    ):
        segments = obstacles.segments[begin:end]
        if solid and (found := as_disc(segments[:, :2])):
            plant.RegisterCollisionGeometry(
                world,
                RigidTransform([*found[:2], _HEIGHT / 2]),
                Cylinder(found[2], _HEIGHT),
                f"wall_{count}",
                _WALL_FRICTION,
            )
            count += 1
            continue
        inwards = 0.0
        if solid:
            inwards = _SHELL / 2 * (1 if _area(segments) >= 0 else -1)
        for x0, y0, x1, y1 in segments.tolist():
            dx, dy = x1 - x0, y1 - y0
            length = math.hypot(dx, dy)
            nx, ny = (-dy / length, dx / length) if length else (0.0, 0.0)
            X_WG = RigidTransform(
                RollPitchYaw(0, 0, math.atan2(dy, dx)),
                [
                    (x0 + x1) / 2 + inwards * nx,
                    (y0 + y1) / 2 + inwards * ny,
                    _HEIGHT / 2,
                ],
            )
            thickness = _SHELL if solid else _LINE
            plant.RegisterCollisionGeometry(
                world,
                X_WG,
                Box(max(length, _LINE), thickness, _HEIGHT),
                f"wall_{count}",
                _WALL_FRICTION,
            )
            count += 1
    return floor


def _area(segments: Array) -> float:
    """Returns the area inside segments, positive if counterclockwise."""
    x0, y0, x1, y1 = segments.T
    return float(np.sum(x0 * y1 - x1 * y0)) / 2
