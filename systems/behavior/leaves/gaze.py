"""Looking at others, and noticing their looks: LookAtAgent, ..."""

import math
from typing import Annotated

from hunav_drake.systems.behavior.leaves.others import distance_between
from hunav_drake.systems.behavior.leaves.pacing import (
    TurnRate,
    face,
    stand,
    wrapped,
)
from hunav_drake.systems.behavior.leaves.reactions import TURN_RATE
from hunav_drake.systems.behavior.leaves.robot_conditions import Distance
from hunav_drake.systems.behavior.leaves.social_ports import (
    NO_RESULT,
    PersonNumber,
    PlaceName,
    Result,
    Seconds,
)
from hunav_drake.systems.behavior.leaves.walking import IGNORED
from hunav_drake.systems.behavior.nodes.control_flow import steps_reach
from hunav_drake.systems.behavior.nodes.registry import register_action
from hunav_drake.systems.behavior.nodes.social import (
    AT_POINT,
    body_at,
    comes_first,
    give_result,
    is_clear,
    look_at,
    notice,
    num_bodies,
    number_of,
    place_of,
    pose_of,
    row_of,
    signal_of,
)
from hunav_drake.systems.behavior.nodes.status import (
    FAILURE,
    RUNNING,
    SUCCESS,
    NodeStatus,
)
from hunav_drake.systems.behavior.nodes.tick import (
    Tick,
    human_at,
    kept_robot,
    robot_at,
)
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit, jit_part
from hunav_drake.systems.common.layout import Signal
from hunav_drake.systems.common.schema import within

Angle = Annotated[float, within(0, math.pi, "rad", low_open=True)]

_GAZE, _X, _Y = int(Signal.GAZE), int(Signal.GAZE_X), int(Signal.GAZE_Y)

_WATCHING = {"ticks": 0.0, "looker": -1.0, "ticks of the look": 0.0}


@jit_part
def bearing_error(tick, x, y):
    """Returns the angle between the person's yaw and a point, in radians."""
    if x == tick.x and y == tick.y:
        return 0.0
    return abs(wrapped(math.atan2(y - tick.y, x - tick.x) - tick.yaw))


@jit_part
def _turn_to(tick, target, x, y, tolerance, walk, turn_rate):
    look_at(tick, target, x, y)
    tick.behavior_status = 1
    if walk != 0:
        return SUCCESS
    face(tick, x, y, turn_rate)
    if bearing_error(tick, x, y) <= tolerance:
        return SUCCESS
    stand(tick)
    return RUNNING


@register_action("LookAtAgent", ignored=IGNORED, social=True)
@jit
def look_at_agent(
    tick: Tick,
    target_id: PersonNumber,
    yaw_tolerance: Angle = 0.05,
    walk: bool = False,
    turn_rate: TurnRate = TURN_RATE,
) -> NodeStatus:
    """Stands and turns to a person; with `walk`, only looks there.

    It runs until the person faces the other within `yaw_tolerance`.
    """
    target = row_of(tick, target_id)
    if target < 0:
        return FAILURE
    it = human_at(tick, target)
    status: NodeStatus = _turn_to(
        tick, target, it.x, it.y, yaw_tolerance, walk, turn_rate
    )
    return status


@register_action(
    "LookAtRobot", memory={"robot": 0.0}, ignored=IGNORED, social=True
)
@jit
def look_at_robot(
    tick: Tick,
    own: Array,
    yaw_tolerance: Angle = 0.05,
    walk: bool = False,
    turn_rate: TurnRate = TURN_RATE,
) -> NodeStatus:
    """Stands and turns to the robot; with `walk`, only looks there.

    It runs until the person faces it within `yaw_tolerance`.
    """
    index = kept_robot(tick, own, 0)
    if index < 0:
        return FAILURE
    it = robot_at(tick, index)
    target = tick.num_humans + index
    status: NodeStatus = _turn_to(
        tick, target, it.x, it.y, yaw_tolerance, walk, turn_rate
    )
    if status == SUCCESS:
        own[0] = 0.0
    return status


@register_action("LookAtPoint", ignored=IGNORED, social=True)
@jit
def look_at_point(
    tick: Tick,
    goal_id: PlaceName,
    yaw_tolerance: Angle = 0.05,
    walk: bool = False,
    turn_rate: TurnRate = TURN_RATE,
) -> NodeStatus:
    """Stands and turns to a place; with `walk`, only looks there.

    It runs until the person faces the place within `yaw_tolerance`.
    """
    place = place_of(tick, goal_id)
    if place < 0:
        return FAILURE
    x, y, _ = pose_of(tick, place)
    status: NodeStatus = _turn_to(
        tick, AT_POINT, x, y, yaw_tolerance, walk, turn_rate
    )
    return status


@jit_part
def _looks_at_me(tick, index, distance, angle, occlusion):
    """Returns the distance of a body that looks at me; else infinity."""
    it = body_at(tick, index)
    away = distance_between(tick, it)
    if index == tick.index or away > distance:
        return math.inf
    signal = signal_of(tick, index)
    if signal[_GAZE] != tick.index:
        if signal[_GAZE] >= 0:
            return math.inf
        towards = it.yaw
        if signal[_GAZE] == AT_POINT:
            towards = math.atan2(signal[_Y] - it.y, signal[_X] - it.x)
        bearing = math.atan2(tick.y - it.y, tick.x - it.x)
        if abs(wrapped(bearing - towards)) > angle:
            return math.inf
    if occlusion != 0 and not is_clear(tick, it, tick):
        return math.inf
    return away


@jit_part
def _watch(tick, own, looker, duration, hold):
    """Counts the ticks of a look; returns the status of waiting for it."""
    own[0] += 1
    if looker < 0 or own[1] != looker:
        own[2] = 0.0
    own[1] = looker
    own[2] += looker >= 0
    status = RUNNING
    if looker >= 0 and steps_reach(own[2], tick.time_step, hold):
        status = SUCCESS
    elif steps_reach(own[0], tick.time_step, duration):
        status = FAILURE
    if status != RUNNING:
        own[0] = 0.0
        own[1] = -1.0
        own[2] = 0.0
    return status


@register_action(
    "IsAnyoneLookingAtMe", memory=_WATCHING, ignored=IGNORED, social=True
)
@jit
def is_anyone_looking_at_me(
    tick: Tick,
    own: Array,
    distance_threshold: Distance = 5.0,
    angle_threshold: Angle = 0.2,
    duration: Seconds = 5.0,
    hold: Seconds = 0.0,
    occlusion: bool = True,
    observer_id: Result = NO_RESULT,
) -> NodeStatus:
    """Waits until somebody near has looked here for `hold`.

    It fails after `duration`. The entry of `observer_id` gets the number of
    the one who has, the nearest at first; if it is a robot, -1, and that robot
    is noticed. The person walks on meanwhile.
    """
    found, nearest, before = -1, math.inf, -1
    for i in range(num_bodies(tick)):
        away = _looks_at_me(
            tick, i, distance_threshold, angle_threshold, occlusion
        )
        if comes_first(tick, i, away, found, nearest):
            found, nearest = i, away
        if i == own[1] and away < math.inf:
            before = i
    if before >= 0:
        # (Another who comes nearer does not end a look.)
        found = before
    status: NodeStatus = _watch(tick, own, found, duration, hold)
    if status == SUCCESS:
        notice(tick, found)
        give_result(tick, observer_id, number_of(tick, found))
    return status


@register_action(
    "IsLookingAtMe", memory=_WATCHING, ignored=IGNORED, social=True
)
@jit
def is_looking_at_me(
    tick: Tick,
    own: Array,
    target_id: PersonNumber,
    distance_threshold: Distance = 5.0,
    angle_threshold: Angle = 0.2,
    duration: Seconds = 5.0,
    hold: Seconds = 0.0,
    occlusion: bool = True,
) -> NodeStatus:
    """Waits until a person near has looked here for `hold`.

    It fails after `duration`. The person walks on meanwhile.
    """
    target = row_of(tick, target_id)
    if (
        target >= 0
        and _looks_at_me(
            tick, target, distance_threshold, angle_threshold, occlusion
        )
        == math.inf
    ):
        target = -1
    status: NodeStatus = _watch(tick, own, target, duration, hold)
    return status
