"""NavFn: paths on a costmap, down the potential of a wave from the start."""

import math
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.planning.global_planner.navfn_kernel import (
    navfn_descent,
    navfn_potential,
)
from hunav_drake.systems.world.maps.costs import (
    INSCRIBED,
    LETHAL,
    UNKNOWN,
    Costmap,
)

Smoothing = Literal["none", "gaussian"]

# The lengths over which a path is smoothed, in meters; the first valid one is
# used.
_LENGTHS = (0.3, 0.15, 0.075)

NO_WAY: Array = np.zeros((0, 3))
NO_WAY.setflags(write=False)


class GlobalPath(NamedTuple):
    """A path on a map, or the reason why there is none.

    Attributes:
        poses: Shape (k, 3), rows (x, y, yaw) in W, from the start on; k is 0 if
            there is no path. Each pose faces the next, the last has the goal's
            yaw.
        misses: The distance of its end from the goal, in meters: 0, or up to
            about the tolerance if the goal itself cannot be reached.
        fault: Why there is no path; empty if there is one.
    """

    poses: Array
    misses: float = 0.0
    fault: str = ""


def plan_path(
    costmap: Costmap,
    start: ArrayLike,
    goal: ArrayLike,
    *,
    tolerance: float = 0.5,
    allow_unknown: bool = True,
    smoothing: Smoothing = "none",
) -> GlobalPath:
    """Returns a path from a start to a goal on a costmap, found by NavFn.

    A wave propagates from the start. To cross a cell of cost c takes ``min(253,
    floor(50 + 0.8 c))``; cells of cost 253 and more and the border of the map
    are impassable, except the cell of the start. The path descends the wave's
    potential from the goal. If the goal cannot be reached, the path leads to
    the nearest cell that can, among those within the tolerance along x and
    along y. (Konolige 2000; nav2_navfn_planner. There, paths begin and end in
    the corners of cells; here, in their centers.)

    Args:
        costmap: The costs of cells.
        start: (x, y) in W, in meters; more is ignored.
        goal: (x, y) or (x, y, yaw) in W, in meters and radians.
        tolerance: In meters.
        allow_unknown: Whether unknown cells may be crossed.
        smoothing: "gaussian" smooths the path where costs allow it.
    """
    x, y = np.asarray(start, dtype=float)[:2].tolist()
    goal_x, goal_y = np.asarray(goal, dtype=float)[:2].tolist()
    rows, columns = costmap.costs.shape
    first, last = costmap.cell_at(x, y), costmap.cell_at(goal_x, goal_y)
    for name, cell, place in (
        ("start", first, (x, y)),
        ("goal", last, (goal_x, goal_y)),
    ):
        if not (0 <= cell[0] < rows and 0 <= cell[1] < columns):
            return GlobalPath(
                NO_WAY, fault=f"the {name} {_at(*place)} is off the map"
            )
    potential = navfn_potential(costmap.costs, *first, *last, allow_unknown)
    end = last
    if not potential[last] < math.inf:
        near = _nearest_reached(costmap, potential, goal_x, goal_y, tolerance)
        if near is None:
            fault = _why(costmap, (x, y), (goal_x, goal_y), tolerance)
            return GlobalPath(NO_WAY, fault=fault)
        end = near
    cells = navfn_descent(potential, *end, *first)
    if not len(cells):
        return GlobalPath(NO_WAY, fault="no path can be traced back on the map")
    points = cells[::-1] + 0.5
    points *= costmap.resolution
    points += costmap.origin
    misses = 0.0
    if end == last:
        # The last point becomes the goal itself.
        points[-1] = goal_x, goal_y
    else:
        misses = math.hypot(points[-1, 0] - goal_x, points[-1, 1] - goal_y)
    if smoothing == "gaussian":
        points = smooth_path(points, costmap)
    yaw = np.asarray(goal, dtype=float)[2:3]
    return GlobalPath(_with_yaws(points, yaw), misses)


def _with_yaws(points: Array, last: Array) -> Array:
    """Returns points with the yaw to the next one, shape (k, 3)."""
    poses = np.zeros((len(points), 3))
    poses[:, :2] = points
    if len(points) > 1:
        step = np.diff(points, axis=0)
        poses[:-1, 2] = np.arctan2(step[:, 1], step[:, 0])
        poses[-1, 2] = poses[-2, 2]
    if len(last):
        poses[-1, 2] = last[0]
    return poses


def _nearest_reached(
    costmap: Costmap, potential: Array, x: float, y: float, tolerance: float
) -> tuple[int, int] | None:
    """Returns the cell nearest to a point among those that the wave reached."""
    rows, columns = potential.shape
    low = costmap.cell_at(x - tolerance, y - tolerance)
    high = costmap.cell_at(x + tolerance, y + tolerance)
    r0, c0 = max(low[0], 0), max(low[1], 0)
    part = potential[
        r0 : min(high[0] + 1, rows), c0 : min(high[1] + 1, columns)
    ]
    i, j = np.nonzero(np.isfinite(part))
    if not len(i):
        return None
    left, bottom = costmap.center_of(r0, c0)
    r = costmap.resolution
    squared = (left + j * r - x) ** 2 + (bottom + i * r - y) ** 2
    best = int(np.argmin(squared))
    return r0 + int(i[best]), c0 + int(j[best])


def _why(
    costmap: Costmap,
    start: tuple[float, float],
    goal: tuple[float, float],
    tolerance: float,
) -> str:
    """Returns the reason why there is no path."""
    at_start, at_goal = costmap.cost_at(*start), costmap.cost_at(*goal)
    words = {
        LETHAL: "is in an obstacle",
        INSCRIBED: "is nearer to an obstacle than the robot's radius",
        UNKNOWN: "is in unknown space",
    }
    if at_goal >= INSCRIBED:
        return (
            f"the goal {_at(*goal)} {words[at_goal]}, and no place within"
            f" {tolerance:g} m of it can be reached"
        )
    if INSCRIBED <= at_start < UNKNOWN:
        return f"the start {_at(*start)} {words[at_start]}"
    return f"there is no path from {_at(*start)} to the goal {_at(*goal)}"


def _at(x: float, y: float) -> str:
    return f"({x:.2f}, {y:.2f})"


def smooth_path(points: Array, costmap: Costmap) -> Array:
    """Returns a path (k, 2) smoothed along its length, with the same ends.

    It is smoothed less, or not at all, if it would otherwise cross much higher
    costs.
    """
    # Only paths that are smoothed need it, and it loads slowly.
    from scipy import ndimage

    if len(points) < 3:
        return points
    lengths = np.hypot(*np.diff(points, axis=0).T)
    spacing = max(float(lengths.mean()), 1e-6)
    allowed = np.maximum(_costs(costmap, points), 0.5 * INSCRIBED)
    for length in _LENGTHS:
        sigma = length / spacing
        # Mirrored at its ends, so that these stay fixed.
        near = min(int(4 * sigma) + 1, len(points) - 1)
        mirrored = np.pad(
            points, ((near, near), (0, 0)), "reflect", reflect_type="odd"
        )
        smooth: Array = ndimage.gaussian_filter1d(
            mirrored, sigma, axis=0, mode="nearest"
        )[near:-near]
        smooth[0], smooth[-1] = points[0], points[-1]
        if (_costs(costmap, smooth) <= allowed).all():
            return smooth
    return points


def _costs(costmap: Costmap, points: Array) -> Array:
    cells = np.floor((points - costmap.origin) / costmap.resolution)
    rows, columns = costmap.costs.shape
    j = np.clip(cells[:, 0], 0, columns - 1).astype(np.int64)
    i = np.clip(cells[:, 1], 0, rows - 1).astype(np.int64)
    costs: Array = costmap.costs[i, j].astype(float)
    return costs
