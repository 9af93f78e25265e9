"""Checks of geometry: valid shapes, and free space for robot and people."""

from collections.abc import Callable, Iterator, Sequence
import dataclasses as dc
import functools
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
import shapely

from hunav_drake.scenario.building import Check
from hunav_drake.scenario.error import Finding, Loc, path_text
from hunav_drake.scenario.reachability import FreeSpace, nearest_in
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.people.furniture_places import with_furniture
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.robot.robot_config import RobotConfig
from hunav_drake.systems.robot.robots import PhysicalRobot
from hunav_drake.systems.world.shapes import Polygon, Polyline, World, apart
from hunav_drake.systems.world.solids import Fixture, WorldFileError

# Points closer than this are the same, in meters.
_SAME = 1e-9

# The number of lines about the losses of a world.
_MOST_LOSSES = 3

# At most so many pairs of a wall and a place near it are checked.
_MAX_LOOKS = 10**6

# Whoever starts this near to a seat sits on it, in meters.
_ON_SEAT = 0.3

# How much longer a way out may be than the shortest one, because its direction
# is rounded, in meters.
_LONGER = (0.0, 0.01, 0.02, 0.05, 0.1)

# Rooms have arcs of straight lines, which differ by less, in meters.
_NEAR = 2e-3

# The number of places compared with all walls at once.
_DISCS = 256


_TOO_SMALL = (
    "must be larger: points within 1 mm are one, and too few are left; are they"
    " in meters?"
)


def check_walls(scenario: Scenario) -> Iterator[Finding]:
    """Finds walls with repeated points, no area or crossing sides."""
    for i, wall in enumerate(scenario.world.walls):
        loc: Loc = ("world", "walls", i, "points")
        if isinstance(wall, Polyline):
            points = np.array(wall.points, dtype=float)
            for k in _repeated(points):
                yield Finding((*loc, k + 1), f"repeats points[{k}]")
            if len(apart(points, closed=False)) < 2 and len(points) > 1:
                yield Finding(loc, _TOO_SMALL)
        elif isinstance(wall, Polygon):
            points = np.array(wall.points, dtype=float)
            found = _polygon_fault(points.tobytes())
            if found is None and len(apart(points, closed=True)) < 3:
                found = Finding((), _TOO_SMALL)
            if found is not None:
                yield Finding((*loc, *found.loc), found.message)


def check_world_files(scenario: Scenario) -> Iterator[Finding]:
    """Finds maps and models that cannot be read."""
    world = scenario.world
    if world.map is not None:
        try:
            World(map=world.map).fixtures()
        except WorldFileError as error:
            yield Finding(("world", "map"), str(error))
    for i, model in enumerate(world.models):
        try:
            World(models=[model]).fixtures()
        except WorldFileError as error:
            yield Finding(("world", "models", i, "file"), str(error))


def check_maps(scenario: Scenario) -> Iterator[Finding]:
    """Finds maps of a planner that would be too large for its world."""
    goal = scenario.robot.goal
    if goal is not None:
        for place, message in scenario.planner.find_faults(
            _without_unreadable(scenario).obstacles(),
            np.array(scenario.robot.start),
            np.array(goal),
        ):
            yield Finding(("planner", *place), message, uses=(("world",),))


def find_unseen(world: World, robot: RobotConfig) -> Iterator[tuple[Loc, str]]:
    """Yields models in files that Drake cannot render, and the reason."""
    # Imported here: most scenarios do not need Drake's parser.
    from hunav_drake.systems.common.models import apart, gazebo, reading

    named: list[tuple[Loc, str, dict[str, str], dict[str, str]]] = [
        (("world", "models", i, "file"), model.file, {}, {})
        for i, model in enumerate(world.models)
        if not gazebo.is_gazebo_file(model.file)
    ]
    if isinstance(robot, PhysicalRobot):
        source = robot.GetModel()
        packages, values = {**source.packages}, {**source.arguments}
        named.append((("robot", "file"), source.file, packages, values))
    for loc, file, packages, values in named:
        try:
            reading.check_pictures(file, packages, values)
        except apart.ModelFault as fault:
            yield loc, str(fault)


def world_losses(world: World) -> list[str]:
    """Returns what readable worlds of Gazebo lack: a few lines for each."""
    if not world.models:
        return []
    from hunav_drake.systems.common.models import gazebo

    lines = []
    for it in world.models:
        if gazebo.is_gazebo_file(it.file):
            found = gazebo.read_gazebo(
                it.file, it.model_path, it.skip_missing
            ).losses
            lines += [line[:200] for line in found[:_MOST_LOSSES]]
            if len(found) > _MOST_LOSSES:
                lines.append(
                    f"{it.file}: {len(found) - _MOST_LOSSES} more of its parts"
                    " are lost; `hunav import` of it lists all"
                )
    return lines


def _without_unreadable(scenario: Scenario) -> World:
    """Returns the world without unreadable files, which are reported before."""
    faulty = {finding.loc[:3] for finding in check_world_files(scenario)}
    world = scenario.world
    return dc.replace(
        world,
        map=None if ("world", "map") in faulty else world.map,
        models=[
            model
            for i, model in enumerate(world.models)
            if ("world", "models", i) not in faulty
        ],
    )


def _repeated(points: Array) -> list[int]:
    steps = np.hypot(*np.diff(points, axis=0).T)
    return [int(k) for k in np.flatnonzero(steps <= _SAME)]


@functools.lru_cache(maxsize=4096)
def _polygon_fault(corners: bytes) -> Finding | None:
    """Returns a fault of a polygon that is not simple, relative to its points.

    The corners are the bytes of a float array (k, 2). Results are cached,
    because the editor checks the same walls many times.
    """
    points = np.frombuffer(corners).reshape(-1, 2)
    if repeated := _repeated(points):
        k = repeated[0]
        return Finding((k + 1,), f"repeats points[{k}]")
    last = len(points) - 1
    if np.hypot(*(points[last] - points[0])) <= _SAME:
        return Finding(
            (last,),
            "repeats points[0]; the last corner joins the first by itself",
        )
    centered = points - points.mean(axis=0)
    extent = float(np.abs(centered).max())
    # Singular values: how far the corners spread along and across a line.
    spread = np.linalg.svd(centered, compute_uv=False)
    if spread[1] <= _SAME * max(extent, 1.0):
        return Finding((), "must enclose an area; the corners lie on a line")
    for i, j in _crossing_sides(points)[:1]:
        return Finding(
            (),
            f"must not cross itself; the side from points[{i}] meets the side"
            f" from points[{j}]",
        )
    return None


def _crossing_sides(points: Array) -> NDArray[np.int64]:
    """Returns pairs (i, j), i < j, of sides that must not meet, but do.

    Side i of a polygon begins at its corner i.
    """
    ends = np.stack([points, np.roll(points, -1, axis=0)], axis=1)
    sides = shapely.linestrings(ends)
    pairs = shapely.STRtree(sides).query(sides, predicate="intersects").T
    pairs = np.unique(pairs[pairs[:, 0] < pairs[:, 1]], axis=0)
    # Neighbors share a corner. They meet elsewhere only by doubling back.
    apart = pairs[:, 1] - pairs[:, 0]
    wrong = (apart > 1) & (apart < len(points) - 1)
    i, j = pairs[~wrong].T
    wrong[~wrong] = shapely.relate_pattern(sides[i], sides[j], "1********")
    crossing: NDArray[np.int64] = pairs[wrong]
    return crossing


class _Taker(NamedTuple):
    """A wall that occupies a place, and the way out."""

    wall: int
    inside: bool
    depth: float
    # A unit vector; zero where it is not known.
    way: Array


_Takers = dict[tuple[Any, ...], _Taker | None]


class _Spot(NamedTuple):
    """A place that must be free of walls."""

    loc: Loc
    position: tuple[float, float]
    # The radius of the body there, in meters; 0 if only the point counts.
    radius: float
    uses: tuple[Loc, ...] = ()


def check_places(scenario: Scenario) -> Iterator[Finding]:
    """Finds starts, goals and places that walls or other bodies occupy.

    Bodies must not overlap walls. A person's goal, or where people use a place,
    must not be inside a wall, but may be closer to it than the radius:
    `goal_radius` is reached before.
    """
    yield from _check_robot_and_people(scenario)
    robot = scenario.robot
    body: tuple[Loc, ...] = (("robot", "radius"),)
    spots = [_Spot(("robot", "start"), robot.start[:2], robot.radius, body)]
    if robot.goal is not None:
        goal = _Spot(("robot", "goal"), robot.goal[:2], robot.radius, body)
        spots.append(goal)
    for i, human in enumerate(scenario.humans):
        if human.track is not None:
            continue
        loc: Loc = ("humans", i)
        body = ((*loc, "radius"),)
        spots.append(_Spot((*loc, "pose"), human.pose[:2], human.radius, body))
        spots += [
            _Spot((*loc, "goals", k), goal, 0.0)
            for k, goal in enumerate(human.goals)
        ]
    for i, it in enumerate(scenario.places):
        which = "approaches" if it.approaches else "slots"
        for k, place in enumerate(it.all_approaches()):
            given = getattr(it, which) or it.type == "screen"
            part = (which, k) if given else ("pose",)
            spots.append(_Spot(("places", i, *part), place, 0.0))
    seats = _seats(scenario)
    for found in _check_spots(scenario, spots):
        kind, row, key = found.loc[0], found.loc[1], found.loc[-1]
        if kind == "humans" and key == "pose":
            human = scenario.humans[int(row)]
            if _is_near(human.pose, seats()) and _may_sit(scenario, human):
                continue
        yield found


def _may_sit(scenario: Scenario, human: HumanConfig) -> bool:
    """Returns whether the tree of a person uses places, and it can sit."""
    if human.figure.wheelchair:
        return False
    from hunav_drake.systems.behavior import BehaviorTreeError, LoadBehavior

    profile = scenario.crowd.profile
    try:
        tree = LoadBehavior(human.behavior, profile=profile)
    except BehaviorTreeError:
        # (That is told by itself.)
        return True
    return any(it.type.name == "UsePlace" for it in tree.nodes)


def _seats(scenario: Scenario) -> Callable[[], list[tuple[float, float]]]:
    """Returns what gives all seats, on which people may sit at the start."""

    @functools.cache
    def seats() -> list[tuple[float, float]]:
        world = _without_unreadable(scenario)
        return [
            (x, y)
            for it in with_furniture(scenario.places, world)
            if it.type in ("seat", "workplace", "bed")
            for x, y, _ in it.all_slots()
        ]

    return seats


def _is_near(
    pose: Sequence[float], seats: Sequence[tuple[float, float]]
) -> bool:
    return any(math.dist(pose[:2], it) <= _ON_SEAT for it in seats)


def _check_robot_and_people(scenario: Scenario) -> Iterator[Finding]:
    robot = scenario.robot
    for i, human in enumerate(scenario.humans):
        if human.track is not None:
            continue
        gap = math.dist(robot.start[:2], human.pose[:2])
        overlap = robot.radius + human.radius - gap
        if overlap > _SAME:
            loc: Loc = ("humans", i)
            other = path_text(scenario, loc)
            yield Finding(
                ("robot", "start"),
                f"overlaps {other} by {_up(overlap)} m; move one of them",
                uses=(("robot", "radius"), (*loc, "pose"), (*loc, "radius")),
            )


def _check_spots(scenario: Scenario, spots: list[_Spot]) -> Iterator[Finding]:
    """Reports the first object of the world that occupies each spot."""
    fixtures = _without_unreadable(scenario).fixtures()
    shapes = _shapes(fixtures)
    places = [it.place for it in fixtures for _ in it.footprints]
    keys = list(dict.fromkeys((*it.position, it.radius) for it in spots))
    taken: _Takers = {}
    looks = 0
    for (*position, radius), near in _near(shapes, keys):
        key = tuple(position), radius
        # Nearly every pair has a fault, so no more are needed.
        if looks > _MAX_LOOKS:
            break
        looks += len(near)
        taken[key] = None
        for w in sorted(near.tolist()):
            depth, way = _depth(shapes[w], shapely.Point(position), radius)
            if depth > _SAME:
                taken[key] = _Taker(w, depth > radius, depth, way)
                break
    if not any(taken.values()):
        return
    space = FreeSpace(fixtures, [spot.position for spot in spots])
    rooms: dict[float, Any] = {}
    for spot in spots:
        if found := taken.get(spot[1:3]):
            radius = spot.radius
            if radius not in rooms:
                rooms[radius] = _main_room(radius, spots, taken, space)
            if rooms[radius] is not None:
                found = _out(found, rooms[radius], spot, space)
            loc = ("world", *places[found.wall])
            message = _message(path_text(scenario, loc), found)
            yield Finding(spot.loc, message, uses=(*spot.uses, loc))


def _out(taker: _Taker, room: Any, spot: _Spot, space: FreeSpace) -> _Taker:
    """Returns the shortest way from a spot into a room, as it is told.

    Told are two digits of the direction, and centimeters: whoever moves by just
    that, to whole millimeters, is free.
    """
    way = np.subtract(nearest_in(room, spot.position), spot.position)
    depth = float(np.hypot(*way))
    if depth <= _SAME:
        return taker
    told = np.round(way / depth, 2)
    for more in _LONGER:
        length = math.ceil(depth * 100 - 1e-6) / 100 + more
        moved = np.add(spot.position, length * told)
        x, y = np.round(moved, 3).tolist()
        inside = room.distance(shapely.Point(x, y)) <= _NEAR
        if inside and space.is_free((x, y), spot.radius):
            return taker._replace(depth=length, way=told)
    return taker._replace(depth=depth, way=way / depth)


def _main_room(
    radius: float, spots: list[_Spot], taken: _Takers, space: FreeSpace
) -> Any:
    """Returns the free polygon that contains most free spots, or None.

    It is needed because the nearest side of an outer wall may be outside of the
    building, which is no remedy. If no spot is free, it is all free polygons.
    """
    free = [it.position for it in spots if taken.get(it[1:3], 0) is None]
    rooms = [space.room(it, radius) for it in dict.fromkeys(free)]
    numbers = [id(room) for room in rooms if room is not None]
    if not numbers:
        return space.everywhere(radius)
    # Each polygon is made once, so its identity counts.
    most = max(dict.fromkeys(numbers), key=numbers.count)
    return next(room for room in rooms if id(room) == most)


def _shapes(fixtures: Sequence[Fixture]) -> list[shapely.Geometry]:
    """Returns the footprints of all objects of a world, in order."""
    outlines = [it for fixture in fixtures for it in fixture.footprints]
    closed = np.array([it.closed for it in fixtures for _ in it.footprints])
    result: list[shapely.Geometry] = [None] * len(outlines)
    for is_closed in (True, False):
        chosen = np.flatnonzero(closed == is_closed)
        if not len(chosen):
            continue
        points = np.vstack([outlines[i] for i in chosen])
        index = np.repeat(
            np.arange(len(chosen)), [len(outlines[i]) for i in chosen]
        )
        if is_closed:
            made = shapely.polygons(shapely.linearrings(points, indices=index))
        else:
            made = shapely.linestrings(points, indices=index)
        for i, shape in zip(chosen, made, strict=True):
            result[i] = shape
    return result


def _near(
    shapes: Sequence[shapely.Geometry], discs: Sequence[tuple[float, ...]]
) -> Iterator[tuple[tuple[float, ...], NDArray[np.int64]]]:
    """Yields discs (x, y, radius), each with the shapes that it overlaps."""
    tree = shapely.STRtree(shapes)
    # In blocks: all discs together may overlap very many shapes.
    for low in range(0, len(discs), _DISCS):
        some = discs[low : low + _DISCS]
        rows = np.array(some)
        here, found = tree.query(
            shapely.points(rows[:, :2]),
            predicate="dwithin",
            distance=rows[:, 2],
        )
        order = np.argsort(here, kind="stable")
        ends = np.searchsorted(here[order], np.arange(len(some) + 1))
        for i, disc in enumerate(some):
            yield disc, found[order[ends[i] : ends[i + 1]]]


def _depth(
    shape: shapely.Geometry, place: shapely.Point, radius: float
) -> tuple[float, Array]:
    """Returns the depth of a disc in a wall, in meters, and the way out.

    The depth is negative for a free disc. The way is a unit vector, or zero if
    the center is on the outline.
    """
    solid = isinstance(shape, shapely.Polygon)
    outline = shape.boundary if solid else shape
    ends = shapely.get_coordinates(shapely.shortest_line(outline, place))
    away = ends[1] - ends[0]
    distance = float(np.hypot(*away))
    sign = -1.0 if solid and shape.contains(place) else 1.0
    way = sign * away / distance if distance > 0 else away
    return radius - sign * distance, way


def _message(wall: str, taker: _Taker) -> str:
    how = "is inside" if taker.inside else "overlaps"
    depth, direction = taker.depth, ""
    if taker.way.any():
        x, y = taker.way.round(2)
        direction = f" along ({x:z.2f}, {y:z.2f})"
        # (What is told may be shorter than a unit vector.)
        depth /= float((taker.way * (x, y)).sum())
    return f"{how} {wall}; move it {_up(depth)} m{direction}"


def _up(length: float) -> str:
    """Returns a length, rounded up so that moving by it is enough."""
    return f"{math.ceil(length * 100 - 1e-6) / 100:.2f}"


# In this order: a check drops findings on parts that an earlier one reported.
GEOMETRY_CHECKS: tuple[Check, ...] = (
    check_world_files,
    check_walls,
    check_places,
    check_maps,
)
