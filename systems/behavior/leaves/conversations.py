"""Talking in open circles, which anybody may join and leave: Converse, ...

Nobody leads a circle. Its members are the host and all who show that they are
with it; each finds its place from where they all are, so that all agree. If the
host leaves, the member who has been there longest is the next one.
"""

import math
from typing import Annotated, Literal

import numpy as np

from hunav_drake.systems.behavior.leaves.invitations import (
    CLOSED,
    READABLE,
    TALK,
)
from hunav_drake.systems.behavior.leaves.pacing import (
    SETTLED,
    PortDistance,
    face,
    settle,
)
from hunav_drake.systems.behavior.leaves.reactions import TURN_RATE
from hunav_drake.systems.behavior.leaves.social_ports import PlaceName, Seconds
from hunav_drake.systems.behavior.leaves.walking import IGNORED, Role, act
from hunav_drake.systems.behavior.nodes.control_flow import steps_reach
from hunav_drake.systems.behavior.nodes.registry import register_action
from hunav_drake.systems.behavior.nodes.social import (
    AT_POINT,
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
)
from hunav_drake.systems.behavior.nodes.status import (
    FAILURE,
    RUNNING,
    SUCCESS,
    NodeStatus,
)
from hunav_drake.systems.behavior.nodes.tick import Tick, cast_ray, sees
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit, jit_part
from hunav_drake.systems.common.layout import OUTSIDE, Signal
from hunav_drake.systems.common.schema import within

# The offer of a circle that anybody may join.
_TO_ALL = 2.0

# The radius of a circle of one, and how much each further person adds, in
# meters: as in Arena's humansim.
_RADIUS, _MORE = 0.7, 0.12

# A member is in place within this distance, in meters.
_NEAR = 0.2

# Whoever is alone joins a circle that began earlier and is this near, in
# meters.
_SAME = 3.0

_ACTIVITY, _SINCE = int(Signal.ACTIVITY), int(Signal.SINCE)
_HOST, _OPEN = int(Signal.HOST), int(Signal.OPEN)
_X, _Y = int(Signal.CENTER_X), int(Signal.CENTER_Y)
_PARTNER = int(Signal.PARTNER_1)

Members = Annotated[int, within(2, 1000)]

_TALKING = {
    "ticks of talk": 0.0,
    "ticks of waiting": 0.0,
    "host": 0.0,
    "x": 0.0,
    "y": 0.0,
}


@jit_part
def _is_host(tick, index):
    """Returns whether a body shows that it hosts an open circle.

    It is closed to others while it is full; then it names nobody.
    """
    signal = signal_of(tick, index)
    is_full = signal[_OPEN] == CLOSED and signal[_PARTNER] < 0
    hosts = signal[_ACTIVITY] == TALK and signal[_HOST] == index
    return (
        hosts
        and (signal[_OPEN] == _TO_ALL or is_full)
        and body_at(tick, index).x != OUTSIDE
    )


@jit_part
def _is_member(tick, index, host):
    """Returns whether a body is in the circle of a host, perhaps of itself."""
    if index == tick.index:
        return True
    if index == host:
        return _is_host(tick, index)
    signal = signal_of(tick, index)
    is_in = signal[_ACTIVITY] == TALK and signal[_HOST] == host
    return is_in and body_at(tick, index).x != OUTSIDE


@jit_part
def _count(tick, host):
    """Returns how many are in a circle, with the person itself."""
    count = 0
    for i in range(num_bodies(tick)):
        count += _is_member(tick, i, host)
    return count


@jit_part
def _is_before(tick, one, other):
    """Returns whether a body's activity began before that of another."""
    since = signal_of(tick, other)[_SINCE]
    return is_before(tick, one, since, number_of(tick, other))


@jit_part
def _find_circle(tick, x, y, distance, room):
    """Returns the host of the nearest open circle to a point, or -1.

    It is in sight, and has fewer than `room` members.
    """
    found, nearest = -1, min(distance, READABLE)
    for i in range(num_bodies(tick)):
        if i == tick.index or not _is_host(tick, i):
            continue
        signal = signal_of(tick, i)
        cx, cy = signal[_X], signal[_Y]
        away = math.hypot(cx - x, cy - y)
        is_nearer = away < nearest or (
            away == nearest and (found < 0 or _is_before(tick, i, found))
        )
        is_open = signal[_OPEN] == _TO_ALL and _count(tick, i) <= room
        if is_nearer and is_open and sees(tick, cx, cy):
            found, nearest = i, away
    return found


@jit_part
def _next_host(tick, host):
    """Returns who hosts a circle whose host has left."""
    found = tick.index
    for i in range(tick.num_humans):
        if i in (host, tick.index) or not _is_member(tick, i, host):
            continue
        if _is_before(tick, i, found):
            found = i
    return found


@jit_part
def _places(tick, host, x, y):
    """Returns the own place in a circle, and how many are in theirs.

    The place is the bearing from the middle and the radius. In the order of
    their bearings, the members have places with equal angles between them, as
    near as possible to where they are.
    """
    rows = np.empty(num_bodies(tick), np.int64)
    bearings = np.empty(num_bodies(tick))
    count = 0
    for i in range(num_bodies(tick)):
        if not _is_member(tick, i, host):
            continue
        it = body_at(tick, i)
        bearing = math.atan2(it.y - y, it.x - x)
        at = count
        while at > 0 and (
            bearings[at - 1] > bearing
            or (
                bearings[at - 1] == bearing
                and number_of(tick, rows[at - 1]) > number_of(tick, i)
            )
        ):
            bearings[at], rows[at] = bearings[at - 1], rows[at - 1]
            at -= 1
        bearings[at], rows[at] = bearing, i
        count += 1
    s, c = 0.0, 0.0
    for k in range(count):
        s += math.sin(bearings[k] - 2 * math.pi * k / count)
        c += math.cos(bearings[k] - 2 * math.pi * k / count)
    first, radius = math.atan2(s, c), _RADIUS + _MORE * (count - 1)
    own, settled = 0.0, 0
    for k in range(count):
        bearing = first + 2 * math.pi * k / count
        it = body_at(tick, rows[k])
        dx = x + radius * math.cos(bearing) - it.x
        dy = y + radius * math.sin(bearing) - it.y
        settled += math.hypot(dx, dy) <= _NEAR
        if rows[k] == tick.index:
            own = bearing
    return own, radius, settled


@jit_part
def _is_too_many(tick, host, count, room):
    """Returns whether the person came last to a circle that is too large."""
    if count <= room or signal_of(tick, tick.index)[_HOST] != host:
        return False
    for i in range(num_bodies(tick)):
        is_other = i != tick.index and _is_member(tick, i, host)
        if is_other and _is_before(tick, tick.index, i):
            return False
    return True


@jit_part
def _talk(tick, own, seconds, room, patience, waits, ends):
    """Takes part in a circle; returns the status.

    A person who `waits` stays until others come; the circle `ends` with its
    time, if it is the host then.
    """
    host = np.int64(own[2]) - 1
    # (The memory may be of a trial with more people.)
    if not 0 <= host < num_bodies(tick):
        host = tick.index
    if host != tick.index:
        shown = signal_of(tick, host)
        if _is_host(tick, host):
            own[3] = shown[_X]
            own[4] = shown[_Y]
        elif shown[_HOST] == host and shown[_OPEN] == 0:
            # (It has ended the circle.)
            return _leave(own)
    x, y = own[3], own[4]
    count = _count(tick, host)
    is_over = count == 1 and (own[0] > 0 or not waits)
    if is_over or _is_too_many(tick, host, count, room):
        return _leave(own)
    bearing, radius, settled = _places(tick, host, x, y)
    if host != tick.index and not _is_host(tick, host):
        host = _next_host(tick, host)
    elif count == 1:
        other = _find_circle(tick, x, y, _SAME, room)
        if other >= 0 and _is_before(tick, other, tick.index):
            host = other
    own[2] = host + 1.0
    show_activity(tick, TALK, -1, -1)
    signal = own_signal(tick)
    signal[_HOST] = host
    if host == tick.index:
        signal[_OPEN] = _TO_ALL if count < room else CLOSED
        signal[_X] = x
        signal[_Y] = y
    look_at(tick, AT_POINT, x, y)
    beside = abs(math.hypot(tick.x - x, tick.y - y) - radius)
    sx, sy = x + radius * math.cos(bearing), y + radius * math.sin(bearing)
    if settle(tick, sx, sy, _NEAR if beside <= SETTLED else SETTLED):
        face(tick, x, y, TURN_RATE)
    if settled < 2:
        own[1] += 1
        if not steps_reach(own[1], tick.time_step, patience):
            return RUNNING
    else:
        own[0] += 1
        own[1] = 0.0
        if not steps_reach(own[0], tick.time_step, seconds):
            return RUNNING
    signal[_OPEN] = 0.0
    if not (ends and host == tick.index):
        signal[_ACTIVITY] = 0.0
        signal[_HOST] = -1.0
    return _leave(own)


@jit_part
def _leave(own):
    """Returns the status at the end, which tells whether they have talked."""
    status = SUCCESS if own[0] > 0 else FAILURE
    own[0] = 0.0
    own[1] = 0.0
    own[2] = 0.0
    return status


@register_action("Converse", memory=_TALKING, ignored=IGNORED, social=True)
@jit
def converse(
    tick: Tick,
    own: Array,
    center: PlaceName = "",
    seconds: Seconds = 30.0,
    max_members: Members = 6,
    leave: Literal["own", "host"] = "own",
    patience: Seconds = 30.0,
    robot: Role = "pedestrian",
) -> NodeStatus:
    """Opens a circle to talk, around a place or just ahead.

    Its time counts while two or more are in their places; then the person
    leaves, and the others go on, unless they are to `leave` with the host. The
    action fails if nobody comes for `patience`, and where the person finds a
    full circle at the same place.
    """
    if own[2] == 0:
        reach = _RADIUS + _MORE
        c, s = math.cos(tick.yaw), math.sin(tick.yaw)
        x, y = tick.x + 2 * reach * c, tick.y + 2 * reach * s
        if cast_ray(tick, tick, x, y) <= 1:
            # (No room ahead.)
            reach = 0.0
        own[3] = tick.x + reach * c
        own[4] = tick.y + reach * s
        if float(center) != 0:
            place = place_of(tick, center)
            if place < 0:
                return FAILURE
            own[3], own[4], _ = pose_of(tick, place)
        own[2] = tick.index + 1.0
    act(tick, robot)
    status: NodeStatus = _talk(
        tick, own, seconds, max_members, patience, True, int(leave) == 1
    )
    return status


@register_action(
    "JoinConversation", memory=_TALKING, ignored=IGNORED, social=True
)
@jit
def join_conversation(
    tick: Tick,
    own: Array,
    distance: PortDistance = 5.0,
    seconds: Seconds = 20.0,
    max_members: Members = 6,
    patience: Seconds = 30.0,
    robot: Role = "pedestrian",
) -> NodeStatus:
    """Joins the nearest open circle in sight; fails if there is none.

    The time counts as for `Converse`; then the person leaves.
    """
    if own[2] == 0:
        host = _find_circle(tick, tick.x, tick.y, distance, max_members)
        if host < 0:
            return FAILURE
        own[2] = host + 1.0
    act(tick, robot)
    status: NodeStatus = _talk(
        tick, own, seconds, max_members, patience, False, False
    )
    return status
