"""The bounds of the scene."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import math

import numpy as np
from pydrake.math import RotationMatrix

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.robot.robot_config import RobotConfig
from hunav_drake.systems.world.shapes import World

# The elevation of the overview camera, in radians: walls of 1 m hide little.
ELEVATION = math.radians(48.0)


@dataclass(frozen=True)
class Bounds:
    """A rectangle along the axes of W, in meters."""

    x_min: float
    y_min: float
    x_max: float
    y_max: float

    @property
    def center(self) -> tuple[float, float]:
        """The center, in meters."""
        return (self.x_min + self.x_max) / 2, (self.y_min + self.y_max) / 2

    @property
    def size(self) -> tuple[float, float]:
        """The lengths along x and y, in meters."""
        return self.x_max - self.x_min, self.y_max - self.y_min


# One robot, or several by their names.
Robots = RobotConfig | Mapping[str, RobotConfig] | None


def by_name(robot: Robots) -> Mapping[str, RobotConfig]:
    """Returns robots by their names; that of a single one is empty."""
    if robot is None:
        return {}
    return {"": robot} if isinstance(robot, RobotConfig) else robot


def figure_of(name: str) -> str:
    """Returns the name of a robot's figure."""
    return name or "robot"


def port_of(name: str, port: str) -> str:
    """Returns the name of a port about a robot."""
    return f"{name}_{port}" if name else port


def scene_bounds(
    world: World,
    humans: Sequence[HumanConfig] = (),
    robot: Robots = None,
    *,
    margin: float = 0.0,
) -> Bounds:
    """Returns the smallest rectangle around everything in the scene.

    Walls, people, robot and goals count, and a margin on each side, in meters.
    In an empty scene, it is 2 m around the origin.
    """
    ends = world.obstacles().segments.reshape(-1, 2)
    places = []
    if len(ends):
        places = [(ends.min(axis=0), 0.0), (ends.max(axis=0), 0.0)]
    places += [
        (corner, 0.0)
        for it in world.furniture
        if not it.footprints()
        for solid in it.solids()
        for corner in solid.outline
    ]
    for human in humans:
        places += [(np.array(p[:2]), human.radius) for p in human.goals]
        places.append((np.array(human.pose[:2]), human.radius))
    for it in by_name(robot).values():
        poses = [it.start] + ([it.goal] if it.goal else [])
        places += [(np.array(p[:2]), it.radius) for p in poses]
    if not places:
        places = [(np.zeros(2), 2.0)]
    low = np.min([p - r for p, r in places], axis=0) - margin
    high = np.max([p + r for p, r in places], axis=0) + margin
    return Bounds(float(low[0]), float(low[1]), float(high[0]), float(high[1]))


def view_axes(bounds: Bounds) -> tuple[Array, Array]:
    """Returns the right and ahead directions of the overview, in W.

    The longer side of the bounds is along the width of the picture.
    """
    width, depth = bounds.size
    right = np.array([1.0, 0.0, 0.0] if width >= depth else [0.0, 1.0, 0.0])
    return right, np.array([-right[1], right[0], 0.0])


def overview_rotation(bounds: Bounds) -> RotationMatrix:
    """Returns R_WC of the overview: right, up and backwards, in W."""
    right, ahead = view_axes(bounds)
    s, c = math.sin(ELEVATION), math.cos(ELEVATION)
    above = np.array([0.0, 0.0, 1.0])
    axes = [right, s * ahead + c * above, s * above - c * ahead]
    return RotationMatrix(np.column_stack(axes))
