"""Ways around walls: a visibility graph of the corners of the world."""

from collections.abc import Callable
from dataclasses import dataclass
import functools
import math

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.world import visibility_graph, waypoints
from hunav_drake.systems.world.corners import corner_vertices
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.route_clearance import LARGEST_CLEARANCE
from hunav_drake.systems.world.route_files import kept

# The part of the clearance that ways may leave at corners: so the next vertex
# comes in sight before the last one is reached.
_SIGHT = 0.95

# The numbers of goals, and of maps, whose ways are cached.
_MOST_GOALS = 1024
_MOST_MAPS = 8

# The number of segments from which on maps are kept on disk. Smaller ones are
# made in less time than a file takes.
KEPT_FROM = 400


@dataclass(frozen=True, eq=False)
class RouteMap:
    """The shortest ways between the corners of a world.

    The next waypoint is a pure function of the map, the position and the
    goal: a person who walks to it, and asks again at every step, arrives.
    Along the way, the remaining length falls by the length walked, so that
    nobody turns back halfway.

    Attributes:
        obstacles: The walls, without points, which do not stop a way.
        sight: The least distance of a way to walls, in meters.
        vertices: Shape (m, 2): places around convex corners, in meters.
        ways: Shape (e, 3): rows (i, j, length), the straight ways between
            vertices that see each other, in meters.
    """

    obstacles: Obstacles
    sight: float
    vertices: Array
    ways: Array

    def __post_init__(self) -> None:
        # All diagrams of a process share it.
        self.vertices.setflags(write=False)
        self.ways.setflags(write=False)

    @functools.cached_property
    def _goal(self) -> Callable[[float, float], Array]:
        """Returns `_ways_to` of a goal, from a cache for the last ones."""
        ways_to = functools.partial(
            _ways_to, self.sight, self.vertices, self.ways, self.obstacles.table
        )
        return functools.lru_cache(maxsize=_MOST_GOALS)(ways_to)

    @functools.cached_property
    def _goals(self) -> Callable[[bytes], Array]:
        """Returns `_goal` of the bytes of rows (x, y), cached for the last.

        In most steps, nobody has a new goal.
        """
        all_ways_to = functools.partial(_all_ways_to, self._goal)
        return functools.lru_cache(maxsize=1)(all_ways_to)

    @functools.cached_property
    def _hidden(self) -> waypoints.Hidden:
        """The known hiders of vertices: see there."""
        return waypoints.nothing_hidden(len(self.vertices))

    @staticmethod
    def from_obstacles(
        obstacles: Obstacles, *, clearance: float = LARGEST_CLEARANCE
    ) -> "RouteMap":
        """Returns the map of a world.

        The last maps are kept in memory, and those of large worlds
        on disk: see `route_files.py`.

        Args:
            obstacles: The walls.
            clearance: The distance of the ways from corners, in meters. Gaps
                narrower than twice that are no ways.

        Raises:
            ValueError: If ``clearance`` is not positive.
        """
        if not 0 < clearance < math.inf:
            raise ValueError(f"clearance must be positive, got {clearance} m")
        return _route_map(obstacles, float(clearance))

    def next_waypoint(self, p: ArrayLike, goal: ArrayLike) -> Array:
        """Returns the point (2,) to walk to next from p (2,), in meters.

        It is the goal (2,) itself if the straight way is free, or if there is
        no way. A goal inside a solid is approached from the nearest place
        outside of it, and is the waypoint itself near that place.
        """
        command = np.zeros((1, COMMAND_SIZE))
        x_and_y = slice(Command.GOAL_X, Command.GOAL_Y + 1)
        command[0, x_and_y] = goal
        command[0, Command.HAS_GOAL] = 1.0
        return self.guide(np.array([p], dtype=float), command)[0, x_and_y]

    def guide(self, positions: ArrayLike, command: Array) -> Array:
        """Returns commands whose goals are the next waypoints.

        A waypoint that is not the goal has a radius of zero, so that people do
        not slow down there. People without a goal, or at the goal, keep their
        commands; it is `command` itself if nothing changes. Positions may have
        more columns than x and y.
        """
        p = np.ascontiguousarray(positions, dtype=float)
        blocked = visibility_graph.needs_way(
            p, command, self.sight, self.obstacles.table
        )
        (who,) = blocked.nonzero()
        if not len(who):
            return command
        goals = command[who, Command.GOAL_X : Command.GOAL_Y + 1]
        guided: Array = waypoints.guided(
            *(p, command, who, self._goals(goals.tobytes()), self.sight),
            *(self.vertices, *self._hidden, self.obstacles.table),
        )
        return guided


@functools.lru_cache(maxsize=_MOST_MAPS)
def _route_map(obstacles: Obstacles, clearance: float) -> RouteMap:
    walls = _without_points(obstacles)
    sight = _SIGHT * clearance

    def build() -> tuple[Array, Array]:
        vertices = corner_vertices(walls, clearance, sight)
        ways: Array = visibility_graph.straight_ways(
            vertices, sight, walls.table
        )
        return vertices, ways

    if len(walls.segments) < KEPT_FROM:
        return RouteMap(walls, sight, *build())
    return RouteMap(walls, sight, *kept(f"{walls.digest} {clearance!r}", build))


def _without_points(obstacles: Obstacles) -> Obstacles:
    s = obstacles.segments
    long = (s[:, 0] != s[:, 2]) | (s[:, 1] != s[:, 3])
    if long.all():
        return obstacles
    first = np.concatenate([[0], np.cumsum(long)])[obstacles.first]
    return Obstacles(np.ascontiguousarray(s[long]), first, obstacles.solid)


def _ways_to(
    sight: float, vertices: Array, ways: Array, table: Array, x: float, y: float
) -> Array:
    """Returns the common data of all ways to a goal (x, y).

    They are the place to go to, the clearance of the last leg, and the length
    of the way from each vertex, infinite if there is none: see
    `waypoints.guided`.
    """
    place: Array = visibility_graph.standing_place(x, y, sight, table)
    for last in (sight, visibility_graph.SQUEEZED * sight):
        legs: Array = visibility_graph.straight_lengths(
            *(*place, last, vertices, table)
        )
        if np.isfinite(legs).any():
            legs = _shortest(legs, ways)
            break
    return np.concatenate([place, [last], legs])


def _all_ways_to(
    ways_to: Callable[[float, float], Array], goals: bytes
) -> Array:
    """Returns the results of `ways_to` for goals, the bytes of rows (x, y)."""
    rows = np.frombuffer(goals).reshape(-1, 2).tolist()
    return np.array([ways_to(x, y) for x, y in rows])


def _shortest(legs: Array, ways: Array) -> Array:
    """Returns the lengths (m,) of the shortest ways from vertices to a place.

    Those of the straight ways, `legs` (m,), are infinite where there is none.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    m = len(legs)
    seen = np.flatnonzero(np.isfinite(legs))
    i, j = ways[:, :2].astype(np.int32).T
    # (Some versions of SciPy take no other indices than these.)
    rows = np.concatenate([i, np.full(len(seen), m, np.int32)])
    columns = np.concatenate([j, seen.astype(np.int32)])
    lengths = np.concatenate([ways[:, 2], legs[seen]])
    graph = csr_array((lengths, (rows, columns)), shape=(m + 1, m + 1))
    shortest: Array = dijkstra(graph, directed=False, indices=m)[:m]
    return shortest
