"""How people get through narrow passages, compiled by numba.

The walls of a door push back whoever wants to pass it: with the forces alone,
nobody of 0.35 m radius passes one of 0.85 m, through which people of that size
walk every day. Those who are about to pass between two walls therefore turn
their shoulders, and mind the walls less.
"""

import math

from numba import float64

from hunav_drake.systems.common.kernels import (
    INTEGER,
    MATRIX,
    REAL,
    WALLS,
    jit,
    jit_as,
)
from hunav_drake.systems.common.layout import Command, X, Y
from hunav_drake.systems.crowd.social_force.compiled_forces import wall_force
from hunav_drake.systems.people.parameters import K_GOAL, TAU
from hunav_drake.systems.world.nearest import nearest_on_segments
from hunav_drake.systems.world.walls import (
    distance2_to_box,
    opened,
    out_of_box,
    runs_in,
)

# How far ahead people look for passages, and how wide the widest is, in
# meters. Farther walls hardly push.
_AHEAD = 1.5
_WIDEST = 2.0

# Of the widest, the part from which on people ease less and less.
_WIDE = 0.75

# Of the narrowest way, the parts at which people begin to ease, and do so
# wholly. (The map has said that there is a way, so this need not be sharp.)
_NONE = 0.75
_WHOLE = 0.9

# Who would scrape a wall does not ease: from this distance on less and less,
# in meters, and at half of it not at all.
_SCRAPE = 0.08

# The part of the half width of a passage that a body turns itself to fill.
_FILLED = 0.9

# No body turns itself thinner than this, in meters.
_THINNEST = 0.05

# The most that walls ahead may push back, as a part of the pull of the goal.
_SHARE = 0.7

# At how many places ahead passages are looked for.
_STEPS = 16


@jit
def _rise(value, low, high):
    """Returns 0 below `low`, 1 above `high`, and goes straight between."""
    return min(max((value - low) / (high - low), 0.0), 1.0)


@jit
def _passage(x, y, ex, ey, ahead, distance, walls):
    """Returns how wide, and how clear of walls, the way of a person is.

    The way goes from (x, y) in the direction (ex, ey) of the next waypoint. The
    width is the least sum of the distances to walls on the left and on the
    right of a place on it. Walls rather ahead or behind than beside are farther
    than they are, so that it changes continuously when somebody moves or turns.
    """
    width = math.inf
    clear = math.inf
    qx = x + ahead * ex
    qy = y + ahead * ey
    runs = runs_in(
        *(min(x, qx) - _WIDEST, min(y, qy) - _WIDEST),
        *(max(x, qx) + _WIDEST, max(y, qy) + _WIDEST),
        walls,
    )
    for step in range(_STEPS):
        walked = step * ahead / (_STEPS - 1)
        px = x + walked * ex
        py = y + walked * ey
        left = math.inf
        right = math.inf
        for i in range(len(runs)):
            lo, hi, _, box = walls.runs[runs[i]]
            # What is farther than all found so far changes nothing.
            found = max(left, right, clear if walked <= distance else 0.0)
            if distance2_to_box(px, py, walls.boxes, box) > found * found:
                continue
            for s in range(lo, hi):
                if out_of_box(x, y, qx, qy, _WIDEST, walls.segments, s):
                    continue
                wx, wy, d2 = nearest_on_segments(
                    px, py, walls.segments, s, s + 1
                )
                near = math.sqrt(d2)
                if walked <= distance:
                    clear = min(clear, near)
                aside = ex * (wy - py) - ey * (wx - px)
                if aside == 0:
                    continue
                felt = near * math.sqrt(math.sqrt(near / abs(aside)))
                if aside > 0:
                    left = min(left, felt)
                else:
                    right = min(right, felt)
        width = min(width, left + right)
    return width, clear


@jit
def _ease_one(x, y, own, command, k, margin, narrowest, felt, result):
    """Changes with what radius, and how hard, one person feels the walls.

    `own` and `result` are these two; `felt` is the walls, how far they are
    felt, and how many: see `ease`.
    """
    ex = command[Command.GOAL_X] - x
    ey = command[Command.GOAL_Y] - y
    distance = math.hypot(ex, ey)
    speed = command[Command.DESIRED_SPEED]
    if (
        command[Command.HAS_GOAL] == 0
        or distance <= command[Command.GOAL_RADIUS]
        or speed <= 0
    ):
        return
    ex /= distance
    ey /= distance
    # People stop at goals; of waypoints, they go on.
    ahead = _AHEAD
    if command[Command.GOAL_RADIUS] > 0:
        ahead = min(distance, _AHEAD)
    walls, reach, most = felt
    width, clear = _passage(x, y, ex, ey, ahead, distance, walls)
    weight = _rise(width, _NONE * narrowest, _WHOLE * narrowest)
    weight *= 1 - _rise(width, _WIDE * _WIDEST, _WIDEST)
    weight *= _rise(clear, _SCRAPE / 2, _SCRAPE)
    if weight == 0:
        return
    radius, factor = own
    thin = max(_FILLED * width / 2 - margin, _THINNEST)
    radius += weight * min(thin - radius, 0.0)
    back = 0.0
    for step in range(_STEPS):
        walked = step * ahead / (_STEPS - 1)
        fx, fy = wall_force(
            *(x + walked * ex, y + walked * ey, radius, factor),
            *(k, walls, reach, most),
        )
        back = max(back, -(fx * ex + fy * ey))
    pull = _SHARE * k[K_GOAL] * speed / k[TAU]
    if back > pull:
        factor *= 1 - weight * (1 - pull / back)
    result[0] = radius
    result[1] = factor


@jit_as(
    float64[:, ::1],
    *(MATRIX, MATRIX, MATRIX, MATRIX, REAL, REAL),
    *(WALLS, REAL, INTEGER),
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
):
    """Returns with what radii, and how hard, people feel the walls.

    Somebody who walks between two walls, at most 2 m apart, has a body that
    fills 90 % of the passage at most, and the push of walls so much weaker
    that, within the next 1.5 m of the way, it is nowhere more than 70 % of the
    goal's pull. For everybody else, all is as it was. Between the two there is
    no jump: it depends continuously on places and waypoints.

    Args:
        positions: Shape (n, 2 or more): x, y, ..., in meters.
        command: Shape (n, COMMAND_SIZE), with waypoints for goals.
        at_walls: Shape (n, 2), as the result: the radii in meters, and the
            obstacle factors in m/s^2, of the people.
        parameters: As for `kernel.social_forces`, like the last three.
        margin: What a model keeps between bodies and walls, in meters.
        narrowest: Passages much narrower than this are none, in meters.
        table: `Obstacles.table`.
        reach: In meters.
        most: How many shapes.
    """
    walls = opened(table)
    eased = at_walls.copy()
    for i in range(len(positions)):
        _ease_one(
            *(positions[i, X], positions[i, Y]),
            (at_walls[i, 0], at_walls[i, 1]),
            *(command[i], parameters[i], margin, narrowest),
            (walls, reach, most),
            eased[i],
        )
    return eased
