"""Bodies from a lidar scan, for planners that need bodies, not cells."""

import math

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import RADIUS, STATE_SIZE, X, Y
from hunav_drake.systems.planning.planner import PlanningTask, View
from hunav_drake.systems.sensing.scans import scan_points
from hunav_drake.systems.world.obstacles import nearest_wall

# The radius of the disc at a hit, for both legs of a person, in meters.
BODY_RADIUS = 0.2

# Points within these distances of a wall of the map, or of the center of a
# known person, belong to them; points near the last body belong to it. In
# meters.
_NEAR_WALL = 0.1
_NEAR_PERSON = 0.4
_SAME_BODY = 0.2


def bodies(task: PlanningTask, view: View, reach: float = math.inf) -> Array:
    """Returns the bodies to avoid: people, and lidar hits other than walls.

    Without a scan these are the people that the planner sees. With one, each
    object within `reach` (in meters) that is neither a wall of the map nor a
    known person is a body at rest. Shape (k, 7), rows of `human_states`.
    """
    humans = np.ascontiguousarray(view.humans, dtype=float)
    if view.scan is None:
        return humans
    assert task.lidar is not None
    points = scan_points(task.lidar, view.scan, view.robot)
    away = np.hypot(*(points - view.robot[:2]).T)
    points = points[away < reach]
    # (From the robot, not from the lidar on it.)
    near = _NEAR_WALL + 3.0 * task.lidar.deviation(away[away < reach])
    if len(points) and len(task.obstacles):
        offsets = points - nearest_wall(task.obstacles, points)
        points = points[np.hypot(*offsets.T) > near]
    if len(points) and len(humans):
        to_people = points[:, None] - humans[None, :, [X, Y]]
        nearest = np.hypot(to_people[..., 0], to_people[..., 1]).min(axis=1)
        points = points[nearest > _NEAR_PERSON]
    met: list[tuple[float, float]] = []
    for x, y in points.tolist():
        if not met or math.dist(met[-1], (x, y)) > _SAME_BODY:
            met.append((x, y))
    rows = np.zeros((len(met), STATE_SIZE))
    rows[:, RADIUS] = BODY_RADIUS
    if met:
        rows[:, [X, Y]] = met
    return np.vstack([humans, rows])
