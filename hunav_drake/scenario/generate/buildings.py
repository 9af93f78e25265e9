"""Floors of rooms and corridors, their walls, and furniture in them."""

from collections.abc import Sequence
import itertools
import math
from typing import Any, NamedTuple

import numpy as np
import shapely

from hunav_drake.scenario.generate.kind import NoRoomError, Rect
from hunav_drake.systems.world.furniture import FURNITURE, Furniture
from hunav_drake.systems.world.shapes import Box, World

# The thickness of walls, the room beside a door, the floor before it that is
# kept free, and the gap between furniture and a wall, in meters.
THICK, _BESIDE, _BEFORE, _OFF = 0.15, 0.3, 0.9, 0.03

# The number of places tried for a piece of furniture, and for a robot.
_TRIES = 30

Generator = np.random.Generator

# A piece: its kind, place (x, y) and heading in its set, and options.
_Piece = tuple[str, float, float, float, dict[str, Any]]


class _Set(NamedTuple):
    """Furniture that belongs together: its front is on the side of +x.

    Attributes:
        size: Its extents along its x and y, in meters.
        at_wall: Whether its back stands at a wall.
        pieces: Its pieces.
    """

    size: tuple[float, float]
    at_wall: bool
    pieces: Sequence[_Piece]


def _chairs(x: float, *ys: float) -> list[_Piece]:
    """Returns chairs on both sides of a table."""
    return [
        ("chair", s * x, y, (s + 1) * math.pi / 2, {})
        for y in ys
        for s in (-1, 1)
    ]


def _alone(kind: str, x: float, y: float, **options: Any) -> _Set:
    at_wall = kind != "pallet"
    return _Set((x, y), at_wall, [(kind, 0, 0, 0, {"size": (x, y), **options})])


_TURN = math.pi
_SETS = {
    "workplace": _Set(
        (1.45, 1.5),
        True,
        [("desk", -0.35, 0, 0, {}), ("chair", 0.45, 0, _TURN, {})],
    ),
    "workplaces": _Set(
        (2.8, 1.5),
        False,
        [
            *(("desk", s * 0.375, 0, (1 - s) * _TURN / 2, {}) for s in (-1, 1)),
            *_chairs(1.15, 0),
        ],
    ),
    "meeting": _Set(
        (2.2, 2.4),
        False,
        [("table", 0, 0, 0, {"size": (1.0, 2.4)}), *_chairs(0.82, -0.7, 0.7)],
    ),
    "dining": _Set(
        (1.9, 1.4),
        False,
        [("table", 0, 0, 0, {"size": (0.8, 1.4)}), *_chairs(0.7, -0.35, 0.35)],
    ),
    "bistro": _Set(
        (1.8, 0.8),
        False,
        [
            ("table", 0, 0, 0, {"size": (0.8, 0.8), "round": True}),
            *_chairs(0.67, 0),
        ],
    ),
    "lounge": _Set(
        (1.9, 1.9),
        True,
        [
            ("sofa", -0.52, 0, 0, {}),
            ("table", 0.65, 0, 0, {"size": (0.6, 1.1), "height": 0.45}),
        ],
    ),
    "bed": _alone("bed", 2.05, 1.0),
    "bench": _alone("bench", 0.4, 1.5),
    "shelf": _alone("shelf", 0.4, 1.6),
    "counter": _alone("counter", 0.6, 2.0),
    "plant": _alone("plant", 0.5, 0.5),
    "pallet": _alone("pallet", 1.2, 0.8, load=0.9),
}

# What stands in a room, the first piece first.
USES = {
    "work": ("workplace", "workplaces", "workplace", "shelf", "plant"),
    "meeting": ("meeting", "plant", "shelf"),
    "kitchen": ("counter", "bistro", "dining", "plant"),
    "living": ("lounge", "dining", "shelf", "plant", "bench"),
    "bedroom": ("bed", "shelf", "workplace", "plant"),
    "store": ("shelf", "pallet", "shelf", "pallet"),
    "hall": ("bench", "plant", "shelf"),
}


class Door(NamedTuple):
    """An opening between two rooms, given by their indices."""

    rect: Rect
    rooms: tuple[int, int]


def split(rect: Rect, least: float, random: Generator) -> list[Rect]:
    """Divides a rectangle by walls, until rooms are about `least` m wide."""
    x0, y0, x1, y1 = rect
    width, depth = x1 - x0, y1 - y0
    if max(width, depth) < 2 * least + THICK or (
        width * depth < 5 * least**2 and random.random() < 0.25
    ):
        return [rect]
    share = random.uniform(0.4, 0.6)
    if width >= depth:
        at = round(max(x0 + least, min(x0 + share * width, x1 - least)), 2)
        halves = [(x0, y0, at - THICK / 2, y1), (at + THICK / 2, y0, x1, y1)]
    else:
        at = round(max(y0 + least, min(y0 + share * depth, y1 - least)), 2)
        halves = [(x0, y0, x1, at - THICK / 2), (x0, at + THICK / 2, x1, y1)]
    return [it for half in halves for it in split(half, least, random)]


def possible_doors(
    rooms: Sequence[Rect], width: float, random: Generator
) -> list[Door]:
    """Returns a door for each two rooms that have enough wall in common."""
    doors = []
    for (i, a), (k, b) in itertools.permutations(enumerate(rooms), 2):
        for axis in (0, 1):
            low, high = a[axis + 2], b[axis]
            across = 1 - axis
            first = max(a[across], b[across]) + _BESIDE
            last = min(a[across + 2], b[across + 2]) - _BESIDE - width
            if abs(high - low - THICK) > 1e-6 or last < first:
                continue
            at = round(random.uniform(first, last), 2)
            rect = [low, at, high, at + width]
            if axis:
                rect = [at, low, at + width, high]
            doors.append(Door((rect[0], rect[1], rect[2], rect[3]), (i, k)))
    return doors


def spanning(
    doors: Sequence[Door], more: float, random: Generator
) -> list[Door]:
    """Returns doors that join all rooms, and a share of the others."""
    group: dict[int, int] = {}

    def of(room: int) -> int:
        while group.get(room, room) != room:
            room = group[room]
        return room

    chosen = []
    for i in random.permutation(len(doors)):
        a, b = map(of, doors[i].rooms)
        if a != b or random.random() < more:
            chosen.append(doors[i])
        group[a] = b
    return chosen


def walls_around(floor: shapely.Geometry) -> list[Box]:
    """Returns walls around a floor of right angles, as boxes side by side."""
    solid = floor.buffer(THICK, join_style="mitre").difference(floor)
    corners = shapely.get_coordinates(solid).round(4)
    xs, ys = np.unique(corners[:, 0]), np.unique(corners[:, 1])
    middles = np.meshgrid((xs[1:] + xs[:-1]) / 2, (ys[1:] + ys[:-1]) / 2)
    full = shapely.contains_xy(solid, *middles).T
    boxes = []
    for i, k in np.argwhere(full):
        if not full[i, k]:
            continue
        # The longest run of cells, along x or along y, then as wide as it goes.
        ends = [i + 1, k + 1]
        spans = []
        for axis, row in enumerate((full[i:, k], full[i, k:])):
            count = len(row) if row.all() else int(np.argmin(row))
            marks = (xs, ys)[axis]
            first = (i, k)[axis]
            spans.append((marks[first + count] - marks[first], count, axis))
        _, count, axis = max(spans)
        ends[axis] = (i, k)[axis] + count
        other = 1 - axis
        while ends[other] < full.shape[other]:
            more = (
                full[i : ends[0], ends[1]]
                if other
                else full[ends[0], k : ends[1]]
            )
            if not more.all():
                break
            ends[other] += 1
        full[i : ends[0], k : ends[1]] = False
        low = np.array([xs[i], ys[k]])
        high = np.array([xs[ends[0]], ys[ends[1]]])
        boxes.append(
            Box(
                center=tuple(((low + high) / 2).round(4)),
                size=tuple((high - low).round(4)),
            )
        )
    return boxes


def furnish(
    room: Rect,
    doors: Sequence[Door],
    use: str,
    random: Generator,
    *,
    number: int,
    aisle: float,
) -> list[Furniture]:
    """Returns up to `number` sets of furniture for a room.

    Doors stay free, and between two sets, or a set and a wall at which it does
    not stand, there is an aisle, in meters.
    """
    x0, y0, x1, y1 = room
    taken = [
        shapely.box(*it.rect).buffer(_BEFORE, join_style="mitre")
        for it in doors
    ]
    kept = len(taken)
    names = USES[use]
    result: list[Furniture] = []
    for n in range(number):
        chosen = _SETS[
            names[n] if n < 2 else names[random.integers(len(names))]
        ]
        for _ in range(_TRIES):
            # Its back is to the west, south, east or north.
            turn = int(random.integers(4))
            w, d = chosen.size[:: 1 - 2 * (turn % 2)]
            inner = (aisle, aisle) if not chosen.at_wall else (_OFF, _OFF)
            low = np.array([x0 + w / 2, y0 + d / 2]) + inner
            high = np.array([x1 - w / 2, y1 - d / 2]) - inner
            if (high < low).any():
                continue
            at = low + random.random(2) * (high - low)
            if chosen.at_wall:
                side = turn % 2
                at[side] = (low if turn < 2 else high)[side]
                # Not nearly in a corner.
                along = 1 - side
                for end in (low[along], high[along]):
                    if abs(at[along] - end) < aisle:
                        at[along] = end
            cx, cy = (float(it) for it in at.round(2))
            box = shapely.box(cx - w / 2, cy - d / 2, cx + w / 2, cy + d / 2)
            near = [box.distance(it) for it in taken]
            if any(it <= 0 for it in near[:kept]) or any(
                it < aisle for it in near[kept:]
            ):
                continue
            taken.append(box)
            result += _pieces(chosen, cx, cy, turn * math.pi / 2)
            break
    return result


def _pieces(chosen: _Set, x: float, y: float, yaw: float) -> list[Furniture]:
    c, s = round(math.cos(yaw)), round(math.sin(yaw))
    return [
        FURNITURE.make(
            {
                "type": kind,
                "center": (
                    round(x + c * px - s * py, 3),
                    round(y + s * px + c * py, 3),
                ),
                "yaw": round(math.remainder(yaw + turn, 2 * math.pi), 4),
                **options,
            }
        )
        for kind, px, py, turn, options in chosen.pieces
    ]


def free_place(
    room: Rect, world: World, radius: float, random: Generator
) -> tuple[float, float]:
    """Returns a place in a room for a disc, (x, y) in W; all in meters.

    Raises:
        NoRoomError: If none of some places is free.
    """
    shapes = [
        shapely.Polygon(outline)
        for fixture in world.fixtures()
        for outline in fixture.footprints
    ]
    tree = shapely.STRtree(shapes)
    low, high = np.array(room[:2]) + radius, np.array(room[2:]) - radius
    for _ in range(_TRIES if (low <= high).all() else 0):
        at = (low + random.random(2) * (high - low)).round(2)
        if not len(tree.query(shapely.Point(at), "dwithin", radius)):
            return float(at[0]), float(at[1])
    raise NoRoomError("a room has no place for the robot")
