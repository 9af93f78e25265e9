"""The bounds of the scene."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.robot.robot_config import RobotConfig
from hunav_drake.systems.world.shapes import World


@dataclass(frozen=True)
class Bounds:
    """A rectangle along the axes of W, in meters."""

    x_min: float
    y_min: float
    x_max: float
    y_max: float

    @property
    def center(self) -> tuple[float, float]:
        """The middle, in meters."""
        return (self.x_min + self.x_max) / 2, (self.y_min + self.y_max) / 2

    @property
    def size(self) -> tuple[float, float]:
        """The lengths along x and y, in meters."""
        return self.x_max - self.x_min, self.y_max - self.y_min


def scene_bounds(
    world: World,
    humans: Sequence[HumanConfig] = (),
    robot: RobotConfig | None = None,
    *,
    margin: float = 0.0,
) -> Bounds:
    """Returns the smallest rectangle around everything that has a place.

    Walls, people and robot count, and where they go.

    Args:
        world: Walls and all else that stands there.
        humans: The people.
        robot: The robot.
        margin: How much to add on each side, in meters.

    Returns:
        The rectangle; with nothing to show, 2 m around the origin.
    """
    ends = world.obstacles().segments.reshape(-1, 2)
    places = []
    if len(ends):
        places = [(ends.min(axis=0), 0.0), (ends.max(axis=0), 0.0)]
    for human in humans:
        places += [(np.array(p[:2]), human.radius) for p in human.goals]
        places.append((np.array(human.pose[:2]), human.radius))
    if robot is not None:
        poses = [robot.start] + ([robot.goal] if robot.goal else [])
        places += [(np.array(p[:2]), robot.radius) for p in poses]
    if not places:
        places = [(np.zeros(2), 2.0)]
    low = np.min([p - r for p, r in places], axis=0) - margin
    high = np.max([p + r for p, r in places], axis=0) + margin
    return Bounds(float(low[0]), float(low[1]), float(high[0]), float(high[1]))
