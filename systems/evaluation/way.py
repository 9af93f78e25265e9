"""What the robot's path has to do with the walls, computed once for all."""

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.layout import RADIUS, Y
from hunav_drake.systems.obstacles import inside, nearest_points
from hunav_drake.systems.sight import wall_on_line

if TYPE_CHECKING:
    from hunav_drake.systems.crowd.route import RouteMap
    from hunav_drake.systems.evaluation.recording import Recording

Array = NDArray[np.float64]

# The shortest ways keep at least this far from walls, in meters, also those
# of a robot without extent.
_LEAST_CLEARANCE = 0.05


class Way:
    """What follows from the robot's N + 1 samples and the walls alone.

    `Recording.way` holds it. It has nothing to do with people, so all that is
    left of a recording with some of them shares it.
    """

    def __init__(self, recording: "Recording") -> None:
        self._recording = recording

    @cached_property
    def length(self) -> float:
        """The length of the robot's path, in meters."""
        return float(self._recording.derived.step_lengths.sum())

    @cached_property
    def wall_gap(self) -> Array:
        """The gap between robot and nearest wall, shape (N + 1,), in meters.

        0 where they overlap; NaN where there is no wall.
        """
        recording = self._recording
        robot = recording.robot
        p = robot[:, : Y + 1]
        if recording.nearest_walls is not None:
            walls = recording.nearest_walls[:, 0]
        else:
            walls = nearest_points(recording.obstacles, p)
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

        Shape (m, 2), in meters, both included; None if there is none.
        """
        robot = self._recording.robot
        return self._shortest(robot[0, : Y + 1], robot[-1, : Y + 1])

    @cached_property
    def shortest_to_goal(self) -> Array | None:
        """The shortest way from the first position to the goal.

        Shape (m, 2), in meters, both included; None if there is none.
        """
        recording = self._recording
        if recording.goal is None:
            return None
        goal = np.array(recording.goal[:2])
        return self._shortest(recording.robot[0, : Y + 1], goal)

    @cached_property
    def _route_map(self) -> "RouteMap":
        # Only who has walls in the way needs to know about corners.
        from hunav_drake.systems.crowd.route import RouteMap

        radius = float(self._recording.robot[0, RADIUS])
        return RouteMap.from_obstacles(
            self._recording.obstacles, clearance=max(radius, _LEAST_CLEARANCE)
        )

    def _shortest(self, start: Array, goal: Array) -> Array | None:
        segments = self._recording.obstacles.segments

        def free(p: Array, q: Array) -> bool:
            return bool(wall_on_line(*p, *q, segments) == np.inf)

        if free(start, goal):
            return np.array([start, goal])
        points = [start]
        for _ in range(len(self._route_map.vertices) + 1):
            points.append(self._route_map.next_waypoint(points[-1], goal))
            if (points[-1] == goal).all():
                # The map names the goal itself where there is no way to it.
                return np.array(points) if free(*points[-2:]) else None
        return None


def polyline_length(points: Array) -> float:
    """Returns the length of a polyline (m, 2), in meters."""
    steps = np.diff(points, axis=0)
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())
