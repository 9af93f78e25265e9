"""The walls beside the next steps of a person, compiled by numba.

Passages are searched at STEPS places on the way to the next waypoint. For each
wall segment, all places are computed at once, which is fast. The bounds skip
only what cannot change a result, not even its last bit.
"""

import math

import numpy as np

from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.crowd.social_force.compiled_forces import wall_force
from hunav_drake.systems.crowd.social_force.constants import MOST
from hunav_drake.systems.people.parameters import SIGMA
from hunav_drake.systems.world.nearest import nearest_on_segments
from hunav_drake.systems.world.walls import out_of_box, runs_in

# The distance ahead in which people look for passages, in meters.
AHEAD = 1.5

# The width of the widest passage, in meters. Farther walls hardly push.
WIDEST = 2.0

# The number of places ahead at which passages are searched.
STEPS = 16

# More than the rounding of lengths, in meters, and of forces, in m/s^2.
_HAIR = 1e-9


@jit
def way_ahead(x, y, command):
    """Returns the way of a person to the next waypoint.

    It is whether the person goes anywhere; the direction (ex, ey) of the next
    waypoint; the distance ahead in which to look for passages; and the distance
    of the waypoint, in meters.
    """
    ex = command[Command.GOAL_X] - x
    ey = command[Command.GOAL_Y] - y
    distance = math.hypot(ex, ey)
    if (
        command[Command.HAS_GOAL] == 0
        or distance <= command[Command.GOAL_RADIUS]
        or command[Command.DESIRED_SPEED] <= 0
    ):
        return False, 0.0, 0.0, 0.0, distance
    # People stop at goals, but walk on at waypoints.
    ahead = AHEAD
    if command[Command.GOAL_RADIUS] > 0:
        ahead = min(distance, AHEAD)
    return True, ex / distance, ey / distance, ahead, distance


@jit
def places_ahead(x, y, ex, ey, ahead):
    """Returns the places (STEPS,), in x and y, on the way of a person.

    It begins at (x, y), and leads in the direction (ex, ey) as far as `ahead`,
    in meters.
    """
    px = np.empty(STEPS)
    py = np.empty(STEPS)
    for step in range(STEPS):
        walked = step * ahead / (STEPS - 1)
        px[step] = x + walked * ex
        py[step] = y + walked * ey
    return px, py


@jit
def walls_beside(x, y, ex, ey, ahead, walls):
    """Returns the segments that may be within WIDEST of a way.

    The arguments are those of `places_ahead`, and `Walls`. The results are
    arrays (n,): the segments, in the order of their shapes; these shapes; the
    least distance of a segment on the left of the way, negative on the right, 0
    if it may be on both sides; and less than its distance from all places, in
    meters.
    """
    qx = x + ahead * ex
    qy = y + ahead * ey
    mx = x + ahead / 2 * ex
    my = y + ahead / 2 * ey
    runs = runs_in(
        *(min(x, qx) - WIDEST, min(y, qy) - WIDEST),
        *(max(x, qx) + WIDEST, max(y, qy) + WIDEST),
        walls,
    )
    segments = walls.segments
    near = np.empty(len(segments), dtype=np.int64)
    shapes = np.empty(len(segments), dtype=np.int64)
    left = np.empty(len(segments))
    least = np.empty(len(segments))
    count = 0
    farthest = WIDEST + ahead / 2 + _HAIR
    for run in runs:
        for s in range(walls.runs[run, 0], walls.runs[run, 1]):
            if out_of_box(x, y, qx, qy, WIDEST, segments, s):
                continue
            _, _, d2 = nearest_on_segments(mx, my, segments, s, s + 1)
            if d2 >= farthest * farthest:
                continue
            a = ex * (segments[s, 1] - y) - ey * (segments[s, 0] - x)
            b = ex * (segments[s, 3] - y) - ey * (segments[s, 2] - x)
            side = max(0.0, min(a, b)) + min(0.0, max(a, b))
            near[count] = s
            shapes[count] = walls.runs[run, 2]
            left[count] = 0.0 if abs(side) < _HAIR else side
            least[count] = max(abs(side), math.sqrt(d2) - ahead / 2) - _HAIR
            count += 1
    return near[:count], shapes[:count], left[:count], least[:count]


@jit
def _offsets(px, py, segments, s, dx, dy, d2):
    """Writes the offsets of places from segment `s`, and their squares.

    They are those of the nearest point that `nearest_on_segments` gives, with
    the same bits; without branches, so that a processor does several at once.
    """
    sx = segments[s, 0]
    sy = segments[s, 1]
    ax = segments[s, 2] - sx
    ay = segments[s, 3] - sy
    length2 = ax * ax + ay * ay
    if length2 == 0:
        length2 = 1.0
    for step in range(STEPS):
        t = ((px[step] - sx) * ax + (py[step] - sy) * ay) / length2
        t = min(max(t, 0.0), 1.0)
        x = px[step] - (sx + t * ax)
        y = py[step] - (sy + t * ay)
        dx[step] = x
        dy[step] = y
        d2[step] = x * x + y * y


@jit
def _widths_of_side(px, py, ex, ey, sign, limits, beside, walls):
    """Returns the apparent distances (STEPS,) of the walls on one side.

    The places px, py are from `places_ahead`, on a way in the direction (ex,
    ey); `sign` is 1 for its left side, -1 for its right. Walls beyond `limits`
    (STEPS,), which change, do not count; `beside` is from `walls_beside`. The
    result is infinite where nothing counts: see `passage_width`.
    """
    near, _, left, least = beside
    dx = np.empty(STEPS)
    dy = np.empty(STEPS)
    d2 = np.empty(STEPS)
    felt = np.full(STEPS, np.inf)
    farthest = limits.max()
    for i in range(len(near)):
        if left[i] * sign < 0 or least[i] >= farthest:
            continue
        _offsets(px, py, walls.segments, near[i], dx, dy, d2)
        for step in range(STEPS):
            if d2[step] >= limits[step] * abs(limits[step]):
                continue
            aside = sign * (ey * dx[step] - ex * dy[step])
            if aside > 0:
                away = math.sqrt(d2[step])
                seems = away * math.sqrt(math.sqrt(away / aside))
                felt[step] = min(felt[step], seems)
                limits[step] = min(limits[step], felt[step])
        farthest = limits.max()
    return felt


@jit
def passage_width(px, py, ex, ey, beside, walls):
    """Returns the width of the way of a person, in meters.

    It is the least sum of the distances to walls on the left and on the right
    of a place; infinite, or at least WIDEST, where there is no passage. Walls
    ahead or behind, rather than beside, count as farther, so that the width
    changes continuously when a person moves or turns.

    The arguments are those of `_widths_of_side`.
    """
    near, _, left, least = beside
    free_left = np.inf
    free_right = np.inf
    for i in range(len(near)):
        if left[i] >= 0:
            free_left = min(free_left, least[i])
        if left[i] <= 0:
            free_right = min(free_right, least[i])
    if free_left + free_right >= WIDEST:
        return np.inf
    limits = np.full(STEPS, WIDEST - free_right)
    first = _widths_of_side(px, py, ex, ey, 1.0, limits, beside, walls)
    for step in range(STEPS):
        limits[step] = WIDEST - first[step] + _HAIR
    second = _widths_of_side(px, py, ex, ey, -1.0, limits, beside, walls)
    return (first + second).min()


@jit
def offsets_of_shapes(px, py, beside, walls):
    """Returns the offsets from the nearest points of the shapes beside a way.

    They have the shape (3, k, STEPS): x and y of a place minus those of the
    nearest point, and the squared distance, exact where below that of WIDEST.
    """
    near, shapes, _, _ = beside
    dx = np.empty(STEPS)
    dy = np.empty(STEPS)
    d2 = np.empty(STEPS)
    found = np.empty((3, len(near), STEPS))
    count = 0
    for i in range(len(near)):
        if i == 0 or shapes[i] != shapes[i - 1]:
            found[:2, count] = 0.0
            found[2, count] = np.inf
            count += 1
        _offsets(px, py, walls.segments, near[i], dx, dy, d2)
        for step in range(STEPS):
            if d2[step] < found[2, count - 1, step]:
                found[0, count - 1, step] = dx[step]
                found[1, count - 1, step] = dy[step]
                found[2, count - 1, step] = d2[step]
    return found[:, :count]


@jit
def push_back(px, py, ex, ey, own, k, pull, felt, found):
    """Returns the largest force of walls back along a way, if above the pull.

    Else it is any number up to the pull, in m/s^2. The force is computed only
    where the walls nearby might push as much. `own` is the radius and the
    obstacle factor of the person, `k` the parameters, `felt` the walls, their
    range, and their largest number; `found` is from `offsets_of_shapes`, the
    others are as for `_widths_of_side`.
    """
    walls, reach, most = felt
    radius, factor = own
    depth = min((radius - WIDEST) / k[SIGMA], MOST)
    bounds = np.full(STEPS, len(walls.solid) * abs(factor) * math.exp(depth))
    # Pushes ahead count if those walls surely push.
    all_push = most == 0 and reach >= WIDEST
    for j in range(found.shape[1]):
        for step in range(STEPS):
            d2 = found[2, j, step]
            back = -(ex * found[0, j, step] + ey * found[1, j, step]) * factor
            if (back > 0 or all_push) and 0 < d2 < WIDEST * WIDEST:
                near = math.sqrt(d2)
                depth = min((radius - near) / k[SIGMA], MOST)
                push = back / near * math.exp(depth)
                bounds[step] += push + _HAIR * abs(push)
    back = 0.0
    for _ in range(STEPS):
        step = np.argmax(bounds)
        if bounds[step] * (1 + _HAIR) + _HAIR <= max(back, pull):
            break
        bounds[step] = -1.0
        fx, fy = wall_force(
            *(px[step], py[step], radius, factor), *(k, walls, reach, most)
        )
        back = max(back, -(fx * ex + fy * ey))
    return back
