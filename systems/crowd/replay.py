"""The steps of recorded people, compiled by numba.

Each follows a cubic spline through the recorded positions; its heading is
linear between the steps of a trial.
"""

import math

from numba import float64
import numpy as np

from hunav_drake.systems.common.kernels import MATRIX, REAL, VECTOR, jit, jit_as
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    OMEGA,
    OUTSIDE,
    REACTIVE,
    REPLAY_SIZE,
    REPLAYED,
    STATE_SIZE,
    VX,
    VY,
    YAW,
    Command,
    Hold,
    X,
    Y,
)
from hunav_drake.systems.people.tracks import WALKING

# A row of `tracks`: 1 for a person whose next state is given, and that state.
MASK = 0
TRACK_SIZE = 1 + OMEGA + 1

# The memory of a person: whether it walks by the motion model; how late it is
# in its recording, in seconds; while it walks, where it is in the recording, in
# seconds; and since it is back, the place, velocity and heading relative to the
# recording, the time since then, and that until it is on its path, in seconds.
REACTS, CLOCK, PHASE, DX, DY, DVX, DVY, DYAW, SINCE, LASTS = range(10)
MEMORY_SIZE = 10

# The columns of `layout.REPLAY_SIZE`.
_MODE, _AT_TIME, _AT_PHASE = range(3)

# The columns of a roster: the first of its knots and their number, the times of
# the first and the last row, the first of its headings, their number and the
# number of the step of the first, the kind, and `on` and `off`.
FIRST, COUNT, START, END, YAWS, NUM_YAWS, STEP, KIND, ON, OFF = range(10)
ROSTER_SIZE = 10
KINDS = ("blind", "hand_over", "reactive")
_BLIND, _HAND_OVER, _REACTIVE = range(3)

# The time ahead at which a person who walks aims, and in which it looks for the
# nearest place of its recording, in seconds; the steps of that, and how often
# the last one is halved.
_AHEAD = 1.5
_WINDOW, _SAMPLES, _HALVINGS = 1.0, 10, 25

# The speeds between which it walks, in m/s, the distance at which it has
# arrived where it stood, in meters, and the least speed by which it is led on
# beyond the end of its recording, in m/s.
_SLOWEST, _FASTEST = 0.05, 1.8
_ARRIVED = 0.1
_LEAVING = 0.5

# A person is back on its path after the time, in seconds; after a longer one,
# where place or velocity alone would take a larger acceleration, in m/s^2.
_DECAY = 0.8
_EASY = 1.5

# Times that differ by less are the same, in seconds.
_SAME = 1e-9

_PLACED = float(Hold.PLACED)


@jit
def _place(row, time, knots, curves):
    """Returns x, y, vx and vy of a recorded person at a time, in m and m/s."""
    at = min(max(time, row[START]), row[END])
    low = int(row[FIRST])
    high = low + max(int(row[COUNT]) - 1, 1)
    while high - low > 1:
        middle = (low + high) // 2
        if knots[middle] <= at:
            low = middle
        else:
            high = middle
    u = at - knots[low]
    c = curves[low]
    return (
        ((c[0] * u + c[1]) * u + c[2]) * u + c[3],
        ((c[4] * u + c[5]) * u + c[6]) * u + c[7],
        (3.0 * c[0] * u + 2.0 * c[1]) * u + c[2],
        (3.0 * c[4] * u + 2.0 * c[5]) * u + c[6],
    )


@jit
def _heading(row, time, time_step, yaws):
    """Returns the heading of a recorded person at a time, not wrapped."""
    first = int(row[YAWS])
    last = int(row[NUM_YAWS]) - 1
    at = min(max(time / time_step - row[STEP], 0.0), float(last))
    k = min(int(at), max(last - 1, 0))
    share = at - k
    return (1.0 - share) * yaws[first + k] + share * yaws[
        first + min(k + 1, last)
    ]


@jit
def _wrapped(angle):
    return math.atan2(math.sin(angle), math.cos(angle))


@jit
def _away(row, x, y, time, knots, curves):
    """Returns the distance of a point from the recording at a time."""
    px, py, _, _ = _place(row, time, knots, curves)
    return math.hypot(px - x, py - y)


@jit
def _nearest(row, x, y, phase, time_step, knots, curves):
    """Returns the time of the recording that is nearest to a person.

    It is searched from the last one on, and not beyond where the person stood;
    there, time passes.
    """
    _, _, vx, vy = _place(row, phase, knots, curves)
    if math.hypot(vx, vy) < WALKING:
        return min(phase + time_step, row[END])
    width = min(_WINDOW, row[END] - phase) / _SAMPLES
    best = 0
    least = math.inf
    for k in range(_SAMPLES + 1):
        px, py, vx, vy = _place(row, phase + k * width, knots, curves)
        away = math.hypot(px - x, py - y)
        if away < least:
            best, least = k, away
        if math.hypot(vx, vy) < WALKING:
            break
    low = phase + max(best - 1, 0) * width
    high = phase + min(best + 1, _SAMPLES) * width
    for _ in range(_HALVINGS):
        middle = (low + high) / 2.0
        px, py, vx, vy = _place(row, middle, knots, curves)
        if (px - x) * vx + (py - y) * vy < 0.0:
            low = middle
        else:
            high = middle
    return min(low, row[END])


@jit
def _reach(person, robots):
    """Returns the distance of the nearest robot's center, in meters."""
    reach = math.inf
    for k in range(len(robots)):
        dx = robots[k, X] - person[X]
        dy = robots[k, Y] - person[Y]
        reach = min(reach, math.hypot(dx, dy))
    return reach


@jit
def _change_mode(row, own, person, robots, now, time_step, tables):
    """Changes the memory of a person to that from now on."""
    knots, curves, yaws = tables
    here = person[X] != OUTSIDE
    if own[REACTS] == 0.0:
        phase = now - own[CLOCK]
        if not here or row[KIND] == _BLIND or phase < row[START] - _SAME:
            return
        if phase >= row[END] - _SAME:
            # It leaves.
            return
        if row[KIND] == _REACTIVE or _reach(person, robots) < row[ON]:
            own[:] = 0.0
            own[REACTS] = 1.0
            own[PHASE] = min(max(phase, row[START]), row[END])
        return
    phase = row[END]
    if here:
        phase = _nearest(
            row, person[X], person[Y], own[PHASE], time_step, knots, curves
        )
    own[PHASE] = phase
    if phase >= row[END] - _SAME:
        # It leaves.
        own[:] = 0.0
        own[CLOCK] = now - row[END]
    elif row[KIND] == _HAND_OVER and _reach(person, robots) > row[OFF]:
        x, y, vx, vy = _place(row, phase, knots, curves)
        own[REACTS] = own[PHASE] = 0.0
        own[CLOCK] = now - phase
        own[DX] = person[X] - x
        own[DY] = person[Y] - y
        own[DVX] = person[VX] - vx
        own[DVY] = person[VY] - vy
        own[DYAW] = _wrapped(
            person[YAW] - _heading(row, phase, time_step, yaws)
        )
        own[SINCE] = 0.0
        own[LASTS] = max(
            _DECAY,
            math.sqrt(6.0 / _EASY * math.hypot(own[DX], own[DY])),
            4.0 / _EASY * math.hypot(own[DVX], own[DVY]),
        )


@jit
def _follow(row, own, next_time, time_step, track, tables):
    """Writes the row of `tracks` of a person who follows its recording."""
    knots, curves, yaws = tables
    track[MASK] = 1.0
    at = next_time - own[CLOCK]
    if at < row[START] - _SAME or at > row[END] + _SAME:
        track[1 + X] = track[1 + Y] = OUTSIDE
        return
    x, y, vx, vy = _place(row, at, knots, curves)
    yaw = _heading(row, at, time_step, yaws)
    omega = (yaw - _heading(row, at - time_step, time_step, yaws)) / time_step
    if own[LASTS] > 0.0:
        own[SINCE] += time_step
        if own[SINCE] >= own[LASTS]:
            own[DX:] = 0.0
        else:
            # The cubic from the offset and its velocity to rest at none.
            lasts = own[LASTS]
            u = own[SINCE] / lasts
            stays = (1.0 + 2.0 * u) * (1.0 - u) ** 2
            drifts = lasts * u * (1.0 - u) ** 2
            x += stays * own[DX] + drifts * own[DVX]
            y += stays * own[DY] + drifts * own[DVY]
            yaw += stays * own[DYAW]
            fades = -6.0 * u * (1.0 - u) / lasts
            slows = (1.0 - u) * (1.0 - 3.0 * u)
            vx += fades * own[DX] + slows * own[DVX]
            vy += fades * own[DY] + slows * own[DVY]
            omega += fades * own[DYAW]
    track[1 + X] = x
    track[1 + Y] = y
    track[1 + YAW] = _wrapped(yaw)
    track[1 + VX] = vx
    track[1 + VY] = vy
    track[1 + OMEGA] = omega


@jit
def _lead(row, own, person, command, knots, curves):
    """Changes the command of a person who walks by the motion model.

    Whoever sits down, sits or stands up does so first.
    """
    if command[Command.HOLD] == _PLACED:
        return
    _, _, vx, vy = _place(row, own[PHASE], knots, curves)
    speed = min(max(math.hypot(vx, vy), _SLOWEST), _FASTEST)
    ahead = own[PHASE] + _AHEAD
    x, y, vx, vy = _place(row, ahead, knots, curves)
    last = math.hypot(vx, vy)
    if ahead > row[END] and last > WALKING:
        further = (ahead - row[END]) * max(last, _LEAVING) / last
        x += further * vx
        y += further * vy
    command[Command.GOAL_X] = x
    command[Command.GOAL_Y] = y
    command[Command.GOAL_RADIUS] = _ARRIVED
    command[Command.HAS_GOAL] = 1.0
    command[Command.DESIRED_SPEED] = speed
    command[Command.MAX_SPEED] = max(speed, math.hypot(person[VX], person[VY]))


@jit_as(
    float64[::1],
    *(REAL, REAL, VECTOR, VECTOR, VECTOR, VECTOR),
    *(MATRIX, VECTOR, MATRIX, VECTOR),
)
def replay_step(
    now, time_step, memory, humans, robots, commands, roster, knots, curves,
    yaws,
):  # fmt: skip
    """Returns the memory at the next step, commands and rows of `tracks`.

    They are joined to one vector. The arguments are the present time, the time
    step, in seconds, the memory, the rows of people, robots and commands, as
    vectors, and `replay_tables.Tables`.
    """
    n = len(roster)
    result = np.zeros(n * (MEMORY_SIZE + COMMAND_SIZE + TRACK_SIZE))
    first, second = n * MEMORY_SIZE, n * (MEMORY_SIZE + COMMAND_SIZE)
    result[:first] = memory
    result[first:second] = commands
    owns = result[:first].reshape(n, MEMORY_SIZE)
    orders = result[first:second].reshape(n, COMMAND_SIZE)
    tracks = result[second:].reshape(n, TRACK_SIZE)
    people = humans.reshape(n, STATE_SIZE)
    others = robots.reshape(len(robots) // STATE_SIZE, STATE_SIZE)
    tables = knots, curves, yaws
    for i in range(n):
        row = roster[i]
        if row[COUNT] == 0.0:
            continue
        own = owns[i]
        _change_mode(row, own, people[i], others, now, time_step, tables)
        if own[REACTS] == 0.0:
            _follow(row, own, now + time_step, time_step, tracks[i], tables)
        else:
            _lead(row, own, people[i], orders[i], knots, curves)
    return result


@jit_as(
    float64[::1], *(REAL, REAL, VECTOR, VECTOR, MATRIX, VECTOR, MATRIX, VECTOR)
)
def replay_rows(now, time_step, memory, humans, roster, knots, curves, yaws):
    """Returns the rows of `replay`, as a vector; arguments as above."""
    n = len(roster)
    result = np.zeros((n, REPLAY_SIZE))
    people = humans.reshape(n, STATE_SIZE)
    owns = memory.reshape(n, MEMORY_SIZE)
    for i in range(n):
        row, own, person = roster[i], owns[i], people[i]
        result[i, _AT_TIME] = result[i, _AT_PHASE] = -1.0
        if row[COUNT] == 0.0 or person[X] == OUTSIDE:
            continue
        x, y = person[X], person[Y]
        phase = now - own[CLOCK]
        result[i, _MODE] = REPLAYED
        if own[REACTS] != 0.0:
            result[i, _MODE] = REACTIVE
            phase = _nearest(row, x, y, own[PHASE], time_step, knots, curves)
        if row[START] - _SAME <= now <= row[END] + _SAME:
            result[i, _AT_TIME] = _away(row, x, y, now, knots, curves)
        result[i, _AT_PHASE] = _away(row, x, y, phase, knots, curves)
    return result.ravel()
