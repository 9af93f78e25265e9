"""Features of the robot's path: its length and its gap to walls."""

from functools import cached_property

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import RADIUS, Y
from hunav_drake.systems.common.poses import wrap_angles
from hunav_drake.systems.evaluation.features import Features
from hunav_drake.systems.evaluation.recorded_arrays import RecordedArrays
from hunav_drake.systems.evaluation.way import Way
from hunav_drake.systems.world.obstacles import inside, nearest_wall

# The minimum clearance of the shortest paths, in meters, also for a robot of
# radius 0.
_LEAST_CLEARANCE = 0.05

# Positions nearer to the previous one are not new points of the path, in
# meters: the direction of such steps is noise.
_LEAST_STEP = 0.05


class PathFeatures:
    """Features of the robot's N + 1 samples and the walls alone.

    `Recording.path_features` holds it. It does not depend on people, so parts
    of a recording with fewer people share it.
    """

    def __init__(self, recording: RecordedArrays, features: Features) -> None:
        self._recording = recording
        self._features = features

    @cached_property
    def length(self) -> float:
        """The length of the robot's path, in meters."""
        return float(self._features.step_lengths.sum())

    @cached_property
    def wall_gap(self) -> Array:
        """The gap between robot and nearest wall, shape (N + 1,), in meters.

        0 where they overlap; NaN where there is no wall, and if the walls are
        not known.
        """
        recording = self._recording
        robot = recording.robot
        p = robot[:, : Y + 1]
        if recording.nearest_walls is not None:
            walls = recording.nearest_walls[:, 0]
        else:
            walls = nearest_wall(recording.obstacles, p)[:, None]
        distance = np.fmin.reduce(
            np.hypot(
                walls[..., 0] - p[:, None, 0], walls[..., 1] - p[:, None, 1]
            ),
            axis=1,
            initial=np.nan,
        )
        gap: Array = np.maximum(distance - robot[:, RADIUS], 0.0)
        if recording.nearest_walls is None and len(recording.obstacles):
            gap[inside(recording.obstacles, p).any(axis=1)] = 0.0
        return gap

    @cached_property
    def turns(self) -> tuple[Array, Array]:
        """The points of the path, and the turns at inner points.

        Shapes (m, 2), in meters, and (m - 2,), in radians, unsigned: the
        changes of the direction of motion.
        """
        points = _thinned(self._recording.robot[:, : Y + 1], _LEAST_STEP)
        steps = np.diff(points, axis=0)
        headings = np.arctan2(steps[:, 1], steps[:, 0])
        return points, np.abs(wrap_angles(np.diff(headings)))

    @cached_property
    def shortest_to_end(self) -> list[Way]:
        """The shortest paths from the first to the last position.

        Several if they are equally long; none if there is no path, or if the
        walls are not known. They keep the robot's radius from walls, except
        where they leave walls near the start and approach walls near the end.
        """
        robot = self._recording.robot
        return self._shortest(robot[-1, : Y + 1])

    @cached_property
    def shortest_to_goal(self) -> list[Way]:
        """The shortest paths from the first position to the goal.

        Like `shortest_to_end`; none also without a goal.
        """
        goal = self._recording.goal
        return [] if goal is None else self._shortest(np.array(goal[:2]))

    def _shortest(self, end: Array) -> list[Way]:
        recording = self._recording
        if not recording.walls_known:
            return []
        start = recording.robot[0, : Y + 1]
        if not len(recording.obstacles):
            return [Way.straight(start, end)]
        # Imported here, so that only worlds with walls load compiled code.
        from hunav_drake.systems.evaluation.shortest_way import shortest_ways

        radius = max(float(recording.robot[0, RADIUS]), _LEAST_CLEARANCE)
        return shortest_ways(start, end, radius, recording.obstacles)


def _thinned(points: Array, spacing: float) -> Array:
    """Returns the points (m, 2) at least `spacing` from the last one kept."""
    kept = [0]
    x, y = points.T.tolist()
    for k in range(1, len(points)):
        dx, dy = x[k] - x[kept[-1]], y[k] - y[kept[-1]]
        # (Steps of just this length differ by rounding, wherever they are.)
        if dx * dx + dy * dy >= spacing * spacing * (1 - 1e-6):
            kept.append(k)
    return points[kept]


def polyline_length(points: Array) -> float:
    """Returns the length of a polyline (m, 2), in meters."""
    steps = np.diff(points, axis=0)
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())
