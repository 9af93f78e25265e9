"""Talking in a circle and walking together: ConversationFormation, ...

A host offers a circle or a walk to people it names. Those who walk as usual
are bound to it meanwhile: see `bound`.
"""

import math

import numpy as np

from hunav_drake.systems.behavior.leaves.gaze import bearing_error
from hunav_drake.systems.behavior.leaves.invitations import (
    CLOSED,
    TALK,
    WALK,
    circle_slot,
    group_of,
)
from hunav_drake.systems.behavior.leaves.pacing import (
    face,
    run_for,
    settle,
    stand,
)
from hunav_drake.systems.behavior.leaves.reactions import TURN_RATE
from hunav_drake.systems.behavior.leaves.social_ports import (
    People,
    PlaceName,
    Seconds,
)
from hunav_drake.systems.behavior.leaves.walking import IGNORED, Role, act
from hunav_drake.systems.behavior.nodes.control_flow import steps_reach
from hunav_drake.systems.behavior.nodes.registry import register_action
from hunav_drake.systems.behavior.nodes.social import (
    AT_POINT,
    look_at,
    own_signal,
    people_in,
    place_of,
    pose_of,
    show_activity,
)
from hunav_drake.systems.behavior.nodes.status import (
    FAILURE,
    RUNNING,
    SUCCESS,
    NodeStatus,
)
from hunav_drake.systems.behavior.nodes.tick import (
    Tick,
    goal_of,
    has_goal,
    human_at,
)
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit, jit_part
from hunav_drake.systems.common.layout import MAX_PARTNERS, OUTSIDE, Signal

_HOST, _OPEN = int(Signal.HOST), int(Signal.OPEN)
_X, _Y = int(Signal.CENTER_X), int(Signal.CENTER_Y)
_ANGLE, _PARTNERS = int(Signal.ANGLE), int(Signal.PARTNER_1)

# All are in place within this distance and angle, in meters and radians.
_NEAR, _FACING = 0.2, 0.05

_CIRCLE = {
    "began": 0.0,
    "ticks to talk": 0.0,
    "ticks to wait": 0.0,
    "x": 0.0,
    "y": 0.0,
    "angle": 0.0,
    "slot": 0.0,
    **{f"partner {i}": -1.0 for i in range(1, MAX_PARTNERS + 1)},
}
_FIRST = 7


@register_action(
    "ConversationFormation",
    memory=_CIRCLE,
    ignored=(*IGNORED, "main_agent_id"),
    social=True,
)
@jit
def conversation_formation(
    tick: Tick,
    own: Array,
    non_main_agent_ids: People,
    goal_id: PlaceName = "",
    conversation_duration: Seconds = 10.0,
    patience: Seconds = 30.0,
    robot: Role = "pedestrian",
) -> NodeStatus:
    """Talks with up to six people, in a circle around a place.

    Without a place, the middle is that of these people when it begins. The
    time counts while all are in their places and face the middle; the action
    fails if they are not for `patience`.
    """
    if own[0] == 0:
        partners = people_in(tick, non_main_agent_ids)
        if not len(partners) or not _begin(tick, own, partners, goal_id):
            return FAILURE
    count = 1
    for i in range(MAX_PARTNERS):
        count += own[_FIRST + i] >= 0
    _offer(tick, own, count)
    act(tick, robot)
    x, y = own[3], own[4]
    sx, sy = circle_slot(x, y, own[5], own[6], count)
    there = settle(tick, sx, sy)
    look_at(tick, AT_POINT, x, y)
    if there:
        face(tick, x, y, TURN_RATE)
    if _is_ready(tick, own, count):
        own[1] += 1
        own[2] = 0.0
        if steps_reach(own[1], tick.time_step, conversation_duration):
            own[0] = 0.0
            return SUCCESS
        return RUNNING
    own[2] += 1
    if steps_reach(own[2], tick.time_step, patience):
        own[0] = 0.0
        return FAILURE
    return RUNNING


@jit_part
def _begin(tick, own, partners, goal_id):
    """Chooses the middle of a circle, and gives everybody a place in it.

    Returns whether that is possible.
    """
    count = len(partners) + 1
    rows = np.empty(count, np.int64)
    rows[0] = tick.index
    for i in range(len(partners)):
        is_there = human_at(tick, partners[i]).x != OUTSIDE
        if partners[i] == tick.index or not is_there:
            return False
        rows[i + 1] = partners[i]
    x, y = 0.0, 0.0
    for row in rows:
        x += human_at(tick, row).x / count
        y += human_at(tick, row).y / count
    if goal_id != 0:
        place = place_of(tick, goal_id)
        if place < 0:
            return False
        x, y, _ = pose_of(tick, place)
    own[0] = 1.0
    own[1] = 0.0
    own[2] = 0.0
    own[3] = x
    own[4] = y
    own[5] = tick.yaw
    for i in range(MAX_PARTNERS):
        own[_FIRST + i] = -1.0
    slot_of = np.full(count, -1, np.int64)
    is_taken = np.zeros(count, np.bool_)
    # The shortest way first.
    for _ in range(count):
        shortest, who, where = math.inf, -1, -1
        for i in range(count):
            if slot_of[i] >= 0:
                continue
            it = human_at(tick, rows[i])
            for k in range(count):
                sx, sy = circle_slot(x, y, own[5], k, count)
                way = math.hypot(sx - it.x, sy - it.y)
                if not is_taken[k] and way < shortest:
                    shortest, who, where = way, i, k
        slot_of[who] = where
        is_taken[where] = True
    own[6] = slot_of[0]
    for i in range(1, count):
        # Those who are named take the slots but that of the host, in order.
        at = slot_of[i] - (slot_of[i] > slot_of[0])
        own[_FIRST + at] = rows[i]
    return True


@jit_part
def _offer(tick, own, count):
    """Shows the offer of a circle to the people named."""
    show_activity(tick, TALK, -1, own[6], own[1] == 0 and own[2] == 0)
    signal = own_signal(tick)
    signal[_HOST] = tick.index
    signal[_OPEN] = CLOSED
    signal[_X] = own[3]
    signal[_Y] = own[4]
    signal[_ANGLE] = own[5]
    for i in range(count - 1):
        signal[_PARTNERS + i] = own[_FIRST + i]


@jit_part
def _is_ready(tick, own, count):
    """Returns whether all are in their places and face the middle."""
    x, y = own[3], own[4]
    for k in range(count):
        row = tick.index
        if k != own[6]:
            row = np.int64(own[_FIRST + k - (k > own[6])])
        # (The memory may be of a trial with more people.)
        if not 0 <= row < tick.num_humans:
            return False
        it = human_at(tick, row)
        sx, sy = circle_slot(x, y, own[5], k, count)
        if math.hypot(sx - it.x, sy - it.y) > _NEAR:
            return False
        if bearing_error(it, x, y) > _FACING:
            return False
    return True


@register_action(
    "SetGroupWalk",
    memory={"ticks": 0.0},
    ignored=(*IGNORED, "main_agent_id"),
    social=True,
)
@jit
def set_group_walk(
    tick: Tick,
    own: Array,
    non_main_agent_ids: People,
    duration: Seconds = 0.0,
    robot: Role = "pedestrian",
) -> NodeStatus:
    """Walks to the current goal as a group with up to six people.

    It ends after `duration`, or never if that is 0; without a goal, they stand.
    """
    partners = people_in(tick, non_main_agent_ids)
    if not len(partners):
        own[0] = 0.0
        return FAILURE
    act(tick, robot)
    tick.group_id = group_of(tick.index)
    show_activity(tick, WALK, -1, -1)
    signal = own_signal(tick)
    signal[_HOST] = tick.index
    signal[_OPEN] = CLOSED
    x, y = tick.x, tick.y
    if has_goal(tick):
        x, y = goal_of(tick)
    else:
        stand(tick)
    signal[_X] = x
    signal[_Y] = y
    for i in range(len(partners)):
        signal[_PARTNERS + i] = partners[i]
    status: NodeStatus = run_for(tick, own, duration)
    return status
