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
    Drive,
    Wanted,
    drive_of,
    find_spot,
    way_off,
    way_past,
)
from hunav_drake.systems.behavior.leaves.walking import (
    IGNORED,
    ROLES,
    BehaviorStatus,
)
from hunav_drake.systems.behavior.nodes.control_flow import steps_reach
from hunav_drake.systems.behavior.nodes.registry import register_action
from hunav_drake.systems.behavior.nodes.status import NodeStatus
from hunav_drake.systems.behavior.nodes.tick_context import Row, TickContext
from hunav_drake.systems.common.layout import RADIUS, VX, VY, Command, X, Y
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
def make_way(
    context: TickContext,
    own: list[float],
    *,
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
    row = context.robot
    if row is None:
        return NodeStatus.FAILURE
    if own[_STAGE] and own[_ROBOT] < len(context.robots):
        # (Another one may be nearer now.)
        context.notice(int(own[_ROBOT]))
        row = context.robots[int(own[_ROBOT])]
    else:
        own[:] = [0.0] * len(own)
        own[_ROBOT] = float(context.robots.index(row))
        own[_NEEDED] = _LEAST
    drive = drive_of(row, context.state)
    own[_WAITED] += drive.speed * seconds <= drive.along
    if drive.along < -drive.both or steps_reach(
        own[_WAITED], context.person.time_step, seconds
    ):
        own[_STAGE] = 0.0
        return NodeStatus.SUCCESS
    most = context.command[Command.MAX_SPEED]
    pace = min(max(speed, _FASTER * drive.speed), most)
    if own[_STAGE] in (0.0, _GO_AWAY):
        _choose(context, own, drive, Wanted(clearance, own[_NEEDED], pace, 0.0))
        if own[_STAGE] == _GO_AWAY and _stands_near(drive):
            _look_past(context, own, drive)
    elif own[_STAGE] != _GO_PAST and _is_held(context, own, row, clearance):
        own[_HELD] = 0.0
        is_far = drive.along > drive.both + _NEARBY
        if own[_STAGE] == _WAIT and (
            abs(drive.beside) > _elsewhere(drive, clearance)
            or (is_far and drive.speed < SLOW)
        ):
            own[_STAGE] = 0.0
            return NodeStatus.SUCCESS
        own[_NEEDED] = max(min(_gap(drive) + _MORE, clearance), _LEAST)
        wanted = Wanted(clearance, own[_NEEDED], pace, _WORTH)
        _choose(context, own, drive, wanted)
    context.behavior_status = status
    # (The way leads clear of it.)
    context.command[Command.ROBOT_ROLE] = ROLES["unseen"]
    if own[_STAGE] == _GO_AWAY:
        goes = _goes_away(context, own, drive, pace, deceleration)
    elif own[_STAGE] == _GO_PAST:
        goes = _goes_past(context, own, pace)
    else:
        goes = _goes_to_spot(context, own, row, pace, deceleration)
    if not goes:
        come_to_rest(context, deceleration)
        face(context, row[X], row[Y], turn_rate)
    return NodeStatus.RUNNING


def _gap(drive: Drive) -> float:
    """Returns the gap at which a robot would pass the person now."""
    return abs(drive.beside) - drive.both


def _elsewhere(drive: Drive, clearance: float) -> float:
    """Returns the distance beside its way at which a robot passes nobody."""
    return drive.both + clearance + _NEAR


def _choose(
    context: TickContext, own: list[float], drive: Drive, wanted: Wanted
) -> None:
    """Chooses the spot to go to, or to go away from the robot."""
    person = context.person
    others = [
        (it[X], it[Y])
        for i, it in enumerate(context.humans)
        if i != person.index and math.hypot(it[VX], it[VY]) < STANDING
    ]
    spot = find_spot(
        *(context.state, person.body_radius, drive, wanted),
        *(others, person.walls),
    )
    own[_STAGE] = _GO_AWAY
    if spot is not None:
        own[_STAGE] = _GO_BACK
        own[_PLACES : _PLACES + 4] = spot[:4]


def _is_held(
    context: TickContext, own: list[float], robot: Row, clearance: float
) -> bool:
    """Returns whether the spot has been unsuitable for too long."""
    drive = drive_of(robot, context.state)
    gap = _gap(drive)
    seconds = 0.0
    if own[_STAGE] != _WAIT:
        # Others or walls keep the person off it.
        seconds = _HELD_OFF if speed_of(context) < STANDING else 0.0
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
            and not _is_another_ahead(context, robot)
        )
    ):
        # It does not come.
        seconds = _STUCK
    own[_HELD] = own[_HELD] + 1 if seconds else 0.0
    step = context.person.time_step
    return seconds > 0 and steps_reach(own[_HELD], step, seconds)


def _is_another_ahead(context: TickContext, robot: Row) -> bool:
    """Returns whether a robot may be standing for another person."""
    for i, state in enumerate(context.humans):
        drive = drive_of(robot, state)
        near = 0 < drive.along < drive.both + _NEARBY
        if i != context.person.index and near and _gap(drive) < _LEAST:
            return True
    return False


def _stands_near(drive: Drive) -> bool:
    """Returns whether the robot stands where it may want to pass."""
    return drive.speed < SLOW and drive.along < drive.both + _NEARBY


def _goes_to_spot(
    context: TickContext,
    own: list[float],
    robot: Row,
    pace: float,
    deceleration: float,
) -> bool:
    """Walks to the spot, first back and then aside; returns whether it does."""
    state = context.state
    for stage in (_GO_BACK, _GO_ASIDE):
        if own[_STAGE] > stage:
            continue
        first = _PLACES + 2 * int(stage - _GO_BACK)
        x, y = own[first : first + 2]
        dx, dy = x - state[X], y - state[Y]
        left = math.hypot(dx, dy)
        held = own[_HELD] * context.person.time_step > _HELD_OFF / 2
        near = _ON_WAY if stage == _GO_BACK else _ARRIVED
        if left > (_NEAR if held else near):
            own[_STAGE] = stage
            # (Around a robot that is too near.)
            rx, ry = state[X] - robot[X], state[Y] - robot[Y]
            away = max(math.hypot(rx, ry), 1e-9)
            both = state[RADIUS] + robot[RADIUS]
            out = left * max(both + _LEAST - away, 0.0) / (2 * _LEAST * away)
            x, y = x + out * rx, y + out * ry
            head_for(context, x, y, near / 2)
            walk_at(context, pace, deceleration)
            if stage == _GO_ASIDE:
                if deceleration:
                    slow_down_before(context, left, deceleration)
                _press(context, dx / left, dy / left, left)
            return True
    own[_STAGE] = _WAIT
    return False


def _goes_away(
    context: TickContext,
    own: list[float],
    drive: Drive,
    pace: float,
    deceleration: float,
) -> bool:
    """Walks away ahead of the robot; returns whether it does.

    Where others block the way it steps aside, as far as there is room.
    """
    if drive.along - drive.both > _LEAD:
        return False
    person, state = context.person, context.state
    dx, dy, free = way_off(state, person.body_radius, drive, person.walls)
    if free <= _ON_WAY:
        return False
    own[_HELD] = own[_HELD] + 1 if speed_of(context) < STANDING else 0.0
    if steps_reach(own[_HELD], person.time_step, _HELD_OFF):
        own[_HELD] = 0.0
        least = _gap(drive) + _MORE
        _choose(context, own, drive, Wanted(least, least, pace, 0.0))
    head_for(context, state[X] + free * dx, state[Y] + free * dy, _ARRIVED / 2)
    walk_at(context, pace, deceleration)
    if deceleration:
        slow_down_before(context, free, deceleration)
    _press(context, dx, dy, free)
    return True


def _look_past(context: TickContext, own: list[float], drive: Drive) -> None:
    """Decides to go past a robot that stands, where no other way is left."""
    person, state = context.person, context.state
    _, _, free = way_off(state, person.body_radius, drive, person.walls)
    if free > _ON_WAY:
        return
    spot = way_past(state, person.body_radius, drive, person.walls)
    if spot is not None:
        own[_STAGE] = _GO_PAST
        own[_PLACES : _PLACES + 4] = spot[:4]


def _goes_past(context: TickContext, own: list[float], pace: float) -> bool:
    """Walks past a robot along a wall; returns whether it does."""
    state = context.state
    ax, ay, bx, by = own[_PLACES : _PLACES + 4]
    length = math.hypot(bx - ax, by - ay)
    ex, ey = (bx - ax) / length, (by - ay) / length
    along = (state[X] - ax) * ex + (state[Y] - ay) * ey
    if math.hypot(ax - state[X], ay - state[Y]) <= _ON_WAY:
        own[_HELD] = -1.0
    along = min(along + AIM, length) if own[_HELD] < 0 else 0.0
    head_for(context, ax + along * ex, ay + along * ey, 0.0)
    walk_at(context, pace)
    context.command[Command.DESIRED_SPEED] = PRESSING
    return True


def _press(context: TickContext, dx: float, dy: float, left: float) -> None:
    """Overcomes the forces of walls that keep the person off a spot there.

    The spot is `left` meters away in the direction of (dx, dy).
    """
    if left > _AT_WALL:
        return
    state = context.state
    reach = left + state[RADIUS] + _NEAR
    x, y = state[X] + reach * dx, state[Y] + reach * dy
    if context.cast_ray(x, y) <= 1:
        context.command[Command.DESIRED_SPEED] = PRESSING
