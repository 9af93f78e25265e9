"""Features of the robot's path: its length, and its gap to walls."""

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import RADIUS, Y
from hunav_drake.systems.world.obstacles import inside, nearest_wall

if TYPE_CHECKING:
    from hunav_drake.systems.evaluation.recording import Recording


# The shortest ways keep at least this far from walls, in meters, also those
# of a robot without extent.
_LEAST_CLEARANCE = 0.05


class PathFeatures:
    """Features of the robot's N + 1 samples and the walls alone.

    `Recording.path_features` holds it. It has nothing to do with people, so
    all that is left of a recording with some of them shares it.
    """

    def __init__(self, recording: "Recording") -> None:
        self._recording = recording

    @cached_property
    def length(self) -> float:
        """The length of the robot's path, in meters."""
        return float(self._recording.features.step_lengths.sum())

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
    def shortest_to_end(self) -> Array | None:
        """The shortest way from the first to the last position.

        Shape (m, 2), in meters, both included; None if there is none, or if
        the walls are not known. It keeps the robot's radius from walls, but
        where it leaves those near its start and draws near to those by its
        end.
        """
        robot = self._recording.robot
        return self._shortest(robot[0, : Y + 1], robot[-1, : Y + 1])

    @cached_property
    def shortest_to_goal(self) -> Array | None:
        """The shortest way from the first position to the goal.

        Like `shortest_to_end`; None also without a goal.
        """
        recording = self._recording
        if recording.goal is None:
            return None
        goal = np.array(recording.goal[:2])
        return self._shortest(recording.robot[0, : Y + 1], goal)

    @property
    def _clearance(self) -> float:
        radius = float(self._recording.robot[0, RADIUS])
        return max(radius, _LEAST_CLEARANCE)

    def _shortest(self, start: Array, goal: Array) -> Array | None:
        recording = self._recording
        if not recording.walls_known:
            return None
        if not len(recording.obstacles):
            return np.array([start, goal])
        from hunav_drake.systems.world.visibility_graph import blocked

        # Only who has walls in the way needs to know about corners.
        straight = start[None], goal[None], self._clearance
        if not blocked(*straight, recording.obstacles.table)[0]:
            return np.array([start, goal])
        from hunav_drake.systems.world.routes import RouteMap

        route = RouteMap.from_obstacles(
            recording.obstacles, clearance=self._clearance
        )
        points = [start]
        for _ in range(len(route.vertices) + 1):
            points.append(route.next_waypoint(points[-1], goal))
            if (points[-1] == goal).all():
                way = np.array(points)
                # The map names the goal itself where there is no way to it,
                # and lets people squeeze through where a robot cannot.
                legs = way[:-1], way[1:], route.sight, route.obstacles.table
                return None if blocked(*legs).any() else way
        return None


def polyline_length(points: Array) -> float:
    """Returns the length of a polyline (m, 2), in meters."""
    steps = np.diff(points, axis=0)
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())
