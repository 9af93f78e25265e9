"""The places that furniture brings: chairs are seats, counters have a queue."""

from collections.abc import Sequence
import copy
import dataclasses
import itertools
import math

import numpy as np
import shapely

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.people.places import (
    PLACE_TYPES,
    Place,
    complete_places,
)
from hunav_drake.systems.world.furniture.base import Furniture, Spot
from hunav_drake.systems.world.obstacles import Obstacles, inside, nearest_wall
from hunav_drake.systems.world.shapes import EYE_HEIGHT, World

# People stand this far from the edge of a seat before they sit down, and where
# nothing is nearer than the second distance, in meters.
_BESIDE, _ROOM = 0.42, 0.28

# Sides of a seat and of a bed from which people sit down, the best one first: 0
# is in front; in radians.
_SIDES = {
    "seat": (0.0, -math.pi / 2, math.pi / 2, math.pi),
    "bed": (-math.pi / 2, math.pi / 2, 0.0),
}

# A seat this near to where one works at a desk, in meters, facing it within the
# angle, in radians, is a workplace.
_AT_DESK, _FACING = 0.75, 0.8


def with_furniture(places: Sequence[Place], world: World) -> list[Place]:
    """Returns places, and those that the furniture of a world brings.

    Chairs, benches and sofas are seats, a chair at a desk is a workplace, beds
    are beds, counters and tills have a queue, shelves are shelves, and pictures
    are screens, which people look at. Each has the name of its piece of
    furniture, by default "chair_1", "chair_2", ... in order, as have those with
    a name that another one has before, or that is a number. What nobody can
    reach, between walls, is none.

    Args:
        places: Other places; what has one of their names is left out.
        world: The world.

    Returns:
        All of them, with names and numbers: those of furniture come last.

    Raises:
        ValueError: As `complete_places`.
    """
    listed = complete_places(places)
    names, numbers = {it.name for it in listed}, {it.id for it in listed}
    free = (k for k in itertools.count(1) if k not in numbers)
    found = [it for it in _places_of(world) if it.name not in names]
    return [*listed, *(dataclasses.replace(it, id=next(free)) for it in found)]


def doors_of(places: Sequence[Place], world: World) -> Array | None:
    """Returns the centers of doors among places and furniture, if any.

    Shape (k, 2), in W, in meters.
    """
    centers = [(it.pose[0], it.pose[1]) for it in places if it.type == "door"]
    for it in world.furniture:
        x, y = it.center
        # (A place may be the door of a frame.)
        away = (math.dist((x, y), center) for center in centers)
        if name_of(it) == "door_frame" and min(away, default=_ROOM) >= _ROOM:
            centers.append((x, y))
    return np.array(centers) if centers else None


def _places_of(world: World) -> list[Place]:
    counts: dict[str, int] = {}
    used, defaults = [], []
    for it in world.furniture:
        kind = name_of(it)
        counts[kind] = counts.get(kind, 0) + 1
        if it.use:
            used.append(it)
            defaults.append(f"{kind}_{counts[kind]}")
    found = zip(_names(used, defaults), used, strict=True)
    if not used:
        return []
    obstacles = world.obstacles()
    desks = [
        _in_world(desk, (desk.size[0] / 2, 0.0, math.pi))
        for desk in world.furniture
        if name_of(desk) == "desk"
    ]
    bare = copy.copy(world)
    bare.furniture = []
    segments = bare.obstacles().segments.reshape(-1, 2, 2)
    walls = shapely.STRtree(shapely.linestrings(segments))
    places = [
        _place(name, it, world, obstacles, walls, desks) for name, it in found
    ]
    return [it for it in places if it is not None]


def _names(
    furniture: Sequence[Furniture], defaults: Sequence[str]
) -> list[str]:
    """Returns a name for each piece of furniture, given the default ones.

    A number is none, as trees name places by their numbers, too.
    """
    first: dict[str, int] = {}
    for i, it in enumerate(furniture):
        if it.name and not it.name.isdecimal():
            first.setdefault(it.name, i)
    names = []
    for i, (it, default) in enumerate(zip(furniture, defaults, strict=True)):
        name = it.name
        if first.get(name) != i:
            more = (f"{default}_{k}" for k in itertools.count(2))
            name = next(
                it for it in itertools.chain([default], more) if it not in first
            )
            first[name] = i
        names.append(name)
    return names


def _place(
    name: str,
    it: Furniture,
    world: World,
    obstacles: Obstacles,
    walls: shapely.STRtree,
    desks: Sequence[Spot],
) -> Place | None:
    """Returns the place of a piece of furniture, if anybody can get there.

    Nobody sits down through walls.
    """
    sits = it.use in _SIDES
    slots, approaches = [], []
    hiding = _hiding(it, world) if it.use == "screen" else []
    for spot in it.spots():
        x, y, _ = pose = _in_world(it, spot)
        ways = _ways(it, spot) if sits else [(x, y)]
        if not _is_seen(it, hiding, (x, y)):
            continue
        ways = [p for p in ways if _is_free(obstacles, p)]
        if sits:
            lines = [shapely.LineString([p, (x, y)]) for p in ways]
            ways = [
                p
                for p, line in zip(ways, lines, strict=True)
                if not len(walls.query(line, predicate="intersects"))
            ]
        way = ways[0] if ways else None
        if way is not None:
            slots.append(pose)
            approaches.append(way)
    if not slots:
        return None
    kind = next(kind for kind in PLACE_TYPES if kind == it.use)
    works = any(_is_at(slots[0], desk) for desk in desks)
    return Place(
        name=name,
        type="workplace" if it.use == "seat" and works else kind,
        pose=_in_world(it, (0.0, 0.0, 0.0)) if kind == "screen" else slots[0],
        slots=slots,
        approaches=approaches if sits else [],
    )


def _in_world(it: Furniture, spot: Spot) -> Spot:
    """Returns a pose in the frame of furniture as one in W."""
    c, s = math.cos(it.yaw), math.sin(it.yaw)
    x, y, yaw = spot
    return (
        it.center[0] + c * x - s * y,
        it.center[1] + s * x + c * y,
        math.remainder(it.yaw + yaw, 2 * math.pi),
    )


def _ways(it: Furniture, spot: Spot) -> list[tuple[float, float]]:
    """Returns where people may stand beside a seat, the best first, in W."""
    ways = []
    half = np.array(it.size) / 2
    for side in _SIDES[it.use]:
        along = np.array([math.cos(side), math.sin(side)]).round()
        x, y = spot[:2]
        # Beyond the edge on that side.
        reach = abs(along[0]) * half[0] + abs(along[1]) * half[1]
        reach += _BESIDE - along[0] * x - along[1] * y
        x, y, _ = _in_world(it, (x + reach * along[0], y + reach * along[1], 0))
        ways.append((x, y))
    return ways


def _is_free(obstacles: Obstacles, point: tuple[float, float]) -> bool:
    """Returns whether people can stand at a point in W."""
    if inside(obstacles, point).any():
        return False
    away = np.subtract(nearest_wall(obstacles, point), point)
    return bool(np.hypot(*away) >= _ROOM)


def _hiding(it: Furniture, world: World) -> list[shapely.Geometry]:
    """Returns what may be between people's eyes and a piece of furniture."""
    return [
        (shapely.LinearRing if solid.closed else shapely.LineString)(outline)
        for fixture in world.fixtures()
        if fixture.place[0] != "furniture"
        or world.furniture[int(fixture.place[1])] is not it
        for solid in fixture.solids
        for outline in solid.cuts(EYE_HEIGHT)
    ]


def _is_seen(
    it: Furniture,
    hiding: Sequence[shapely.Geometry],
    point: tuple[float, float],
) -> bool:
    """Returns whether people at a point see the front of furniture."""
    # (But for rounding, from its surface.)
    front = _in_world(it, (0.49 * it.size[0], 0.0, 0.0))[:2]
    return not any(map(shapely.LineString([front, point]).intersects, hiding))


def _is_at(seat: Spot, desk: Spot) -> bool:
    """Returns whether a seat is where one sits at a desk."""
    away = math.hypot(seat[0] - desk[0], seat[1] - desk[1])
    turn = math.remainder(seat[2] - desk[2], 2 * math.pi)
    return away <= _AT_DESK and abs(turn) <= _FACING
