"""Walking to places and other people: GoTo, FollowAgent, AvoidRobot, ...

These actions walk to a point of their own; the person's goals stay. Those
without an end of their own run for `duration`, or for ever if that is 0.
"""

import math
from typing import Literal

from hunav_drake.systems.behavior.leaves.others import distance_between
from hunav_drake.systems.behavior.leaves.pacing import (
    SETTLED,
    STANDING,
    PortDistance,
    PortSpeed,
    PositiveDistance,
    TurnRate,
    face,
    run_for,
    speed_of,
    stand,
    walk_to,
)
from hunav_drake.systems.behavior.leaves.reactions import TURN_RATE
from hunav_drake.systems.behavior.leaves.robot_conditions import course
from hunav_drake.systems.behavior.leaves.social_ports import (
    PersonNumber,
    PlaceName,
    Seconds,
)
from hunav_drake.systems.behavior.leaves.walking import IGNORED, Role, act
from hunav_drake.systems.behavior.nodes.control_flow import steps_reach
from hunav_drake.systems.behavior.nodes.registry import register_action
from hunav_drake.systems.behavior.nodes.social import (
    is_clear,
    look_at,
    place_of,
    row_of,
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
    cast_ray,
    human_at,
    kept_robot,
    robot_at,
    way_to,
)
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit, jit_part
from hunav_drake.systems.common.layout import Activity

_FOLLOW, _BLOCK = float(Activity.FOLLOW), float(Activity.BLOCK)
_FLEE = float(Activity.FLEE)

# The time in which a gap is to be closed, and by which a robot is expected
# ahead of where it is, in seconds.
_CLOSING, _AHEAD = 1.0, 0.5

# A robot faster than this, in m/s, on a course within 60 degrees of that to the
# person, comes.
_COMING = 0.1

# A person who is nearly far enough flees at this speed, in m/s, or as fast as
# it takes to be there in the time, in seconds.
_SLOWLY, _SOON = 0.3, 0.5

# How far a person flees at a time, the room that this takes, and the distance
# beyond which it is enough, in meters.
_FLIGHT, _ROOM, _FAR_ENOUGH = 2.0, 1.0, 0.3


@register_action("GoTo", ignored=(*IGNORED, "stop_duration"), social=True)
@jit
def go_to(
    tick: Tick,
    goal_id: PlaceName,
    tolerance: PositiveDistance = 0.1,
    robot: Role = "pedestrian",
) -> NodeStatus:
    """Walks to a place, and stands there.

    It runs until the person is at most `tolerance` away. Of a seat or bed, it
    stands beside it; of a screen, before it.
    """
    place = place_of(tick, goal_id)
    if place < 0:
        return FAILURE
    act(tick, robot)
    x, y = way_to(tick, place)
    if math.hypot(x - tick.x, y - tick.y) <= tolerance:
        stand(tick)
        return SUCCESS
    walk_to(tick, x, y, tick.max_speed)
    return RUNNING


@jit_part
def _approach(tick, it, closest, speed, turn_rate):
    """Walks to a body until `closest`; returns whether it is that near."""
    away = distance_between(tick, it)
    if away <= closest:
        stand(tick)
        face(tick, it.x, it.y, turn_rate)
        return True
    speed = min(speed * away / (away + closest), tick.max_speed)
    walk_to(tick, it.x, it.y, speed)
    return False


@register_action(
    "ApproachAgent", memory={"ticks": 0.0}, ignored=IGNORED, social=True
)
@jit
def approach_agent(
    tick: Tick,
    own: Array,
    target_agent_id: PersonNumber,
    closest_dist: PositiveDistance = 1.5,
    max_vel: PortSpeed = 1.5,
    duration: Seconds = 0.0,
    end_on_arrival: bool = False,
    turn_rate: TurnRate = TURN_RATE,
    robot: Role = "pedestrian",
) -> NodeStatus:
    """Walks to another person, more slowly as it comes near, and faces them.

    It ends after `duration`, or with `end_on_arrival` at `closest_dist`.
    """
    target = row_of(tick, target_agent_id)
    if target < 0:
        own[0] = 0.0
        return FAILURE
    it = human_at(tick, target)
    act(tick, robot)
    look_at(tick, target, it.x, it.y)
    there = _approach(tick, it, closest_dist, max_vel, turn_rate)
    status: NodeStatus = run_for(tick, own, duration)
    if there and end_on_arrival != 0:
        own[0] = 0.0
        return SUCCESS
    return status


@register_action(
    "FollowAgent",
    memory={"ticks": 0.0, "ticks unseen": 0.0},
    ignored=IGNORED,
    social=True,
)
@jit
def follow_agent(
    tick: Tick,
    own: Array,
    target_agent_id: PersonNumber,
    closest_dist: PositiveDistance = 1.5,
    max_vel: PortSpeed = 1.5,
    duration: Seconds = 0.0,
    lost: Seconds = 1e9,
    turn_rate: TurnRate = TURN_RATE,
    robot: Role = "pedestrian",
) -> NodeStatus:
    """Walks behind another person, at `closest_dist`.

    It ends after `duration`; it fails once the other has been behind a wall for
    `lost`.
    """
    target = row_of(tick, target_agent_id)
    if target < 0:
        own[0] = 0.0
        own[1] = 0.0
        return FAILURE
    it = human_at(tick, target)
    own[1] = 0.0 if is_clear(tick, tick, it) else own[1] + 1
    if own[1] > 0 and steps_reach(own[1], tick.time_step, lost):
        own[0] = 0.0
        own[1] = 0.0
        return FAILURE
    act(tick, robot)
    show_activity(tick, _FOLLOW, -1, -1)
    away = distance_between(tick, it)
    speed = max(0.0, speed_of(it) + (away - closest_dist) / _CLOSING)
    speed = min(speed, max_vel, tick.max_speed)
    if speed < STANDING:
        stand(tick)
        face(tick, it.x, it.y, turn_rate)
    else:
        walk_to(tick, it.x, it.y, speed)
    status: NodeStatus = run_for(tick, own, duration)
    if status == SUCCESS:
        own[1] = 0.0
    return status


@register_action(
    "ApproachRobot", memory={"ticks": 0.0, "robot": 0.0}, ignored=IGNORED
)
@jit
def approach_robot(
    tick: Tick,
    own: Array,
    closest_dist: PositiveDistance = 1.5,
    max_vel: PortSpeed = 1.8,
    duration: Seconds = 0.0,
    turn_rate: TurnRate = TURN_RATE,
    robot: Role = "pedestrian",
) -> NodeStatus:
    """Walks to the robot, and faces it; gives way if the robot comes.

    It ends after `duration`; it fails if there is no robot.
    """
    index = kept_robot(tick, own, 1)
    if index < 0:
        own[0] = 0.0
        return FAILURE
    it = robot_at(tick, index)
    act(tick, robot)
    away = distance_between(tick, it)
    px, py = tick.x - it.x, tick.y - it.y
    hx, hy = course(it)
    comes = speed_of(it) > _COMING and px * hx + py * hy > 0.5 * away
    if comes and 0 < away < 2 * closest_dist:
        part = 1.5 * closest_dist / away
        speed = min(1.2 * max_vel, tick.max_speed)
        walk_to(tick, it.x + part * px, it.y + part * py, speed)
    else:
        _approach(tick, it, closest_dist, max_vel, turn_rate)
    status: NodeStatus = run_for(tick, own, duration)
    if status == SUCCESS:
        own[1] = 0.0
    return status


@jit_part
def block(tick, it, front_dist, max_vel, turn_rate):
    """Walks to the spot in front of a body, facing it: see `BlockAgent`."""
    fast = speed_of(it)
    reach = front_dist + _AHEAD * fast
    x = it.x + reach * math.cos(it.yaw)
    y = it.y + reach * math.sin(it.yaw)
    gap = math.hypot(x - tick.x, y - tick.y)
    if fast < _COMING and gap < SETTLED:
        stand(tick)
    else:
        walk_to(tick, x, y, min(max_vel, fast + gap / _CLOSING))
    face(tick, it.x, it.y, turn_rate)


@register_action(
    "BlockAgent", memory={"ticks": 0.0}, ignored=IGNORED, social=True
)
@jit
def block_agent(
    tick: Tick,
    own: Array,
    target_agent_id: PersonNumber,
    front_dist: PositiveDistance = 1.0,
    max_vel: PortSpeed = 2.0,
    duration: Seconds = 0.0,
    turn_rate: TurnRate = TURN_RATE,
    robot: Role = "pedestrian",
) -> NodeStatus:
    """Stays in front of another person, facing them.

    The spot is `front_dist` ahead of the center, and farther by the way of
    half a second. The action ends after `duration`.
    """
    target = row_of(tick, target_agent_id)
    if target < 0:
        own[0] = 0.0
        return FAILURE
    act(tick, robot)
    show_activity(tick, _BLOCK, -1, -1)
    it = human_at(tick, target)
    block(tick, it, front_dist, max_vel, turn_rate)
    status: NodeStatus = run_for(tick, own, duration)
    return status


@register_action(
    "StayInFrontOfRobot",
    memory={"ticks": 0.0, "robot": 0.0},
    ignored=IGNORED,
    social=True,
)
@jit
def stay_in_front_of_robot(
    tick: Tick,
    own: Array,
    front_dist: PositiveDistance = 1.0,
    max_vel: PortSpeed = 2.0,
    duration: Seconds = 0.0,
    turn_rate: TurnRate = TURN_RATE,
    robot: Role = "unseen",
) -> NodeStatus:
    """Stays in front of the robot, facing it: HuNavSim 2's BlockRobot.

    As `BlockAgent`; it fails if there is no robot. BlockRobot with the ports of
    HuNavSim 2 is this node.
    """
    index = kept_robot(tick, own, 1)
    if index < 0:
        own[0] = 0.0
        return FAILURE
    act(tick, robot)
    show_activity(tick, _BLOCK, -1, -1)
    block(tick, robot_at(tick, index), front_dist, max_vel, turn_rate)
    status: NodeStatus = run_for(tick, own, duration)
    if status == SUCCESS:
        own[1] = 0.0
    return status


@register_action(
    "AvoidRobot",
    memory={"ticks": 0.0, "flees": 0.0, "robot": 0.0},
    ignored=IGNORED,
    social=True,
)
@jit
def avoid_robot(
    tick: Tick,
    own: Array,
    safe_distance: PortDistance = 3.0,
    runaway_vel: PortSpeed = 1.5,
    duration: Seconds = 0.0,
    then: Literal["stand", "go_on"] = "stand",
    turn_rate: TurnRate = TURN_RATE,
    robot: Role = "pedestrian",
) -> NodeStatus:
    """Keeps away from the robot, where there is room.

    Within `safe_distance` the person walks away, until 0.3 m beyond it; then
    it stands and faces the robot, or walks on to its goal. The action ends
    after `duration`; it fails if there is no robot.
    """
    index = kept_robot(tick, own, 2)
    if index < 0:
        own[0] = 0.0
        own[1] = 0.0
        return FAILURE
    it = robot_at(tick, index)
    act(tick, robot)
    away = distance_between(tick, it)
    if away < safe_distance:
        own[1] = 1.0
    elif away > safe_distance + _FAR_ENOUGH:
        own[1] = 0.0
    if own[1] != 0:
        show_activity(tick, _FLEE, -1, -1)
        left = safe_distance + _FAR_ENOUGH - away
        speed = min(runaway_vel, tick.max_speed)
        _flee(tick, it, min(speed, max(_SLOWLY, left / _SOON)))
    elif int(then) == 0:
        stand(tick)
        face(tick, it.x, it.y, turn_rate)
    status: NodeStatus = run_for(tick, own, duration)
    if status == SUCCESS:
        own[1] = 0.0
        own[2] = 0.0
    return status


@jit_part
def _flee(tick, it, speed):
    """Walks away from a body, past walls; stands where there is no room."""
    straight = math.atan2(tick.y - it.y, tick.x - it.x)
    most, chosen = 0.0, straight
    for off in (0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0):
        bearing = straight + off * math.pi / 6
        x = tick.x + _FLIGHT * math.cos(bearing)
        y = tick.y + _FLIGHT * math.sin(bearing)
        room = _FLIGHT * min(cast_ray(tick, tick, x, y), 1.0) - tick.radius
        if room > most:
            most, chosen = room, bearing
        if room >= _ROOM:
            break
    if most <= 0:
        stand(tick)
        return
    most = min(most, _FLIGHT)
    x = tick.x + most * math.cos(chosen)
    y = tick.y + most * math.sin(chosen)
    walk_to(tick, x, y, speed)
