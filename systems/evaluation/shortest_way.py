"""The shortest path of a disc around walls: straight legs and arcs.

A disc of radius r is clear of the walls where its center is outside all walls
inflated by r. Around these, the shortest path is a taut string: it bends on
circles of radius r around corners of the walls, and follows common tangents of
two circles between them. An A* search over the tangents finds it. (People use
`routes.py` instead, which gives the next step of many people quickly, without
arcs.)

Angles at a circle are directions from its center, in radians; a turn is 1 for
counterclockwise, -1 for clockwise.
"""

from dataclasses import dataclass
import heapq
import itertools
import math

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.poses import wrap_angle, wrap_angles
from hunav_drake.systems.evaluation.way import Way
from hunav_drake.systems.world.obstacles import (
    Obstacles,
    nearest_points,
    nearest_wall,
)
from hunav_drake.systems.world.visibility_graph import blocked, free_points

# Tolerances of equal lengths, in meters, of points at one corner, in meters,
# and of equal angles, in radians.
_SAME = 1e-9
_ONE_CORNER = 1e-6
_SAME_ANGLE = 1e-6

# The maximum number of pushes of a point away from its nearest wall.
_MOST_PUSHES = 20


@dataclass(frozen=True)
class _Step:
    """A point where a path reaches a circle, and the path to it."""

    circle: int
    turn: int
    angle: float
    length: float
    turning: float
    first_heading: float


def shortest_ways(
    start: Array, goal: Array, radius: float, obstacles: Obstacles
) -> list[Way]:
    """Returns the shortest paths of a disc; several if they are equally long.

    A disc that overlaps a wall at the start leaves it on a straight leg: one
    along which the distance only grows, or the one to a clear point beside.
    Likewise at the goal.

    Args:
        start: The first position of the center (2,), in W, in meters.
        goal: The last position (2,).
        radius: The radius of the disc, positive, in meters.
        obstacles: The walls; a point is a wall without length.

    Returns:
        The paths; none if there is no path, as from or to the inside of a
        solid.
    """
    leg = start[None], goal[None]
    if not blocked(*leg, radius, obstacles.joined.table)[0]:
        return [Way.straight(start, goal)]
    # No path leads into a solid from outside.
    if not free_points(np.array([start, goal]), 0.0, obstacles.table).all():
        return []
    ways = [
        Way.straight(start, first).then(way).then(Way.straight(last, goal))
        for first in _begins(start, radius, obstacles)
        for last in _begins(goal, radius, obstacles)
        for way in _ways_between(first, last, radius, obstacles)
    ]
    least = min((way.length for way in ways), default=0.0)
    return [way for way in ways if way.length <= least + _SAME]


def _begins(p: Array, radius: float, obstacles: Obstacles) -> list[Array]:
    """Returns a point, and a clear one beside it if walls are too near."""
    place = p
    for _ in range(_MOST_PUSHES):
        if free_points(place[None], radius - _SAME, obstacles.table)[0]:
            break
        wall = nearest_wall(obstacles, place)
        distance = math.hypot(*(place - wall))
        if distance < _SAME:
            return [p]
        place = wall + (place - wall) * (radius / distance)
    else:
        return [p]
    leg = p[None], place[None]
    if place is p or blocked(*leg, _ONE_CORNER, obstacles.table)[0]:
        return [p]
    return [p, place]


def _ways_between(
    start: Array, goal: Array, radius: float, obstacles: Obstacles
) -> list[Way]:
    leg = start[None], goal[None]
    if not blocked(*leg, radius, obstacles.joined.table)[0]:
        return [Way.straight(start, goal)]
    return _Search(goal, radius, obstacles).ways(start)


class _Search:
    """One search; the arguments are those of `shortest_ways`."""

    def __init__(
        self, goal: Array, radius: float, obstacles: Obstacles
    ) -> None:
        self._goal, self._r = goal, radius
        self._walls = obstacles.joined
        self._table = obstacles.table
        self._corners, self._directions = _corners(self._walls.segments)
        self._departures: dict[tuple[int, int], list[tuple[float, _Step]]] = {}
        self._stops: dict[int, Array] = {}
        self._numbers = itertools.count()
        self._ends = self._tangents_to_goal()

    def ways(self, start: Array) -> list[Way]:
        """Returns the shortest paths from a point (2,)."""
        queue: list[tuple[float, int, _Step | Way]] = []
        for turn in (-1, 1):
            for first in self._approaches(start, turn):
                self._push(queue, first)
        done: dict[tuple[int, int], list[_Step]] = {}
        found: list[Way] = []
        while queue:
            least, _, step = heapq.heappop(queue)
            if found and least > found[0].length + _SAME:
                break
            if isinstance(step, Way):
                found.append(step)
                continue
            key = step.circle, step.turn
            arrived = done.setdefault(key, [])
            if any(self._leads_to(other, step) for other in arrived):
                continue
            arrived.append(step)
            if key not in self._departures:
                self._departures[key] = self._legs(*key, 1)
                self._departures[key] += self._legs(*key, -1)
            for angle, leg in self._departures[key]:
                self._push(queue, self._extended(step, angle, leg))
            for leg in self._ends.get(key, ()):
                self._push(queue, self._ended(step, leg))
        return found

    def _push(
        self,
        queue: list[tuple[float, int, "_Step | Way"]],
        step: "_Step | Way | None",
    ) -> None:
        """Adds a path to the queue, by the lower bound of its total length."""
        if step is None:
            return
        least = step.length
        if isinstance(step, _Step):
            place = self._place(step.circle, step.angle)
            least += math.hypot(*(self._goal - place))
        heapq.heappush(queue, (least, next(self._numbers), step))

    def _place(self, circle: int, angle: float) -> Array:
        place: Array = self._corners[circle] + self._r * _unit(angle)
        return place

    def _leads_to(self, other: _Step, step: _Step) -> bool:
        """Returns whether another step leads to a step on no longer path."""
        arc = self._arc(other, step.angle)
        return arc is not None and (other.length + self._r * arc <= step.length)

    def _arc(self, step: _Step, angle: float) -> float | None:
        """Returns the angle of the arc from a step on; None if walls block it.

        Both ends of the arc are clear of walls. A wall within 2 r of the center
        blocks one connected arc of the circle, which contains the direction of
        the nearest point of that wall.
        """
        arc = (step.turn * (angle - step.angle)) % (2 * math.pi)
        if arc > 2 * math.pi - _SAME:
            return 0.0
        if step.circle not in self._stops:
            self._stops[step.circle] = _stops(
                self._corners[step.circle], self._walls, 2 * self._r
            )
        ahead = step.turn * (self._stops[step.circle] - step.angle)
        return None if (ahead % (2 * math.pi) < arc).any() else arc

    def _extended(
        self, step: _Step, angle: float, leg: _Step
    ) -> "_Step | None":
        """Returns a step extended by an arc up to an angle and a leg."""
        arc = self._arc(step, angle)
        if arc is None:
            return None
        return _Step(
            leg.circle,
            leg.turn,
            leg.angle,
            step.length + self._r * arc + leg.length,
            step.turning + arc,
            step.first_heading,
        )

    def _ended(self, step: _Step, leg: _Step) -> Way | None:
        """Returns the complete path of a step, an arc, and a leg to the goal.

        The leg is given as from the goal.
        """
        arc = self._arc(step, leg.angle)
        if arc is None:
            return None
        return Way(
            step.length + self._r * arc + leg.length,
            step.first_heading,
            leg.first_heading + math.pi,
            step.turning + arc + leg.turning,
        )

    def _approaches(self, p: Array, turn: int) -> list[_Step]:
        """Returns the straight legs from a point to circles.

        From inside a circle, where there are no tangents, a leg leaves at a
        right angle to its radius. A disc that overlaps walls may also leave
        them to the beginning of the arc at the end of a wall.
        """
        to_corner = self._corners - p
        distance = np.hypot(to_corner[:, 0], to_corner[:, 1])
        least = np.minimum(distance, self._r)
        most = np.maximum(distance, self._r)
        which = np.arange(len(distance))
        back = np.arctan2(-to_corner[:, 1], -to_corner[:, 0])
        angle = back + turn * np.arccos(least / most)
        if not free_points(p[None], self._r, self._table)[0]:
            beside, _ = ends = np.nonzero(~np.isnan(self._directions))
            which = np.concatenate([which, beside])
            angle = np.concatenate(
                [angle, self._directions[ends] + turn * math.pi / 2]
            )
        steps = []
        for i in self._seen(p, angle, which):
            circle, at = int(which[i]), float(angle[i])
            leg = (self._place(circle, at) - p).tolist()
            length = math.hypot(*leg)
            along = at + turn * math.pi / 2
            # No leg leads to a circle that is touched already.
            bend = 0.0
            if length > _SAME:
                bend = turn * wrap_angle(along - math.atan2(leg[1], leg[0]))
            if bend > -_SAME_ANGLE:
                heading = along - turn * bend
                steps.append(_Step(circle, turn, at, length, bend, heading))
        return steps

    def _tangents_to_goal(self) -> dict[tuple[int, int], list[_Step]]:
        """Returns the last legs as from the goal, by circle and turn."""
        legs: dict[tuple[int, int], list[_Step]] = {}
        for turn in (-1, 1):
            # A reversed path turns the other way.
            for leg in self._approaches(self._goal, -turn):
                legs.setdefault((leg.circle, turn), []).append(leg)
        return legs

    def _legs(
        self, circle: int, turn: int, other_turn: int
    ) -> list[tuple[float, _Step]]:
        """Returns the legs to other circles, with their departure angles."""
        center = self._corners[circle]
        to_corner = self._corners - center
        distance = np.hypot(to_corner[:, 0], to_corner[:, 1])
        cross = turn != other_turn
        # Overlapping circles have no crossing tangents.
        crossing = 2 * self._r if cross else 0.0
        apart = distance > crossing
        (which,) = np.nonzero(apart)
        to_corner, distance = to_corner[which], distance[which]
        half = np.arccos(crossing / distance)
        angle = np.arctan2(to_corner[:, 1], to_corner[:, 0]) - turn * half
        arrival = angle + np.pi if cross else angle
        tangent = _at_corner(angle, self._directions[circle])
        which, angle, arrival = which[tangent], angle[tangent], arrival[tangent]
        distance = distance[tangent]
        length = np.sqrt(distance**2 - crossing**2)
        place = center + self._r * _unit(angle)
        seen = self._seen(place, arrival, which)
        return [
            (
                float(angle[i]),
                _Step(
                    circle=int(which[i]),
                    turn=other_turn,
                    angle=float(arrival[i]),
                    length=float(length[i]),
                    turning=0.0,
                    first_heading=0.0,
                ),
            )
            for i in seen
        ]

    def _seen(
        self, place: Array, angle: Array, which: NDArray[np.intp]
    ) -> NDArray[np.intp]:
        """Returns which legs are clear of walls, as indices into `angle`.

        They lead from one point (2,), or from k points, to circles (k,), where
        they arrive at some angles (k,).
        """
        end = self._corners[which] + self._r * _unit(angle)
        begin = np.ascontiguousarray(np.broadcast_to(place, end.shape))
        # The ends first, because that check is fast.
        (left,) = np.nonzero(_at_corner(angle, self._directions[which]))
        clear = self._r - _SAME
        left = left[free_points(end[left], clear, self._table)]
        if place.ndim > 1:
            left = left[free_points(begin[left], clear, self._table)]
        legs = begin[left], end[left], self._r, self._walls.table
        found: NDArray[np.intp] = left[~blocked(*legs)]
        return found


def _corners(segments: Array) -> tuple[Array, Array]:
    """Returns the corners that a path may bend around, shape (m, 2).

    And the directions of the walls there (m, k), in radians, padded with NaN.
    """
    ends = segments.reshape(-1, 2, 2)
    points = ends.reshape(-1, 2)
    _, first_of, which = np.unique(
        points.round(9), axis=0, return_index=True, return_inverse=True
    )
    points = points[first_of]
    along = ends[:, 1] - ends[:, 0]
    angle = np.arctan2(along[:, 1], along[:, 0])
    walls: list[list[float]] = [[] for _ in points]
    for s in np.flatnonzero((along != 0).any(axis=1)):
        first, last = which.reshape(-1, 2)[s]
        walls[first].append(float(angle[s]))
        walls[last].append(float(angle[s]) + math.pi)
    # Around others, walls leave less than half a turn: no path bends there.
    kept = [i for i, own in enumerate(walls) if _widest(own) > math.pi]
    most = max((len(walls[i]) for i in kept), default=0)
    directions = np.full((len(kept), most), np.nan)
    for row, i in enumerate(kept):
        directions[row, : len(walls[i])] = walls[i]
    return points[kept], directions


def _widest(angles: list[float]) -> float:
    """Returns the widest angle between neighboring directions."""
    if not angles:
        return 2 * math.pi
    order = sorted(angle % (2 * math.pi) for angle in angles)
    order.append(order[0] + 2 * math.pi)
    widest = max(b - a for a, b in itertools.pairwise(order))
    return widest - _SAME_ANGLE


def _at_corner(angle: Array, walls: Array) -> Mask:
    """Returns which angles (k,) at corners are not beside a wall ending there.

    The walls at each corner have the directions (k, j), or those (j,).
    """
    between = np.abs(wrap_angles(angle[:, None] - walls))
    beside: Mask = between < math.pi / 2 - _SAME_ANGLE
    clear: Mask = ~beside.any(axis=1)
    return clear


def _stops(center: Array, walls: Obstacles, reach: float) -> Array:
    """Returns the directions of the nearest points of walls within a range.

    For a wall through the center, they are the directions along it.
    """
    nearest = nearest_points(walls, center) - center
    distance = np.hypot(nearest[:, 0], nearest[:, 1])
    beside = (distance > _ONE_CORNER) & (distance < reach)
    ends = walls.segments[distance <= _ONE_CORNER].reshape(-1, 2) - center
    ends = ends[np.hypot(ends[:, 0], ends[:, 1]) > _ONE_CORNER]
    found = np.concatenate([nearest[beside], ends])
    directions: Array = np.arctan2(found[:, 1], found[:, 0])
    return directions


def _unit(angle: "Array | float") -> Array:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
