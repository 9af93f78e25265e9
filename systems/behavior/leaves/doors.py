"""Giving way at doors where no two people fit beside each other."""

import math

from hunav_drake.systems.behavior.leaves.pacing import (
    PortDistance,
    face,
    settle,
)
from hunav_drake.systems.behavior.leaves.reactions import TURN_RATE
from hunav_drake.systems.behavior.leaves.social_ports import DoorName, Seconds
from hunav_drake.systems.behavior.leaves.spots import free_way
from hunav_drake.systems.behavior.leaves.walking import IGNORED, Role, act
from hunav_drake.systems.behavior.nodes.control_flow import steps_reach
from hunav_drake.systems.behavior.nodes.registry import register_action
from hunav_drake.systems.behavior.nodes.social import (
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
    NodeStatus,
)
from hunav_drake.systems.behavior.nodes.tick import (
    Tick,
    goal_of,
    has_goal,
    place_at,
)
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit, jit_part
from hunav_drake.systems.common.layout import Activity, Gesture, Signal

_GIVE_WAY, _YOU_FIRST = float(Activity.GIVE_WAY), float(Gesture.YOU_FIRST)
_ACTIVITY, _SINCE = int(Signal.ACTIVITY), int(Signal.SINCE)
_PLACE, _GESTURE = int(Signal.PLACE), int(Signal.GESTURE)

# Whoever is this near to the middle of a door is in it; whoever has come
# through has left it this far beyond the place of those who wait. In meters.
_IN_DOOR, _PAST = 0.9, 0.4

# Somebody faster than this comes or goes, in m/s.
_MOVING = 0.1

# Two fit through a door beside each other with this to spare; those who wait
# have this distance from each other; and they go to the other side of the door
# if it has so much more room. In meters.
_SPARE, _APART, _MORE_ROOM = 0.1, 0.9, 0.3


@jit_part
def _in_frame(x, y, pose, side):
    """Returns a vector in the frame of a door, whose x is that of one side."""
    c, s = side * math.cos(pose[2]), side * math.sin(pose[2])
    return x * c + y * s, y * c - x * s


@jit_part
def _waits(tick, index, door):
    """Returns whether a body shows that it gives way at a door."""
    signal = signal_of(tick, index)
    return signal[_ACTIVITY] == _GIVE_WAY and signal[_PLACE] == door


@jit_part
def _first(tick, door, pose, side, zone, past, before):
    """Returns who goes first through a door, or -1; perhaps a robot.

    Whoever did `before` still does until it has come through.
    """
    width = place_at(tick, door)[12]
    mine = math.hypot(tick.x - pose[0], tick.y - pose[1])
    for i in range(num_bodies(tick)):
        it = body_at(tick, i)
        along, beside = _in_frame(it.x - pose[0], it.y - pose[1], pose, side)
        away = math.hypot(along, beside)
        reach = 2 * (tick.radius + it.radius) + _SPARE
        if i == tick.index or away > max(zone, past) or width >= reach:
            continue
        is_nearer = away < mine or (
            away == mine and number_of(tick, i) < number_of(tick, tick.index)
        )
        going, _ = _in_frame(it.vx, it.vy, pose, side)
        closing = -(it.vx * (it.x - pose[0]) + it.vy * (it.y - pose[1]))
        comes = along < 0 and away <= zone and closing > _MOVING * away
        # (Those who go the same way are not in the way.)
        is_in = away <= _IN_DOOR and along <= it.radius and going > -_MOVING
        if is_in and (is_nearer or mine > _IN_DOOR):
            return i
        if comes and is_nearer and not _waits(tick, i, door):
            return i
        if i == before and along > 0 and away <= past and going > _MOVING:
            return i
    return -1


@register_action(
    "GiveWayAtDoor",
    memory={"ticks": 0.0, "first": 0.0},
    ignored=IGNORED,
    social=True,
)
@jit
def give_way_at_door(
    tick: Tick,
    own: Array,
    place: DoorName,
    zone: PortDistance = 3.0,
    wait_back: PortDistance = 1.3,
    wait_side: PortDistance = 0.9,
    patience: Seconds = 10.0,
    robot: Role = "pedestrian",
) -> NodeStatus:
    """Lets others pass who are in a narrow door, or come and are nearer to it.

    The person waits beside the way on its own side. The action fails if there
    is nobody to let pass, if the goal is on this side of the door, and after
    `patience`, until the door is free.
    """
    door = place_of(tick, place)
    if door < 0 or not has_goal(tick):
        own[0] = 0.0
        own[1] = 0.0
        return FAILURE
    pose = pose_of(tick, door)
    dx, dy = tick.x - pose[0], tick.y - pose[1]
    side = 1.0 if _in_frame(dx, dy, pose, 1.0)[0] >= 0 else -1.0
    beside = _in_frame(dx, dy, pose, side)[1]
    gx, gy = goal_of(tick)
    beyond = _in_frame(gx - pose[0], gy - pose[1], pose, side)[0] < 0
    is_near = math.hypot(dx, dy) <= zone or _waits(tick, tick.index, door)
    first = -1
    if beyond and is_near:
        past = wait_back + _PAST
        first = _first(tick, door, pose, side, zone, past, own[1] - 1)
    own[1] = first + 1.0
    if first < 0:
        own[0] = 0.0
        return FAILURE
    if steps_reach(own[0], tick.time_step, patience):
        return FAILURE
    own[0] += 1
    act(tick, robot)
    show_activity(tick, _GIVE_WAY, door, -1)
    signal = own_signal(tick)
    signal[_GESTURE] = _YOU_FIRST
    it = body_at(tick, first)
    look_at(tick, first, it.x, it.y)
    back = wait_back + _APART * _rank(tick, door, pose, side, signal[_SINCE])
    c, s = side * math.cos(pose[2]), side * math.sin(pose[2])
    back = free_way(tick, pose[0], pose[1], c, s, back, 0.0)
    x, y = pose[0] + back * c, pose[1] + back * s
    left = free_way(tick, x, y, -s, c, wait_side, 0.0)
    right = free_way(tick, x, y, s, -c, wait_side, 0.0)
    off = left
    if right > left + (_MORE_ROOM if beside >= 0 else -_MORE_ROOM):
        off = -right
    if settle(tick, x - off * s, y + off * c):
        face(tick, pose[0], pose[1], TURN_RATE)
    return RUNNING


@jit_part
def _rank(tick, door, pose, side, since):
    """Returns how many wait on this side of a door since before."""
    rank, number = 0, number_of(tick, tick.index)
    for i in range(tick.num_humans):
        it = body_at(tick, i)
        here = _in_frame(it.x - pose[0], it.y - pose[1], pose, side)[0] > 0
        is_other = i != tick.index and here and _waits(tick, i, door)
        rank += is_other and is_before(tick, i, since, number)
    return rank
