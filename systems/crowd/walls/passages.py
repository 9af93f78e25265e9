"""Lets people through narrow passages, compiled by numba.

The walls of a door push back people who want to pass it: with the forces alone,
nobody of 0.35 m radius passes one of 0.85 m, which people of that size pass
every day. Therefore people who are about to pass between two walls turn their
shoulders, and walls push them less.
"""

import math

from numba import boolean, float64

from hunav_drake.systems.common.kernels import INTEGER, MATRIX, REAL, WALLS, jit
from hunav_drake.systems.common.late import late_as
from hunav_drake.systems.common.layout import Command, X, Y
from hunav_drake.systems.crowd.walls.beside import (
    STEPS,
    WIDEST,
    offsets_of_shapes,
    passage_width,
    places_ahead,
    push_back,
    walls_beside,
    way_ahead,
)
from hunav_drake.systems.people.parameters import K_GOAL, TAU
from hunav_drake.systems.world.walls import opened

# The part of WIDEST from which on people ease less and less.
_WIDE = 0.75

# The parts of the narrowest way at which people begin to ease, and do so
# wholly. (The map has found a way, so this need not be sharp.)
_NONE = 0.75
_WHOLE = 0.9

# People who would scrape a wall do not ease: below this distance less and less,
# in meters, and at half of it not at all.
_SCRAPE = 0.08

# The part of the half width of a passage that a turned body fills.
_FILLED = 0.9

# The least radius of a turned body, in meters.
_THINNEST = 0.05

# The largest push of walls ahead, as a part of the pull of the goal.
_SHARE = 0.7


@jit
def _rise(value, low, high):
    """Returns 0 below `low`, 1 above `high`, and goes straight between."""
    return min(max((value - low) / (high - low), 0.0), 1.0)


@jit
def _ease_one(x, y, own, command, k, margin, narrowest, felt, turning, result):
    """Changes the radius and the obstacle factor of one person at walls.

    `own` and `result` are these two; `felt` is the walls, their range, and
    their largest number: see `ease`.
    """
    goes, ex, ey, ahead, distance = way_ahead(x, y, command)
    if not goes:
        return
    fits, radius, factor = _eased(
        *(x, y, ex, ey, ahead, distance),
        *(own, command, k, margin, narrowest, felt),
    )
    if turning and fits < 1 and distance < ahead:
        # What is too narrow is perhaps beyond the waypoint, where people turn.
        _, nearer, weaker = _eased(
            *(x, y, ex, ey, distance, distance),
            *(own, command, k, margin, narrowest, felt),
        )
        radius += (1 - fits) * min(nearer - radius, 0.0)
        factor += (1 - fits) * min(weaker - factor, 0.0)
    result[0] = radius
    result[1] = factor


@jit
def _eased(
    x, y, ex, ey, ahead, distance, own, command, k, margin, narrowest, felt
):
    """Returns whether a way fits, 0 to 1, and the radius and factor on it.

    The way in the direction (ex, ey) is as long as `ahead`; `distance` is that
    of the waypoint. The others are those of `_ease_one`.
    """
    radius, factor = own
    walls = felt[0]
    px, py = places_ahead(x, y, ex, ey, ahead)
    beside = walls_beside(x, y, ex, ey, ahead, walls)
    width = passage_width(px, py, ex, ey, beside, walls)
    fits = _rise(width, _NONE * narrowest, _WHOLE * narrowest)
    weight = fits * (1 - _rise(width, _WIDE * WIDEST, WIDEST))
    if weight == 0:
        return fits, radius, factor
    found = offsets_of_shapes(px, py, beside, walls)
    clear = math.inf
    for step in range(STEPS):
        if step * ahead <= (STEPS - 1) * distance:
            clear = min(clear, math.sqrt(found[2, :, step].min()))
    weight *= _rise(clear, _SCRAPE / 2, _SCRAPE)
    if weight == 0:
        return fits, radius, factor
    thin = max(_FILLED * width / 2 - margin, _THINNEST)
    radius += weight * min(thin - radius, 0.0)
    pull = _SHARE * k[K_GOAL] * command[Command.DESIRED_SPEED] / k[TAU]
    back = push_back(*(px, py, ex, ey, (radius, factor), k, pull, felt, found))
    if back > pull:
        factor *= 1 - weight * (1 - pull / back)
    return fits, radius, factor


@late_as(
    float64[:, ::1],
    *(MATRIX, MATRIX, MATRIX, MATRIX, REAL, REAL),
    *(WALLS, REAL, INTEGER, boolean),
)
def ease(
    positions,
    command,
    at_walls,
    parameters,
    margin,
    narrowest,
    table,
    reach,
    most,
    turning,
):
    """Returns the radii and the obstacle factors of people at walls.

    A person who walks between two walls, at most 2 m apart, has a body that
    fills 90 % of the passage at most, and the push of walls is so much weaker
    that, within the next 1.5 m of the way, it is nowhere more than 70 % of the
    goal's pull. For all others nothing changes. In between, the result
    depends continuously on positions and waypoints, except where one more place
    ahead scrapes a wall, or a wall without thickness comes into the way.

    Rows of positions are x, y, ..., commands have waypoints for goals, and
    `at_walls` are the own radii and factors. `margin` is the clearance of a
    model between bodies and walls; passages much narrower than `narrowest` do
    not count, both in meters, unless `turning` tells that they are too narrow
    only beyond the waypoint, where people turn.
    """
    walls = opened(table)
    eased = at_walls.copy()
    for i in range(len(positions)):
        _ease_one(
            *(positions[i, X], positions[i, Y]),
            (at_walls[i, 0], at_walls[i, 1]),
            *(command[i], parameters[i], margin, narrowest),
            *((walls, reach, most), turning, eased[i]),
        )
    return eased
