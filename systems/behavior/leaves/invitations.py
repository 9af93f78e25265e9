"""What people do whom another one has invited to a circle or a walk."""

import math

from hunav_drake.systems.behavior.leaves.pacing import face, settle
from hunav_drake.systems.behavior.nodes.social import (
    AT_POINT,
    look_at,
    number_of,
    own_signal,
    show_activity,
    signal_of,
)
from hunav_drake.systems.behavior.nodes.tick import human_at
from hunav_drake.systems.common.kernels import jit_inline, jit_part
from hunav_drake.systems.common.layout import MAX_PARTNERS, Activity, Signal

# An offer is noticed up to this distance, in meters.
_READABLE = 20.0

# The radius of a circle of two, and how much each further person adds to it,
# less that of one, in meters.
_RADIUS, _MORE = 0.5, 0.2

CLOSED = 1.0
TALK, WALK = float(Activity.CONVERSATION), float(Activity.GROUP_WALK)
_ACTIVITY, _SINCE = int(Signal.ACTIVITY), int(Signal.SINCE)
_HOST, _OPEN, _SLOT = int(Signal.HOST), int(Signal.OPEN), int(Signal.SLOT)
_X, _Y = int(Signal.CENTER_X), int(Signal.CENTER_Y)
_ANGLE, _PARTNERS = int(Signal.ANGLE), int(Signal.PARTNER_1)


@jit_inline
def circle_slot(x, y, angle, slot, count):
    """Returns the place of one of several people in a circle around (x, y)."""
    radius = _RADIUS + _MORE * (count - 1)
    bearing = angle + 2 * math.pi * slot / count
    return x + radius * math.cos(bearing), y + radius * math.sin(bearing)


@jit_part
def host_of(tick):
    """Returns the row of the host whose offer binds the person, or -1.

    Of several, the offer that began first counts.
    """
    if tick.signals == 0 or tick.ignores != 0:
        return -1
    found, since, number = -1, math.inf, 0
    for i in range(tick.num_humans):
        signal = signal_of(tick, i)
        if signal[_OPEN] != CLOSED or _place_in(signal, tick.index) < 0:
            continue
        it = human_at(tick, i)
        if math.hypot(it.x - tick.x, it.y - tick.y) > _READABLE:
            continue
        begun = signal[_SINCE]
        if begun < since or (begun == since and number_of(tick, i) < number):
            found, since, number = i, begun, number_of(tick, i)
    return found


@jit_inline
def _place_in(signal, row):
    """Returns the place of a person among the partners of an offer, or -1."""
    for i in range(MAX_PARTNERS):
        if signal[_PARTNERS + i] == row:
            return i
    return -1


@jit_part
def obey(tick, host):
    """Goes to the person's place in a circle, or walks with the group."""
    signal = signal_of(tick, host)
    x, y = signal[_X], signal[_Y]
    if signal[_ACTIVITY] == WALK:
        tick.goal_x = x
        tick.goal_y = y
        tick.has_goal = 1.0
        tick.group_id = number_of(tick, host)
        show_activity(tick, WALK, -1, -1)
        own_signal(tick)[_HOST] = host
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
    own_signal(tick)[_HOST] = host
    look_at(tick, AT_POINT, x, y)
