"""Ways around walls: a visibility graph of the corners of the world."""

from collections.abc import Callable
from dataclasses import dataclass
import functools
import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.world import goal_ways, hidden, waypoints
from hunav_drake.systems.world.corners import corner_vertices
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.route_clearance import LARGEST_CLEARANCE

# The part of the clearance that ways may leave at corners: so the next vertex
# comes in sight before the last one is reached.
_SIGHT = 0.95

# The number of maps that are kept, and the least number of goals of each.
_MOST_MAPS = 8
_FEWEST_GOALS = 1024


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
    """

    obstacles: Obstacles
    sight: float
    vertices: Array

    def __post_init__(self) -> None:
        # All diagrams of a process share it.
        self.vertices.setflags(write=False)

    @functools.cached_property
    def _graph(self) -> goal_ways.Graph:
        """The vertices, and which are known to see each other."""
        return goal_ways.no_ways(self.vertices)

    @functools.cached_property
    def _goals(self) -> Callable[[int], goal_ways.Goals]:
        """Returns the known ways, by the number of goals to remember."""
        no_goals = functools.partial(goal_ways.no_goals, len(self.vertices))
        return functools.cache(no_goals)

    @functools.cached_property
    def _hidden(self) -> hidden.Hidden:
        """The known hiders of vertices: see there."""
        return hidden.nothing_hidden(len(self.vertices))

    @staticmethod
    def from_obstacles(
        obstacles: Obstacles, *, clearance: float = LARGEST_CLEARANCE
    ) -> "RouteMap":
        """Returns the map of a world.

        The last maps are kept. Which vertices see each other is found when
        somebody asks for a way that may go by them.

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
        guided: Array = waypoints.guided(p, command, *self.arguments(len(p)))
        return guided if len(guided) else command

    def arguments(self, people: int) -> tuple[Any, ...]:
        """Returns the constant arguments of `waypoints.guided` for a crowd."""
        # Room for twice as many goals as people: few are in each other's way.
        goals = max(_FEWEST_GOALS, 2 << (people - 1).bit_length())
        return (
            *(self.sight, *self._graph, *self._goals(goals), *self._hidden),
            self.obstacles.table,
        )


@functools.lru_cache(maxsize=_MOST_MAPS)
def _route_map(obstacles: Obstacles, clearance: float) -> RouteMap:
    walls = _without_points(obstacles)
    sight = _SIGHT * clearance
    return RouteMap(walls, sight, corner_vertices(walls, clearance, sight))


def _without_points(obstacles: Obstacles) -> Obstacles:
    s = obstacles.segments
    long = (s[:, 0] != s[:, 2]) | (s[:, 1] != s[:, 3])
    if long.all():
        return obstacles
    first = np.concatenate([[0], np.cumsum(long)])[obstacles.first]
    return Obstacles(np.ascontiguousarray(s[long]), first, obstacles.solid)
