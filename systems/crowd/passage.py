"""How people get through narrow passages, compiled by numba.

The walls of a door push back whoever wants to pass it: with the forces alone,
nobody of 0.35 m radius passes one of 0.85 m, through which people of that size
walk every day. Those who are about to pass between two walls therefore turn
their shoulders, and mind the walls less.
"""

import math

import numba
from numba import float64, types
import numpy as np

from hunav_drake.systems.columns import (
    DESIRED_SPEED,
    GOAL_RADIUS,
    GOAL_X,
    GOAL_Y,
    HAS_GOAL,
)
from hunav_drake.systems.crowd.constants import K_GOAL, K_OBSTACLE, TAU
from hunav_drake.systems.crowd.force_terms import wall_force
from hunav_drake.systems.crowd.sweep import crosses, nearest_on_path, out_of_box
from hunav_drake.systems.layout import X, Y
from hunav_drake.systems.nearest import (
    INDICES,
    INTEGER,
    MATRIX,
    REAL,
    VECTOR,
    jit,
    jit_as,
    nearest_on_segments,
)

# How far ahead people look for passages, and how wide the widest is, in
# meters. Farther walls hardly push.
_AHEAD = 1.5
_WIDEST = 2.0

# The part of the half width of a passage that a body turns itself to fill.
_FILLED = 0.9

# No body turns itself thinner than this, in meters.
_THINNEST = 0.05

# The most that walls ahead may push back, as a part of the pull of the goal.
_SHARE = 0.7

# At how many places ahead their push is computed, and how far they are from
# each other, in meters.
_STEPS = 16
_STEP = _AHEAD / (_STEPS - 1)

# Lengths that differ less are the same, in meters.
_SAME = 1e-9


@jit
def _width(x, y, ex, ey, distance, radius, segments):
    """Returns how wide the passage is that a person is in, or comes to.

    Args:
        x: Where the person is, in meters.
        y: Likewise.
        ex: The direction to the next waypoint, of length one.
        ey: Likewise.
        distance: That of the waypoint, in meters.
        radius: Of the person, in meters.
        segments: Shape (s, 4): see `Obstacles`.

    Returns:
        The sum of the distances to the nearest walls on the left and on the
        right of the way straight ahead, in meters; infinity without walls on
        both sides, and zero if a wall is before the waypoint. Walls that the
        body has left behind, or that are beyond the waypoint and across, do
        not count.
    """
    qx = x + _AHEAD * ex
    qy = y + _AHEAD * ey
    left = math.inf
    right = math.inf
    for s in range(len(segments)):
        if out_of_box(x, y, qx, qy, _WIDEST, segments, s):
            continue
        near, where = nearest_on_path(x, y, qx, qy, segments, s)
        if where < 0:
            gx = x + distance * ex
            gy = y + distance * ey
            if crosses(x, y, gx, gy, segments, s):
                return 0.0
            continue
        walked = where * _AHEAD
        wx, wy, _ = nearest_on_segments(
            x + walked * ex, y + walked * ey, segments, s, s + 1
        )
        along = (wx - x) * ex + (wy - y) * ey
        if along < -radius or along > _AHEAD + _SAME:
            continue
        if ex * (wy - y) - ey * (wx - x) > 0:
            left = min(left, near)
        else:
            right = min(right, near)
    return left + right


@jit_as(
    types.Tuple((numba.boolean, float64[:, ::1])),
    *(MATRIX, MATRIX, VECTOR, MATRIX, REAL, REAL),
    *(MATRIX, INDICES, REAL, INTEGER),
)
def ease(
    positions,
    command,
    radii,
    parameters,
    margin,
    narrowest,
    segments,
    first,
    reach,
    most,
):
    """Returns with what radii, and how hard, people feel the walls.

    Somebody who walks between two walls, at most 2 m apart, has a body that
    fills 90 % of the passage at most, and the push of walls so much weaker
    that, within the next 1.5 m of the way, it is nowhere more than 70 % of the
    goal's pull. For everybody else, all is as it was.

    Args:
        positions: Shape (n, 2 or more): x, y, ..., in meters.
        command: Shape (n, COMMAND_SIZE), with waypoints for goals.
        radii: Shape (n,), in meters.
        parameters: Shape (n, 13): the fields of SocialForceParameters.
        margin: What a model keeps between bodies and walls, in meters.
        narrowest: Passages narrower than this are none, in meters.
        segments: Shape (s, 4): see `Obstacles`.
        first: Shape (k + 1,): see `Obstacles`.
        reach: Shapes farther than this are not felt, in meters.
        most: How many shapes are felt at most; 0 for all within reach.

    Returns:
        Whether anything has changed; and of shape (n, 2), the radius in
        meters, and the obstacle factor in m/s^2.
    """
    n = len(positions)
    eased = np.empty((n, 2))
    changed = False
    for i in range(n):
        eased[i, 0] = radii[i]
        eased[i, 1] = parameters[i, K_OBSTACLE]
        x = positions[i, X]
        y = positions[i, Y]
        ex = command[i, GOAL_X] - x
        ey = command[i, GOAL_Y] - y
        distance = math.hypot(ex, ey)
        speed = command[i, DESIRED_SPEED]
        if (
            command[i, HAS_GOAL] == 0
            or distance <= command[i, GOAL_RADIUS]
            or speed <= 0
        ):
            continue
        ex /= distance
        ey /= distance
        width = _width(x, y, ex, ey, distance, radii[i], segments)
        if width < narrowest - _SAME or width > _WIDEST:
            continue
        thin = max(_FILLED * width / 2 - margin, _THINNEST)
        eased[i, 0] = min(radii[i], thin)
        back = 0.0
        for step in range(_STEPS):
            fx, fy = wall_force(
                *(x + step * _STEP * ex, y + step * _STEP * ey, eased[i, 0]),
                *(parameters[i], segments, first, reach, most),
            )
            back = max(back, -(fx * ex + fy * ey))
        pull = _SHARE * parameters[i, K_GOAL] * speed / parameters[i, TAU]
        if back > pull:
            eased[i, 1] *= pull / back
        if eased[i, 0] != radii[i] or back > pull:
            changed = True
    return changed, eased
