"""The action of letting a robot pass: MakeWay.

The robot's way is the one ahead of it, along its heading while it stands.
Distances are between the discs of person and robot, with the radii of their
states, unless stated otherwise.
"""

import math
from typing import Annotated

from hunav_drake.systems.behavior.leaves.pacing import (
    AIM,
    PRESSING,
    STANDING,
    Deceleration,
    PortDistance,
    PortSpeed,
    TurnRate,
    come_to_rest,
    face,
    head_for,
    slow_down_before,
    speed_of,
    walk_at,
)
from hunav_drake.systems.behavior.leaves.reactions import TURN_RATE
from hunav_drake.systems.behavior.leaves.robot_conditions import SLOW
from hunav_drake.systems.behavior.leaves.spots import (
    Wanted,
    drive_of,
    find_spot,
    way_off,
    way_past,
)
from hunav_drake.systems.behavior.leaves.walking import (
    IGNORED,
    UNSEEN,
    BehaviorStatus,
)
from hunav_drake.systems.behavior.nodes.control_flow import steps_reach
from hunav_drake.systems.behavior.nodes.registry import register_action
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
    robot_at,
    robot_of,
)
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit, jit_part
from hunav_drake.systems.common.schema import within

# The least gap between the discs at which robots pass; and the gap beyond which
# a robot that stands has other reasons; in meters.
_LEAST = 0.1
_ENOUGH = 0.2

# The least length of a move for more room, and the least gain of room, in
# meters.
_WORTH = 0.2
_MORE = 0.1

# The person has arrived within these distances, in meters: on the way, at the
# spot, and if it comes no nearer.
_ON_WAY = 0.1
_ARRIVED = 0.05
_NEAR = 0.3

# The times after which a person chooses anew, in seconds: if it comes no nearer
# to the spot or the robot has turned; and if the robot stands, nearby without
# room for it, or far away. Then the distance that is nearby, and the tolerated
# lack of room, in meters.
_HELD_OFF = 1.0
_STUCK = 3.0
_NEARBY = 1.5
_CLOSE = 0.02

# The largest lead of people who walk away from a robot, in meters.
_LEAD = 3.0

# The ratio of the speed of people who walk away to that of the robot.
_FASTER = 1.2

# The distance of a spot from which walls do not keep the person off, in meters.
_AT_WALL = 0.6

# The stages of making way, and the slots of memory.
_GO_BACK, _GO_ASIDE, _WAIT, _GO_AWAY, _GO_PAST = 1.0, 2.0, 3.0, 4.0, 5.0
_STAGE, _PLACES, _WAITED, _ROBOT, _HELD, _NEEDED = 0, 1, 5, 6, 7, 8
_SIZE = 9


@register_action(
    "MakeWay",
    memory={
        "stage": 0.0,
        "back x": 0.0,
        "back y": 0.0,
        "spot x": 0.0,
        "spot y": 0.0,
        "waited": 0.0,
        "robot": 0.0,
        "held": 0.0,
        "needed": 0.0,
    },
    ignored=IGNORED,
)
@jit
def make_way(
    tick: Tick,
    own: Array,
    clearance: PortDistance = 0.3,
    speed: PortSpeed = 0.6,
    seconds: Annotated[float, within(0, 1e9, "s")] = 10.0,
    deceleration: Deceleration = 2.5,
    turn_rate: TurnRate = TURN_RATE,
    status: BehaviorStatus = 2,
) -> NodeStatus:
    """Steps aside, or back and aside, and waits while the robot passes.

    The spot is beside the robot's way, and as far back along it as walls
    demand, as in a door. It leaves `clearance` between the discs when the
    robot passes, or the room that there is. Where that is less than 0.1 m, the
    person walks away ahead of the robot until there is room, or at a dead end
    past the robot, if it stands and the bodies fit. The same applies where
    less than 0.2 m is left and the robot stands nearby for 3 s. The person
    walks at `speed` at most, or fast enough to keep ahead of the robot. It
    waits until the robot has passed, has turned elsewhere, or has stood far
    off for 3 s; and for `seconds` at most, not counting the time while the
    robot is due within `seconds`. Its behavior status is `status` meanwhile.
    The action fails if there is no robot.
    """
    index = robot_of(tick)
    if index < 0:
        return FAILURE
    if own[_STAGE] != 0 and 0 <= own[_ROBOT] < tick.num_robots:
        # (Another one may be nearer now.)
        index = int(own[_ROBOT])
        tick.noticed = index
    else:
        for i in range(_SIZE):
            own[i] = 0.0
        own[_ROBOT] = index
        own[_NEEDED] = _LEAST
    robot = robot_at(tick, index)
    drive = drive_of(robot, tick)
    own[_WAITED] += drive.speed * seconds <= drive.along
    if drive.along < -drive.both or steps_reach(
        own[_WAITED], tick.time_step, seconds
    ):
        own[_STAGE] = 0.0
        return SUCCESS
    pace = min(max(speed, _FASTER * drive.speed), tick.max_speed)
    if own[_STAGE] == 0 or own[_STAGE] == _GO_AWAY:
        _choose(tick, own, drive, clearance, own[_NEEDED], pace, 0.0)
        if own[_STAGE] == _GO_AWAY and _stands_near(drive):
            _look_past(tick, own, drive)
    elif own[_STAGE] != _GO_PAST and _is_held(tick, own, robot, clearance):
        own[_HELD] = 0.0
        is_far = drive.along > drive.both + _NEARBY
        if own[_STAGE] == _WAIT and (
            abs(drive.beside) > _elsewhere(drive, clearance)
            or (is_far and drive.speed < SLOW)
        ):
            own[_STAGE] = 0.0
            return SUCCESS
        own[_NEEDED] = max(min(_gap(drive) + _MORE, clearance), _LEAST)
        _choose(tick, own, drive, clearance, own[_NEEDED], pace, _WORTH)
    tick.behavior_status = status
    # (The way leads clear of it.)
    tick.robot_role = UNSEEN
    if own[_STAGE] == _GO_AWAY:
        goes = _goes_away(tick, own, drive, pace, deceleration)
    elif own[_STAGE] == _GO_PAST:
        goes = _goes_past(tick, own, pace)
    else:
        goes = _goes_to_spot(tick, own, robot, pace, deceleration)
    if not goes:
        come_to_rest(tick, deceleration)
        face(tick, robot.x, robot.y, turn_rate)
    return RUNNING


@jit_part
def _gap(drive):
    """Returns the gap at which a robot would pass the person now."""
    return abs(drive.beside) - drive.both


@jit_part
def _elsewhere(drive, clearance):
    """Returns the distance beside its way at which a robot passes nobody."""
    return drive.both + clearance + _NEAR


@jit_part
def _choose(tick, own, drive, gap, least, pace, away):
    """Chooses the spot to go to, or to go away from the robot."""
    spot = find_spot(tick, drive, Wanted(gap, least, pace, away))
    own[_STAGE] = _GO_AWAY
    if spot.gap > -math.inf:
        own[_STAGE] = _GO_BACK
        _set_places(own, spot)


@jit_part
def _set_places(own, spot):
    own[_PLACES] = spot.back_x
    own[_PLACES + 1] = spot.back_y
    own[_PLACES + 2] = spot.x
    own[_PLACES + 3] = spot.y


@jit_part
def _is_held(tick, own, robot, clearance):
    """Returns whether the spot has been unsuitable for too long."""
    drive = drive_of(robot, tick)
    gap = _gap(drive)
    seconds = 0.0
    if own[_STAGE] != _WAIT:
        # Others or walls keep the person off it.
        seconds = _HELD_OFF if speed_of(tick) < STANDING else 0.0
    elif (
        gap < min(_LEAST / 2, clearance - _CLOSE)
        or gap > _elsewhere(drive, clearance) - drive.both
    ):
        # The robot has turned.
        seconds = _HELD_OFF
    elif drive.speed < SLOW and (
        drive.along > drive.both + _NEARBY
        or (
            gap < min(clearance, _ENOUGH) - _CLOSE
            and not _is_another_ahead(tick, robot)
        )
    ):
        # It does not come.
        seconds = _STUCK
    own[_HELD] = own[_HELD] + 1 if seconds > 0 else 0.0
    return seconds > 0 and steps_reach(own[_HELD], tick.time_step, seconds)


@jit_part
def _is_another_ahead(tick, robot):
    """Returns whether a robot may be standing for another person."""
    for i in range(tick.num_humans):
        drive = drive_of(robot, human_at(tick, i))
        near = 0 < drive.along < drive.both + _NEARBY
        if i != tick.index and near and _gap(drive) < _LEAST:
            return True
    return False


@jit_part
def _stands_near(drive):
    """Returns whether the robot stands where it may want to pass."""
    return drive.speed < SLOW and drive.along < drive.both + _NEARBY


@jit_part
def _goes_to_spot(tick, own, robot, pace, deceleration):
    """Walks to the spot, first back and then aside; returns whether it does."""
    for stage in (_GO_BACK, _GO_ASIDE):
        if own[_STAGE] > stage:
            continue
        first = _PLACES + 2 * int(stage - _GO_BACK)
        x, y = own[first], own[first + 1]
        dx, dy = x - tick.x, y - tick.y
        left = math.hypot(dx, dy)
        held = own[_HELD] * tick.time_step > _HELD_OFF / 2
        near = _ON_WAY if stage == _GO_BACK else _ARRIVED
        if left > (_NEAR if held else near):
            own[_STAGE] = stage
            # (Around a robot that is too near.)
            rx, ry = tick.x - robot.x, tick.y - robot.y
            away = max(math.hypot(rx, ry), 1e-9)
            both = tick.radius + robot.radius
            out = left * max(both + _LEAST - away, 0.0) / (2 * _LEAST * away)
            x, y = x + out * rx, y + out * ry
            head_for(tick, x, y, near / 2)
            walk_at(tick, pace, deceleration)
            if stage == _GO_ASIDE:
                if deceleration > 0:
                    slow_down_before(tick, left, deceleration)
                _press(tick, dx / left, dy / left, left)
            return True
    own[_STAGE] = _WAIT
    return False


@jit_part
def _goes_away(tick, own, drive, pace, deceleration):
    """Walks away ahead of the robot; returns whether it does.

    Where others block the way it steps aside, as far as there is room.
    """
    if drive.along - drive.both > _LEAD:
        return False
    dx, dy, free = way_off(tick, drive)
    if free <= _ON_WAY:
        return False
    own[_HELD] = own[_HELD] + 1 if speed_of(tick) < STANDING else 0.0
    if steps_reach(own[_HELD], tick.time_step, _HELD_OFF):
        own[_HELD] = 0.0
        least = _gap(drive) + _MORE
        _choose(tick, own, drive, least, least, pace, 0.0)
    head_for(tick, tick.x + free * dx, tick.y + free * dy, _ARRIVED / 2)
    walk_at(tick, pace, deceleration)
    if deceleration > 0:
        slow_down_before(tick, free, deceleration)
    _press(tick, dx, dy, free)
    return True


@jit_part
def _look_past(tick, own, drive):
    """Decides to go past a robot that stands, where no other way is left."""
    _, _, free = way_off(tick, drive)
    if free > _ON_WAY:
        return
    spot = way_past(tick, drive)
    if spot.gap > -math.inf:
        own[_STAGE] = _GO_PAST
        _set_places(own, spot)


@jit_part
def _goes_past(tick, own, pace):
    """Walks past a robot along a wall; returns whether it does."""
    ax, ay = own[_PLACES], own[_PLACES + 1]
    bx, by = own[_PLACES + 2], own[_PLACES + 3]
    length = math.hypot(bx - ax, by - ay)
    ex, ey = (bx - ax) / length, (by - ay) / length
    along = (tick.x - ax) * ex + (tick.y - ay) * ey
    if math.hypot(ax - tick.x, ay - tick.y) <= _ON_WAY:
        own[_HELD] = -1.0
    along = min(along + AIM, length) if own[_HELD] < 0 else 0.0
    head_for(tick, ax + along * ex, ay + along * ey, 0.0)
    walk_at(tick, pace, 0.0)
    tick.desired_speed = PRESSING
    return True


@jit_part
def _press(tick, dx, dy, left):
    """Overcomes the forces of walls that keep the person off a spot there.

    The spot is `left` meters away in the direction of (dx, dy).
    """
    if left > _AT_WALL:
        return
    reach = left + tick.radius + _NEAR
    x, y = tick.x + reach * dx, tick.y + reach * dy
    if cast_ray(tick, tick, x, y) <= 1:
        tick.desired_speed = PRESSING
