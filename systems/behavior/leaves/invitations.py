"""What people do whom another one has invited to a circle or a walk."""

import math

from hunav_drake.systems.behavior.leaves.pacing import face, settle, stand
from hunav_drake.systems.behavior.nodes.social import (
    AT_POINT,
    body_at,
    is_before,
    look_at,
    num_bodies,
    number_of,
    own_signal,
    show_activity,
    signal_of,
)
from hunav_drake.systems.common.kernels import jit_part
from hunav_drake.systems.common.layout import MAX_PARTNERS, Activity, Signal
from hunav_drake.systems.people.human_config import MAX_GROUP_ID

# An offer is noticed up to this distance, in meters.
READABLE = 20.0

# A group that walks stands where all are this near to its goal, in meters.
_GATHERED = 1.0

# The radius of a circle of two, and how much each further person adds to it,
# less that of one, in meters.
_RADIUS, _MORE = 0.5, 0.2

CLOSED = 1.0
TALK, WALK = float(Activity.CONVERSATION), float(Activity.GROUP_WALK)
_ACTIVITY, _SINCE = int(Signal.ACTIVITY), int(Signal.SINCE)
_HOST, _OPEN, _SLOT = int(Signal.HOST), int(Signal.OPEN), int(Signal.SLOT)
_X, _Y = int(Signal.CENTER_X), int(Signal.CENTER_Y)
_ANGLE, _PARTNERS = int(Signal.ANGLE), int(Signal.PARTNER_1)


@jit_part
def circle_slot(x, y, angle, slot, count):
    """Returns the place of one of several people in a circle around (x, y)."""
    radius = _RADIUS + _MORE * (count - 1)
    bearing = angle + 2 * math.pi * slot / count
    return x + radius * math.cos(bearing), y + radius * math.sin(bearing)


@jit_part
def host_of(tick):
    """Returns the row of whoever has made an offer that binds the person.

    It is -1 if there is none; of several, the offer that began first counts.
    Robots come after the people.
    """
    if tick.signals == 0 or tick.ignores != 0:
        return -1
    found, since, number = -1, math.inf, 0
    for i in range(num_bodies(tick)):
        signal = signal_of(tick, i)
        if signal[_OPEN] != CLOSED or _place_in(signal, tick.index) < 0:
            continue
        it = body_at(tick, i)
        if math.hypot(it.x - tick.x, it.y - tick.y) > READABLE:
            continue
        if is_before(tick, i, since, number):
            found, since, number = i, signal[_SINCE], number_of(tick, i)
    return found


@jit_part
def _place_in(signal, row):
    """Returns the place of a person among the partners of an offer, or -1."""
    for i in range(MAX_PARTNERS):
        if signal[_PARTNERS + i] == row:
            return i
    return -1


@jit_part
def group_of(host):
    """Returns the number of the group that walks with a host, by its row."""
    # (No group of a scenario has such a number.)
    return MAX_GROUP_ID + 1.0 + host


@jit_part
def walk_in_group(tick, host, x, y):
    """Walks to a point in W, with the group of a host.

    Where the host is there, those near it stand.
    """
    tick.group_id = group_of(host)
    it = body_at(tick, host)
    away = max(
        math.hypot(x - it.x, y - it.y), math.hypot(x - tick.x, y - tick.y)
    )
    if away <= _GATHERED:
        stand(tick)
        return
    tick.goal_x = x
    tick.goal_y = y
    tick.has_goal = 1.0


@jit_part
def obey(tick, host):
    """Goes to the person's place in a circle, or walks with the group."""
    signal = signal_of(tick, host)
    x, y = signal[_X], signal[_Y]
    own = own_signal(tick)
    if signal[_ACTIVITY] == WALK:
        walk_in_group(tick, host, x, y)
        show_activity(tick, WALK, -1, -1)
        own[_HOST] = host
        own[_SINCE] = signal[_SINCE]
        return
    slot = _place_in(signal, tick.index)
    if slot >= signal[_SLOT]:
        slot += 1
    count = 1
    for i in range(MAX_PARTNERS):
        count += signal[_PARTNERS + i] >= 0
    sx, sy = circle_slot(x, y, signal[_ANGLE], slot, count)
    if settle(tick, sx, sy):
        face(tick, x, y, math.pi)
    show_activity(tick, TALK, -1, slot)
    own[_HOST] = host
    own[_SINCE] = signal[_SINCE]
    look_at(tick, AT_POINT, x, y)
