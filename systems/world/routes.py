"""Ways around walls: a visibility graph of the corners of the world."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
import functools
import math
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.world import visibility_graph
from hunav_drake.systems.world.obstacles import Obstacles

Array = NDArray[np.float64]

# A door that everybody finds is a little wider than twice this, in meters.
_LARGEST_CLEARANCE = 0.3

# Ways may pass corners this much nearer than the vertices lie: so the next
# vertex comes in sight before the last one is reached.
_SIGHT = 0.95

# Ways are remembered for so many goals.
_MOST_GOALS = 1024

# Smaller angles are straight on, in radians.
_STRAIGHT = 1e-6


def route_clearance(radii: ArrayLike) -> float:
    """Returns the clearance of the ways of a crowd, in meters.

    Args:
        radii: Shape (n,), in meters.

    Returns:
        The largest radius, but at most 0.3 m: doors of 0.7 m are ways for
        everybody, as they are in reality for people who turn sideways.
    """
    largest = np.asarray(radii, dtype=float).max(initial=0.0)
    return min(float(largest), _LARGEST_CLEARANCE)


@dataclass(frozen=True, eq=False)
class RouteMap:
    """The shortest ways between the corners of a world.

    The next waypoint is a pure function of the map, the position and the
    goal: a person who walks to it, and asks again at every step, arrives.
    Along the way the length of what remains falls by what is walked, so
    nobody turns back halfway.

    Attributes:
        segments: Shape (s, 4): see `Obstacles`. Points do not stop a way, and
            are left out.
        first: Shape (k + 1,): see `Obstacles`.
        solid: Shape (k,): see `Obstacles`.
        sight: The least distance of a way to walls, in meters.
        vertices: Shape (m, 2): places around convex corners, in meters.
        lengths: Shape (m, m): the lengths of the shortest ways between them,
            in meters; infinity where there is none.
    """

    segments: Array
    first: NDArray[np.int64]
    solid: NDArray[np.bool_]
    sight: float
    vertices: Array
    lengths: Array

    # What `_ways_to` gives for a goal, kept for the goals asked for last. It
    # is a pure function, so this changes no result, and threads may share it.
    _goal: Callable[[float, float], tuple[Array, float, Array]] = field(
        init=False, repr=False
    )

    def __post_init__(self) -> None:
        ways = functools.partial(
            _ways_to,
            *(self.sight, self.segments, self.first, self.solid),
            *(self.vertices, self.lengths),
        )
        object.__setattr__(
            self, "_goal", functools.lru_cache(maxsize=_MOST_GOALS)(ways)
        )

    @classmethod
    def from_obstacles(
        cls, obstacles: Obstacles, *, clearance: float = _LARGEST_CLEARANCE
    ) -> Self:
        """Makes the map of a world.

        Args:
            obstacles: The walls.
            clearance: How far around corners the ways lead, in meters. Gaps
                narrower than twice that are no ways.

        Raises:
            ValueError: If ``clearance`` is not positive.
        """
        if not 0 < clearance < math.inf:
            raise ValueError(f"clearance must be positive, got {clearance} m")
        from scipy.sparse.csgraph import shortest_path

        s = obstacles.segments
        long = (s[:, 0] != s[:, 2]) | (s[:, 1] != s[:, 3])
        first = np.concatenate([[0], np.cumsum(long)])[obstacles.first]
        segments = np.ascontiguousarray(s[long])
        solid = obstacles.solid
        sight = _SIGHT * clearance
        found: list[Array] = []
        for k in range(len(solid)):
            shape = segments[first[k] : first[k + 1]]
            for corner, normal, turn in _corners(shape, bool(solid[k])):
                # Where there is no room for the points of a wide bend, those
                # of a closer one may still have it.
                for parts in (1, 2, 4):
                    points = _bend(corner, normal, turn, clearance, parts)
                    free = visibility_graph.free_points(
                        points, sight, segments, first, solid
                    )
                    found.append(points[free])
                    if free.all():
                        break
        vertices = np.vstack([np.zeros((0, 2)), *found])
        _, which = np.unique(vertices.round(9), axis=0, return_index=True)
        vertices = vertices[np.sort(which)]
        lengths = visibility_graph.straight_lengths(vertices, sight, segments)
        if len(vertices):
            lengths = shortest_path(lengths, directed=False)
        return cls(segments, first, solid, sight, vertices, lengths)

    def next_waypoint(self, p: ArrayLike, goal: ArrayLike) -> Array:
        """Returns the point to walk to next, for one person.

        See `waypoints`.
        """
        waypoints = self.waypoints(np.atleast_2d(p), np.atleast_2d(goal))
        return waypoints.reshape(2)

    def waypoints(self, positions: ArrayLike, goals: ArrayLike) -> Array:
        """Returns the points to walk to next.

        The goal itself if the straight way is free, or if there is no way. A
        goal inside a solid is approached from the nearest place outside of
        it, and is the waypoint itself near that place.

        Args:
            positions: Shape (n, 2 or more): x, y, ..., in meters.
            goals: Shape (n, 2), in meters.

        Returns:
            Shape (n, 2), in meters.
        """
        p = np.ascontiguousarray(positions, dtype=float)
        result = np.array(goals, dtype=float, order="C")
        blocked = visibility_graph.blocked(p, result, self.sight, self.segments)
        for i in np.flatnonzero(blocked):
            result[i] = self._waypoint(p[i], result[i])
        return result

    def guide(self, positions: ArrayLike, command: Array) -> Array:
        """Returns commands whose goals are the next waypoints.

        A waypoint that is not the goal has a radius of zero, so that people
        do not slow down there. People without a goal, or at the goal, keep
        their commands.

        Args:
            positions: Shape (n, 2 or more): x, y, ..., in meters.
            command: Shape (n, COMMAND_SIZE).

        Returns:
            Shape (n, COMMAND_SIZE); `command` itself if nothing changes.
        """
        p = np.ascontiguousarray(positions, dtype=float)
        blocked = visibility_graph.needs_way(
            p, command, self.sight, self.segments
        )
        if not blocked.any():
            return command
        result = command.copy()
        goal_xy = [Command.GOAL_X, Command.GOAL_Y]
        for i in np.flatnonzero(blocked):
            goal = command[i, goal_xy]
            waypoint = self._waypoint(p[i], goal)
            if (waypoint != goal).any():
                result[i, goal_xy] = waypoint
                result[i, Command.GOAL_RADIUS] = 0.0
        return result

    def _waypoint(self, p: Array, goal: Array) -> Array:
        """Returns the next waypoint to a goal that is not seen from p."""
        known = self._goal(float(goal[0]), float(goal[1]))
        result: Array = visibility_graph.waypoint(
            *(p, goal, *known, self.sight, self.vertices, self.segments)
        )
        return result


def _ways_to(
    sight: float,
    segments: Array,
    first: NDArray[np.int64],
    solid: NDArray[np.bool_],
    vertices: Array,
    lengths: Array,
    x: float,
    y: float,
) -> tuple[Array, float, Array]:
    """Returns what is the same on all ways to a goal (x, y).

    The place to go to, the clearance of the last leg, and the length of the
    way from each vertex: see `visibility`.
    """
    place: Array = visibility_graph.standing_place(
        x, y, sight, segments, first, solid
    )
    for last in (sight, visibility_graph.SQUEEZED * sight):
        to_place: Array = visibility_graph.lengths_to_goal(
            *(*place, last, vertices, lengths, segments)
        )
        if np.isfinite(to_place).any():
            break
    return place, last, to_place


def _corners(
    segments: Array, solid: bool
) -> Iterator[tuple[Array, float, float]]:
    """Yields the convex corners of a shape that people walk around.

    Args:
        segments: Shape (s, 4), none of length zero, one after the other.
        solid: Whether they close around a solid.

    Yields:
        A corner (2,), the direction of the normal of the wall before it, and
        the angle by which the normal turns there, in radians. The end of a
        thin wall turns by pi.
    """
    if len(segments) == 0:
        return
    if solid and _area(segments) < 0:
        segments = segments[::-1, [2, 3, 0, 1]]
    angles = np.arctan2(
        segments[:, 3] - segments[:, 1], segments[:, 2] - segments[:, 0]
    )
    closed = bool((segments[0, :2] == segments[-1, 2:]).all())
    if not closed:
        yield segments[0, :2], angles[0] + math.pi / 2, math.pi
        yield segments[-1, 2:], angles[-1] - math.pi / 2, math.pi
    for i in range(0 if closed else 1, len(segments)):
        turn = math.remainder(angles[i] - angles[i - 1], 2 * math.pi)
        # To the left of a solid's outline is its inside.
        if turn > _STRAIGHT or (turn < -_STRAIGHT and not solid):
            side = math.copysign(math.pi / 2, turn)
            yield segments[i, :2], angles[i - 1] - side, turn


def _area(segments: Array) -> float:
    """Returns twice the area of an outline, positive if it turns left."""
    x0, y0, x1, y1 = (segments - np.tile(segments[0, :2], 2)).T
    return float(np.sum(x0 * y1 - x1 * y0))


def _bend(
    corner: Array, normal: float, turn: float, clearance: float, parts: int
) -> Array:
    """Returns the points of a way around a corner, at the clearance from it.

    They are the corners of a polygon around the arc with that radius, with
    `parts` of them for each quarter turn or less.
    """
    count = parts * math.ceil(abs(turn) / (math.pi / 2) - _STRAIGHT)
    angles = normal + turn * (np.arange(count) + 0.5) / count
    radius = clearance / math.cos(turn / count / 2)
    points: Array = corner + radius * np.column_stack(
        [np.cos(angles), np.sin(angles)]
    )
    return points
