"""Using places: waiting in a queue, sitting, looking at a screen, ...

People agree without a manager: each shows what it claims, and of two claims the
earlier one holds, or that of the lower number.
"""

import math
from typing import Annotated

import numpy as np

from hunav_drake.systems.behavior.leaves.gaze import bearing_error
from hunav_drake.systems.behavior.leaves.pacing import (
    SETTLED,
    STANDING,
    PortDistance,
    face,
    settle,
    speed_of,
    stand,
    walk_to,
    wrapped,
)
from hunav_drake.systems.behavior.leaves.reactions import TURN_RATE
from hunav_drake.systems.behavior.leaves.social_ports import PlaceName, Seconds
from hunav_drake.systems.behavior.leaves.walking import IGNORED, ROLES, Role
from hunav_drake.systems.behavior.nodes.control_flow import steps_reach
from hunav_drake.systems.behavior.nodes.registry import register_action
from hunav_drake.systems.behavior.nodes.social import (
    AT_POINT,
    AT_START,
    body_at,
    is_before,
    look_at,
    num_bodies,
    number_of,
    own_signal,
    place_of,
    pose_of,
    show_activity,
    signal_of,
    slot_at,
    social_memory,
    ticks_of,
)
from hunav_drake.systems.behavior.nodes.status import (
    FAILURE,
    RUNNING,
    SUCCESS,
    NodeStatus,
)
from hunav_drake.systems.behavior.nodes.tick import Tick, place_at
from hunav_drake.systems.behavior.nodes.tick_context import SEAT
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit, jit_part
from hunav_drake.systems.common.layout import Activity, Posture, Signal
from hunav_drake.systems.common.schema import within
from hunav_drake.systems.people.places import PLACE_TYPES, PlaceType

_QUEUE, _USE = float(Activity.QUEUE), float(Activity.USE)
_SIT, _WATCH = float(Activity.SIT), float(Activity.WATCH)
_SEATED, _LYING = float(Posture.SEATED), float(Posture.LYING)
_ACTIVITY, _SINCE = int(Signal.ACTIVITY), int(Signal.SINCE)
_PLACE, _SLOT = int(Signal.PLACE), int(Signal.SLOT)
_GESTURE, _POSTURE = int(Signal.GESTURE), int(Signal.POSTURE)
_SEAT, _SCREEN, _WORKPLACE, _BED = (
    PLACE_TYPES.index(it) for it in ("seat", "screen", "workplace", "bed")
)

# Somebody is on a seat within this distance, in meters.
_UPON = 0.02

# Somebody faces a direction within this angle, in radians.
_FACING = 0.05

# Somebody waits who comes nearer to a place more slowly than this, in m/s.
_NEARER = 0.02

# The first part of a way onto a seat, which must be free, and the last part,
# for which nobody waits, in meters (see `crowd.placed`).
_FIRST, _LAST = 0.05, 0.35

# Without a free slot, people wait this far from the nearest one, more or less
# by the second distance, in meters, and step back at this speed, in m/s.
_OFF, _ROOM, _SLOWLY = 1.5, 0.3, 0.6


@jit_part
def _slot_row(tick, place, slot):
    """Returns the row of a slot of a place."""
    return np.int64(place_at(tick, place)[8]) + np.int64(slot)


@jit_part
def _away(tick, x, y):
    """Returns the distance of a point in W, in meters."""
    return math.hypot(x - tick.x, y - tick.y)


@jit_part
def _turn(tick, yaw):
    """Turns to a direction; returns whether the person faces it."""
    tick.turn_rate = TURN_RATE
    tick.yaw_target = yaw
    return abs(wrapped(yaw - tick.yaw)) <= _FACING


@jit_part
def _rank(tick, place, since):
    """Returns how many people are before the person in a queue."""
    rank, number = 0, number_of(tick, tick.index)
    for i in range(num_bodies(tick)):
        signal = signal_of(tick, i)
        is_in = signal[_ACTIVITY] == _QUEUE and signal[_PLACE] == place
        rank += i != tick.index and is_in and is_before(tick, i, since, number)
    return rank


@register_action(
    "Queue",
    memory={"ticks served": 0.0, "ticks": 0.0},
    ignored=IGNORED,
    social=True,
)
@jit
def queue(
    tick: Tick,
    own: Array,
    place: PlaceName,
    patience: Seconds = 1e9,
    join_distance: PortDistance = 2.0,
    robot: Role = "pedestrian",
) -> NodeStatus:
    """Waits in the queue at a place, and is served.

    The person walks to the end of the queue, and joins it within
    `join_distance`. The first one is served for the time of the place. The
    action fails after `patience`, unless the person is served then.
    """
    row = place_of(tick, place)
    if row < 0:
        own[0] = 0.0
        own[1] = 0.0
        return FAILURE
    tick.robot_role = ROLES[int(robot)]
    x, y, yaw = pose_of(tick, row)
    if _posture(np.int64(place_at(tick, row)[7])) != 0:
        # (Who queues at a seat waits beside it.)
        seat = slot_at(tick, _slot_row(tick, row, 0))
        x, y = seat[3], seat[4]
        if math.hypot(seat[0] - x, seat[1] - y) > _UPON:
            yaw = math.atan2(seat[1] - y, seat[0] - x)
    spacing, seconds = place_at(tick, row)[5], place_at(tick, row)[6]
    before = signal_of(tick, tick.index)
    begins = own[1] == 0
    is_shown = before[_ACTIVITY] == _QUEUE and before[_PLACE] == row
    is_in = is_shown and not begins
    rank = _rank(tick, row, before[_SINCE] if is_in else math.inf)
    x -= rank * spacing * math.cos(yaw)
    y -= rank * spacing * math.sin(yaw)
    own[1] += 1
    if own[0] == 0 and steps_reach(own[1], tick.time_step, patience):
        own[1] = 0.0
        return FAILURE
    join_distance = max(join_distance, SETTLED)
    if not is_in and math.hypot(x - tick.x, y - tick.y) > join_distance:
        walk_to(tick, x, y, tick.max_speed)
        return RUNNING
    show_activity(tick, _QUEUE, row, -1, not is_in)
    if not settle(tick, x, y):
        return RUNNING
    if _turn(tick, yaw) and rank == 0 and is_in:
        own[0] += 1
        if steps_reach(own[0], tick.time_step, seconds):
            own[0] = 0.0
            own[1] = 0.0
            return SUCCESS
    return RUNNING


@jit_part
def _activity(tick, place):
    """Returns the activity of those who use a place."""
    kind = np.int64(place_at(tick, place)[7])
    if kind in (_SEAT, _BED):
        return _SIT
    return _WATCH if kind == _SCREEN else _USE


@jit_part
def _posture(kind):
    """Returns the posture of those who use a type of place."""
    if kind == _BED:
        return _LYING
    return _SEATED if kind in (_SEAT, _WORKPLACE) else 0.0


@jit_part
def _is_claimed(tick, place, slot, since):
    """Returns whether another one's claim of a slot is before the own one."""
    number = number_of(tick, tick.index)
    for i in range(num_bodies(tick)):
        signal = signal_of(tick, i)
        if i == tick.index or signal[_PLACE] != place or signal[_SLOT] != slot:
            continue
        if is_before(tick, i, since, number):
            return True
    return False


@jit_part
def _is_meant(tick, row, place, kind):
    """Returns whether a place is the one meant, or, without one, of a type."""
    return row == place or (place < 0 and place_at(tick, row)[7] == kind)


@jit_part
def _choose(tick, own, place, kind):
    """Chooses the nearest free slot of a place, or of all of a type."""
    nearest = math.inf
    own[2] = 0.0
    own[4] = 0.0
    for p in range(tick.num_places):
        if not _is_meant(tick, p, place, kind):
            continue
        for s in range(np.int64(place_at(tick, p)[9])):
            it = slot_at(tick, _slot_row(tick, p, s))
            away = min(_away(tick, it[0], it[1]), _away(tick, it[3], it[4]))
            if away < nearest and not _is_claimed(tick, p, s, math.inf):
                nearest = away
                own[2] = p + 1.0
                own[3] = s


@jit_part
def _holds(tick, own):
    """Returns whether the person has a slot, and nobody else has it before."""
    place, slot = np.int64(own[2]) - 1, own[3]
    if not 0 <= place < tick.num_places:
        return False
    if not 0 <= slot < place_at(tick, place)[9]:
        return False
    before = signal_of(tick, tick.index)
    is_shown = before[_PLACE] == place and before[_SLOT] == slot
    since = before[_SINCE] if is_shown else math.inf
    return not _is_claimed(tick, place, slot, since)


@register_action(
    "UsePlace",
    memory={
        "ticks used": 0.0,
        "ticks": 0.0,
        "place": 0.0,
        "slot": 0.0,
        "nearest": 0.0,
    },
    ignored=IGNORED,
    social=True,
)
@jit
def use_place(
    tick: Tick,
    own: Array,
    place: PlaceName = "",
    kind: PlaceType = "seat",
    seconds: Seconds = 0.0,
    patience: Seconds = 60.0,
    gesture: Annotated[int, within(0, 5)] = 0,
    robot: Role = "pedestrian",
) -> NodeStatus:
    """Uses a place: sits on a seat, looks at a screen, takes from a shelf, ...

    The person takes the nearest free slot of the place, or, without one, of
    all places of a type, and faces as it does; it sits down on a seat and lies
    down in a bed. It stays for `seconds`, by default the time of the place.
    Without a free slot, or while it comes no nearer, as when somebody stands in
    the way or there is none, it waits; the action fails after `patience` of
    that, and at once where there is no such place.
    """
    status: NodeStatus
    row = place_of(tick, place)
    if row < 0 and float(place) != 0:
        own[0] = 0.0
        own[1] = 0.0
        own[2] = 0.0
        return FAILURE
    tick.robot_role = ROLES[int(robot)]
    if not _holds(tick, own):
        own[0] = 0.0
        _choose(tick, own, row, int(kind))
    if own[2] == 0:
        status = _wait(tick, own, row, int(kind), patience)
        return status
    at, slot = np.int64(own[2]) - 1, np.int64(own[3])
    row = _slot_row(tick, at, slot)
    x, y, yaw, ax, ay, _, _ = slot_at(tick, row)
    show_activity(tick, _activity(tick, at), at, slot)
    kind_there = np.int64(place_at(tick, at)[7])
    posture = _posture(kind_there)
    signal = own_signal(tick)
    memory = social_memory(tick)
    away = _away(tick, x, y)
    is_there = ticks_of(tick) == 0 and away < AT_START
    if posture != 0 and (memory[SEAT] == row + 1 or is_there):
        memory[SEAT] = row + 1.0
        signal[_POSTURE] = posture
        if away > _UPON:
            status = _wait_for(tick, own, away, patience)
            return status
    else:
        sx, sy, _ = pose_of(tick, at)
        if not settle(tick, ax, ay):
            status = _wait_for(tick, own, _away(tick, ax, ay), patience)
            return status
        if kind_there == _SCREEN:
            look_at(tick, AT_POINT, sx, sy)
        if not _turn(tick, yaw):
            return RUNNING
        if posture != 0:
            if _is_barred(tick, x, y):
                status = _wait_for(tick, own, away, patience)
                return status
            own[4] = 0.0
            memory[SEAT] = row + 1.0
            signal[_POSTURE] = posture
            return RUNNING
    signal[_GESTURE] = gesture
    own[0] += 1
    own[1] = 0.0
    own[4] = 0.0
    if seconds == 0:
        seconds = place_at(tick, at)[6]
    if steps_reach(own[0], tick.time_step, seconds):
        _let_go(own, signal)
        return SUCCESS
    return RUNNING


@jit_part
def _let_go(own, signal):
    """Makes the place that the person uses a free one."""
    own[0] = 0.0
    own[2] = 0.0
    own[4] = 0.0
    signal[_PLACE] = -1.0
    signal[_SLOT] = -1.0


@jit_part
def _is_barred(tick, x, y):
    """Returns whether somebody stands on the way onto a seat."""
    left = _away(tick, x, y)
    if left <= _LAST:
        return False
    dx, dy = _FIRST * (x - tick.x) / left, _FIRST * (y - tick.y) / left
    for i in range(num_bodies(tick)):
        if i == tick.index:
            continue
        body = body_at(tick, i)
        px, py = body.x - tick.x, body.y - tick.y
        gap = math.hypot(px - dx, py - dy)
        is_nearer = gap < math.hypot(px, py)
        touches = gap < tick.body_radius + body.radius
        if is_nearer and touches and speed_of(body) < STANDING:
            return True
    return False


@jit_part
def _wait_for(tick, own, away, patience):
    """Counts the time in which a person comes no nearer; returns the status.

    On the way that is the time in which it stands; near the place, all.
    """
    status = RUNNING
    if own[4] == 0 or away < own[4] - _NEARER * tick.time_step:
        own[4] = max(away, 1e-9)
    elif away < _OFF + _ROOM or speed_of(tick) < STANDING:
        own[1] += 1
        if steps_reach(own[1], tick.time_step, patience):
            own[1] = 0.0
            _let_go(own, own_signal(tick))
            status = FAILURE
    return status


@jit_part
def _wait(tick, own, place, kind, patience):
    """Waits near a place, or off all of a type; returns the status."""
    nearest, sx, sy = math.inf, 0.0, 0.0
    for p in range(tick.num_places):
        if not _is_meant(tick, p, place, kind):
            continue
        for k in range(np.int64(place_at(tick, p)[9])):
            it = slot_at(tick, _slot_row(tick, p, k))
            away = _away(tick, it[3], it[4])
            if away < nearest:
                nearest, sx, sy = away, it[3], it[4]
    own[1] += 1
    is_over = steps_reach(own[1], tick.time_step, patience)
    if is_over or nearest == math.inf:
        own[1] = 0.0
        return FAILURE
    if 0 < nearest < _OFF - _ROOM:
        # (Whoever has the slot needs the room.)
        part = _OFF / nearest
        x, y = sx + part * (tick.x - sx), sy + part * (tick.y - sy)
        walk_to(tick, x, y, min(tick.max_speed, _SLOWLY))
    elif place >= 0 and nearest > _OFF + _ROOM:
        walk_to(tick, sx, sy, min(tick.max_speed, nearest - _OFF + _ROOM))
    else:
        stand(tick)
        if place >= 0 and bearing_error(tick, sx, sy) > _FACING:
            face(tick, sx, sy, TURN_RATE)
    return RUNNING
