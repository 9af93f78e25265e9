"""Checks of geometry: valid shapes, and free space for everybody."""

from collections.abc import Iterator
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hunav_drake.scenario.error import Finding, Loc, path_text
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.world.obstacles import (
    Obstacles,
    inside,
    nearest_points,
)
from hunav_drake.systems.world.shapes import Polygon, Polyline, Wall

# Points nearer to each other than this, in meters, are the same.
_SAME = 1e-9

# The most pairs of a wall and a place to keep free of it that are looked at.
_MAX_PAIRS = 10**7

# How many pairs of a polygon's sides are compared at once.
_BLOCK = 20_000


def check_walls(scenario: Scenario) -> Iterator[Finding]:
    """Looks for shapes that have no sides, or no one inside."""
    for i, wall in enumerate(scenario.world.walls):
        loc: Loc = ("world", "walls", i, "points")
        if isinstance(wall, Polyline):
            points = wall.vertices()
            for k in _repeated(points):
                yield Finding((*loc, k + 1), f"repeats points[{k}]")
        elif isinstance(wall, Polygon):
            yield from _check_polygon(wall.vertices(), loc)


def _repeated(points: NDArray[np.float64]) -> list[int]:
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return [int(k) for k in np.flatnonzero(steps <= _SAME)]


def _check_polygon(points: NDArray[np.float64], loc: Loc) -> Iterator[Finding]:
    """Looks for what keeps a polygon from being simple; one fault at most."""
    if repeated := _repeated(points):
        k = repeated[0]
        yield Finding((*loc, k + 1), f"repeats points[{k}]")
        return
    last = len(points) - 1
    if np.linalg.norm(points[last] - points[0]) <= _SAME:
        yield Finding(
            (*loc, last),
            "repeats points[0]; the last corner joins the first by itself",
        )
        return
    p, q = points, np.roll(points, -1, axis=0)
    centered = points - points.mean(axis=0)
    extent = float(np.abs(centered).max())
    # Singular values: how far the corners spread along and across a line.
    spread = np.linalg.svd(centered, compute_uv=False)
    if spread[1] <= _SAME * max(extent, 1.0):
        yield Finding(loc, "must enclose an area; the corners lie on a line")
        return
    if crossing := _crossing_sides(p, q):
        i, j = crossing
        yield Finding(
            loc,
            f"must not cross itself; the side from points[{i}] meets the side"
            f" from points[{j}]",
        )


def _crossing_sides(
    p: NDArray[np.float64], q: NDArray[np.float64]
) -> tuple[int, int] | None:
    """Returns two sides of a polygon that meet where they should not.

    Args:
        p: Where the sides begin, shape (n, 2).
        q: Where they end, shape (n, 2).
    """
    low, high = np.minimum(p, q), np.maximum(p, q)
    near = np.all(
        (low[:, None] <= high[None]) & (low[None] <= high[:, None]), axis=-1
    )
    i, j = np.nonzero(np.triu(near, 1))
    # In blocks, for most polygons that cross themselves do so early.
    for start in range(0, len(i), _BLOCK):
        block = slice(start, start + _BLOCK)
        meets = _meets(p, q, i[block], j[block])
        if meets.any():
            k = start + int(np.argmax(meets))
            return int(i[k]), int(j[k])
    return None


def _meets(
    p: NDArray[np.float64],
    q: NDArray[np.float64],
    i: NDArray[np.int64],
    j: NDArray[np.int64],
) -> NDArray[np.bool_]:
    """Tells which sides i and j > i meet, but for a corner that they share."""
    along = q - p

    def splits(i: NDArray[np.int64], j: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Tells whether the line of each i has the ends of j on both sides."""
        ahead = np.sign(_cross(along[i], p[j] - p[i]))
        behind = np.sign(_cross(along[i], q[j] - p[i]))
        result: NDArray[np.bool_] = ahead * behind <= 0
        return result

    # Neighbors meet elsewhere only by doubling back.
    neighbors = (j == i + 1) | (j == i + len(p) - 1)
    doubling = (_cross(along[i], along[j]) == 0) & (
        np.sum(along[i] * along[j], axis=1) < 0
    )
    return np.where(neighbors, doubling, splits(i, j) & splits(j, i))


def _cross(
    a: NDArray[np.float64], b: NDArray[np.float64]
) -> NDArray[np.float64]:
    result: NDArray[np.float64] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return result


class _Spot(NamedTuple):
    """A place that must be free of walls."""

    loc: Loc
    position: tuple[float, float]
    # The radius, in meters, of what stands there; 0 if only the point counts.
    radius: float
    uses: tuple[Loc, ...] = ()


def check_places(scenario: Scenario) -> Iterator[Finding]:
    """Looks for starts and goals that walls, or other bodies, take up.

    Bodies must not overlap walls. A person's goal must not be inside one; it
    may be nearer to it than the radius, for `goal_radius` is reached before.
    """
    yield from _check_robot_and_people(scenario)
    robot = scenario.robot
    body: tuple[Loc, ...] = (("robot", "radius"),)
    spots = [_Spot(("robot", "start"), robot.start[:2], robot.radius, body)]
    if robot.goal is not None:
        goal = _Spot(("robot", "goal"), robot.goal[:2], robot.radius, body)
        spots.append(goal)
    for i, human in enumerate(scenario.humans):
        loc: Loc = ("humans", i)
        body = ((*loc, "radius"),)
        spots.append(_Spot((*loc, "pose"), human.pose[:2], human.radius, body))
        spots += [
            _Spot((*loc, "goals", k), goal, 0.0)
            for k, goal in enumerate(human.goals)
        ]
    yield from _check_spots(scenario, spots)


def _check_robot_and_people(scenario: Scenario) -> Iterator[Finding]:
    robot = scenario.robot
    for i, human in enumerate(scenario.humans):
        gap = math.dist(robot.start[:2], human.pose[:2])
        overlap = robot.radius + human.radius - gap
        if overlap > _SAME:
            loc: Loc = ("humans", i)
            other = path_text(scenario, loc)
            yield Finding(
                ("robot", "start"),
                f"overlaps {other} by {_up(overlap)} m; move one of them",
                uses=(
                    ("robot", "radius"),
                    (*loc, "pose"),
                    (*loc, "radius"),
                ),
            )


def _check_spots(scenario: Scenario, spots: list[_Spot]) -> Iterator[Finding]:
    """Reports the first wall that takes up each spot."""
    if len(spots) * len(scenario.world.walls) > _MAX_PAIRS:
        yield Finding(
            ("world", "walls"),
            f"are too many for {len(spots)} starts and goals: at most"
            f" {_MAX_PAIRS // len(spots)}, got {len(scenario.world.walls)}",
            uses=(("humans",),),
        )
        return
    positions = np.array([spot.position for spot in spots], dtype=float)
    radii = np.array([spot.radius for spot in spots])
    free = np.full(len(spots), True)
    # Wall by wall, and only what is near: files may hold many of both.
    for w, wall in enumerate(scenario.world.walls):
        vertices = wall.vertices()
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        reach = radii[:, None]
        near = np.all(
            (positions > low - reach) & (positions < high + reach), axis=1
        )
        indices = np.flatnonzero(free & near)
        if not len(indices):
            continue
        depths, ways = _depths(wall, positions[indices], radii[indices])
        for i, depth, way in zip(indices, depths, ways, strict=True):
            if depth > _SAME:
                free[i] = False
                spot, loc = spots[i], ("world", "walls", w)
                message = _message(path_text(scenario, loc), spot, depth, way)
                yield Finding(spot.loc, message, uses=(*spot.uses, loc))


def _depths(
    wall: Wall, points: NDArray[np.float64], radii: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Returns how far discs reach into a wall, and the way out.

    Args:
        wall: The wall.
        points: The centers of the discs, shape (n, 2), in meters.
        radii: Shape (n,), in meters.

    Returns:
        The depths, shape (n,), in meters, negative for a free disc; and unit
        vectors, shape (n, 2), zero where the center is on the outline.
    """
    shape = Obstacles.from_shapes([wall.vertices()], solid=[wall.solid])
    away = points - nearest_points(shape, points)[:, 0]
    within = inside(shape, points)[:, 0]
    distances = np.linalg.norm(away, axis=1)
    away /= np.where(distances > 0, distances, 1.0)[:, None]
    sign = np.where(within, -1.0, 1.0)
    return radii - sign * distances, away * sign[:, None]


def _message(
    wall: str, spot: _Spot, depth: float, way: NDArray[np.float64]
) -> str:
    how = "is inside" if depth > spot.radius else "overlaps"
    direction = ""
    if way.any():
        direction = f" along ({way[0]:z.2f}, {way[1]:z.2f})"
    return f"{how} {wall}; move it {_up(depth)} m{direction}"


def _up(length: float) -> str:
    """Returns a length rounded up, so that moving by it is enough."""
    return f"{math.ceil(length * 100 - 1e-6) / 100:.2f}"
