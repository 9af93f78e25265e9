"""Checks that robot and people can reach their goals."""

from collections.abc import Iterator, Sequence
import functools
import math
from typing import Any, NamedTuple

import numpy as np
import shapely

from hunav_drake.scenario.error import Finding, Loc, path_text
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.world.route_clearance import route_clearance
from hunav_drake.systems.world.solids import Fixture, WorldFileError

Point = tuple[float, float]

# Shapes closer than this touch, in meters.
_TOUCH = 1e-6

# Lengths that differ by less are the same, in meters.
_ROUNDING = 1e-9

# The accuracy of widths of doors, and the narrowest door, in meters.
_WIDTH = 0.005
_NARROWEST = 0.02

# The margin of the free space around all walls, in meters.
_MARGIN = 5.0


class Gap(NamedTuple):
    """The narrowest place of the widest way between two points.

    Attributes:
        width: Its width, in meters.
        place: Its center, (x, y) in W, in meters.
        sides: The two nearest objects there, as paths in the world, such as
            ("walls", 3).
    """

    width: float
    place: Point
    sides: tuple[Loc, ...]


class FreeSpace:
    """The space of a world in which discs can move; points are (x, y) in W."""

    def __init__(self, fixtures: Sequence[Fixture], around: Any = ()) -> None:
        """Constructs the free space.

        Args:
            fixtures: All objects of the world: see `World.fixtures`.
            around: Further points, in meters, that it must contain.
        """
        shapes = [
            (shapely.polygons if it.closed else shapely.linestrings)(outline)
            for it in fixtures
            for outline in it.footprints
        ]
        # (Another check reports polygons that cross themselves.)
        self.shapes = [
            it if it.is_valid else shapely.make_valid(it) for it in shapes
        ]
        self.places: list[Loc] = [
            it.place for it in fixtures for _ in it.footprints
        ]
        points = [shapely.Point(place) for place in around]
        bounds = shapely.total_bounds([*self.shapes, *points])
        if np.isnan(bounds).any():
            bounds = np.zeros(4)
        margin = _MARGIN * np.array([-1, -1, 1, 1])
        self._whole = shapely.box(*(bounds + margin))
        self._tree = shapely.STRtree(self.shapes)
        self._rooms = functools.cache(self._make_rooms)

    def _make_rooms(self, radius: float) -> list[Any]:
        thick = shapely.buffer(self.shapes, radius) if self.shapes else []
        free = self._whole.difference(shapely.union_all(thick))
        return list(shapely.get_parts(free))

    def everywhere(self, radius: float) -> Any:
        """Returns all places of a disc's center, in meters; None without."""
        rooms = self._rooms(radius)
        return shapely.multipolygons(rooms) if rooms else None

    def is_free(self, place: Point, radius: float) -> bool:
        """Returns whether a disc at a place overlaps nothing."""
        point = shapely.Point(place)
        near = self._tree.query(point, predicate="dwithin", distance=radius)
        return not any(
            shape.distance(point) < radius - _ROUNDING
            or shape.contains_properly(point)
            for shape in (self.shapes[i] for i in near)
        )

    def room(self, place: Point, radius: float) -> Any:
        """Returns the polygon of places that a disc's center can reach.

        It is None if the disc has no room at the start. Lengths are in meters.
        """
        point = shapely.Point(place)
        for room in self._rooms(radius):
            if room.distance(point) <= _TOUCH:
                return room
        return None

    def joins(
        self, start: Point, goal: Point, radius: float, tolerance: float
    ) -> bool:
        """Returns whether a disc can move from a start to near a goal.

        The tolerance is the accepted distance to the goal. All are in meters.
        """
        room = self.room(start, radius)
        if room is None:
            return False
        distance = room.distance(shapely.Point(goal))
        return bool(distance <= max(tolerance, _TOUCH))

    def is_outside(self, place: Point, radius: float) -> bool:
        """Returns whether a disc at a place is outside of all closed walls."""
        room = self.room(place, radius)
        edge = self._whole.exterior
        return room is not None and bool(room.distance(edge) <= _TOUCH)

    def gap(self, start: Point, goal: Point, radius: float) -> Gap | None:
        """Returns the gap that is too narrow for a disc on its way to a goal.

        It is None if there is no way for any disc. Lengths are in meters.
        """
        low, high = _NARROWEST / 2, radius
        if not self.joins(start, goal, low, 0.0):
            return None
        while high - low > _WIDTH / 2:
            middle = (low + high) / 2
            if self.joins(start, goal, middle, 0.0):
                low = middle
            else:
                high = middle
        here, there = self.room(start, high), self.room(goal, high)
        if here is None or there is None:
            # The narrow place is at the start or at the goal.
            place = shapely.Point(goal if there is None else start)
        else:
            place = shapely.shortest_line(here, there).centroid
        near = self._tree.query(place, predicate="dwithin", distance=3 * radius)
        order = sorted(near, key=lambda i: self.shapes[i].distance(place))
        nearest = tuple(dict.fromkeys(self.places[i] for i in order))[:2]
        # In the order of the file.
        sides = dict.fromkeys(it for it in self.places if it in nearest)
        return Gap(low + high, (place.x, place.y), tuple(sides))

    def nearest(self, place: Point) -> tuple[Loc, float] | None:
        """Returns the nearest object and its distance, in meters."""
        if not self.shapes:
            return None
        point = shapely.Point(place)
        number = int(self._tree.nearest(point))
        return self.places[number], float(self.shapes[number].distance(point))

    def before(
        self, start: Point, end: Point, radius: float
    ) -> tuple[Loc, float] | None:
        """Returns the first object that a disc meets on a straight line.

        With it comes its distance from the start, in meters. An object that
        the disc only slides along is not met.
        """
        line = shapely.LineString([start, end])
        strip = line.buffer(0.95 * radius, cap_style="flat")
        first = shapely.Point(start)
        met = [
            (float(self.shapes[i].intersection(strip).distance(first)), i)
            for i in self._tree.query(strip, predicate="intersects")
        ]
        return (self.places[min(met)[1]], min(met)[0]) if met else None

    def between(self, start: Point, goal: Point) -> Loc | None:
        """Returns the first object on the straight line to a goal."""
        line = shapely.LineString([start, goal])
        hit = self._tree.query(line, predicate="intersects")
        first = shapely.Point(start)
        ranked = sorted(
            hit, key=lambda i: self.shapes[i].intersection(line).distance(first)
        )
        return self.places[ranked[0]] if ranked else None


def free_space(scenario: Scenario) -> FreeSpace | None:
    """Returns the free space of a scenario; None if a file is unreadable."""
    try:
        fixtures = scenario.world.fixtures()
    except WorldFileError:
        return None
    robot = scenario.robot
    around = [robot.start[:2], *(human.pose[:2] for human in scenario.humans)]
    around += [goal for human in scenario.humans for goal in human.goals]
    if robot.goal is not None:
        around.append(robot.goal[:2])
    return FreeSpace(fixtures, around)


def check_ways(scenario: Scenario) -> Iterator[Finding]:
    """Finds goals that the robot or people cannot reach.

    People turn sideways in narrow doors: see `route_clearance`.
    """
    space = free_space(scenario)
    if space is None:
        return
    robot = scenario.robot
    if robot.goal is not None:
        start, goal = robot.start[:2], robot.goal[:2]
        if words := no_way(
            *(scenario, space, start, goal, robot.radius),
            tolerance=robot.goal_tolerance,
        ):
            yield Finding(
                ("robot", "goal"),
                f"cannot be reached from robot.start: {words}",
                uses=(("robot", "start"), ("robot", "radius"), ("world",)),
            )
    for i, human in enumerate(scenario.humans):
        if human.track is not None:
            continue
        radius = route_clearance([human.radius])
        loc: Loc = ("humans", i)
        for k, goal in enumerate(human.goals):
            if words := no_way(
                *(scenario, space, human.pose[:2], goal, radius),
                tolerance=human.goal_radius,
            ):
                yield Finding(
                    (*loc, "goals", k),
                    f"cannot be reached from the person's pose: {words}",
                    uses=((*loc, "pose"), (*loc, "radius"), ("world",)),
                )
                break


def no_way(
    scenario: Scenario,
    space: FreeSpace,
    start: Point,
    goal: Point,
    radius: float,
    *,
    tolerance: float,
) -> str:
    """Returns why a disc cannot reach a goal, and a remedy; "" if it can.

    `space` is the free space of the scenario, `tolerance` the accepted
    distance to the goal. Lengths are in meters, points in W.
    """
    room = space.room(start, radius)
    if room is None or space.joins(start, goal, radius, tolerance):
        return ""
    if gap := space.gap(start, goal, radius):
        sides = [path_text(scenario, ("world", *side)) for side in gap.sides]
        whose = f" between {' and '.join(sides)}" if len(sides) > 1 else ""
        x, y = gap.place
        return (
            f"no way through a door of {gap.width:.2f} m{whose} at"
            f" ({x:.2f}, {y:.2f}), for a body {2 * radius:.2f} m wide; widen"
            f" it, or take a radius below {_down(gap.width / 2)} m"
        )
    x, y = nearest_in(room, goal)
    place = f"({x:.2f}, {y:.2f})"
    if space.is_outside(goal, radius) and not space.is_outside(start, radius):
        return (
            "it is outside of the building; the nearest place inside is"
            f" {place}"
        )
    blocker = space.between(start, goal)
    if blocker is None:
        what, stands = "walls", "stand"
    else:
        what, stands = path_text(scenario, ("world", *blocker)), "stands"
    return (
        f"{what} {stands} between, without a way around; leave a gap of more"
        f" than {2 * radius:.2f} m, or move the goal to {place}"
    )


def nearest_in(room: Any, place: Point) -> Point:
    """Returns the point of a polygon that is nearest to a given point."""
    nearest = shapely.shortest_line(room, shapely.Point(place))
    x, y = shapely.get_coordinates(nearest)[0].tolist()
    return x, y


def _down(length: float) -> str:
    """Returns a length, rounded down so that a body of it fits."""
    return f"{math.floor(length * 100 + 1e-6) / 100:.2f}"
