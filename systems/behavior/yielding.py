"""The actions of people who make way for the robot."""

import math
from typing import Annotated, NamedTuple

from hunav_drake.systems.behavior.decorators import steps_reach
from hunav_drake.systems.behavior.leaves import IGNORED, ROLES, Role
from hunav_drake.systems.behavior.person import Moment, Row
from hunav_drake.systems.behavior.reactions import (
    TURN_RATE,
    PortDistance,
    TurnRate,
    face,
)
from hunav_drake.systems.behavior.registry import register_action
from hunav_drake.systems.behavior.status import Status
from hunav_drake.systems.behavior.visibility import (
    Distance,
    along_way,
    course,
    way,
)
from hunav_drake.systems.columns import (
    GOAL_RADIUS,
    GOAL_X,
    GOAL_Y,
    HAS_GOAL,
    HOLD,
    ROBOT_ROLE,
)
from hunav_drake.systems.layout import RADIUS, X, Y
from hunav_drake.systems.schema import within

# What is left free between the body and a wall, in meters.
_WALL_GAP = 0.15

# The person has arrived this near to the spot, in meters.
_ARRIVED = 0.05

# Someone less far beside the robot's course is on it, in meters.
_BESIDE = 0.1


# Nobody changes sides for less room than this, in meters.
_WORTH = 0.1

# How far ahead the point is that someone who passes the robot walks to, in
# meters.
_AHEAD = 0.5


@register_action("StandStill", memory={"ticks": 0.0}, ignored=IGNORED)
def stand_still(
    moment: Moment,
    own: list[float],
    *,
    seconds: Annotated[float, within(0, 1e9, "s")] = 0.0,
    turn_rate: TurnRate = TURN_RATE,
) -> Status:
    """Stands still and turns to the robot, if there is one.

    It runs for `seconds`, and for one tick at least.
    """
    moment.command[HOLD] = 1.0
    robot = moment.robot
    if robot is not None:
        face(moment, robot[X], robot[Y], turn_rate)
    moment.behavior_status = 1
    own[0] += 1
    if steps_reach(own[0], moment.person.time_step, seconds):
        own[0] = 0.0
        return Status.SUCCESS
    return Status.RUNNING


@register_action(
    "StepAside",
    memory={"chosen": 0.0, "spot x": 0.0, "spot y": 0.0},
    ignored=IGNORED,
)
def step_aside(
    moment: Moment, own: list[float], *, clearance: PortDistance = 1.0
) -> Status:
    """Walks to a spot `clearance` beside the robot's course.

    The side is the one where the person is, the right-hand side on the course
    itself, and the other one where walls leave more room on that. The spot is
    chosen once; the action runs until the person is there, and fails if there
    is no robot.
    """
    robot = moment.robot
    if robot is None:
        return Status.FAILURE
    if not own[0]:
        aside = _way_aside(moment, robot, course(robot), clearance)
        x = moment.state[X] + aside.free * aside.nx
        y = moment.state[Y] + aside.free * aside.ny
        own[:] = [1.0, x, y]
    state, command = moment.state, moment.command
    moment.behavior_status = 1
    if math.hypot(own[1] - state[X], own[2] - state[Y]) <= _ARRIVED:
        own[0] = 0.0
        command[HOLD] = 1.0
        return Status.SUCCESS
    command[GOAL_X] = own[1]
    command[GOAL_Y] = own[2]
    command[GOAL_RADIUS] = _ARRIVED / 2
    command[HAS_GOAL] = 1.0
    return Status.RUNNING


@register_action("PassBy", ignored=IGNORED)
def pass_by(
    moment: Moment,
    *,
    distance: Distance,
    clearance: PortDistance = 1.0,
    robot: Role = "obstacle",
) -> Status:
    """Walks on towards the goal, past the robot at a distance of `clearance`.

    The side is chosen as by StepAside, with the person's way for the course;
    where walls leave less room, the person passes between them and the robot.
    The action runs until no robot is both ahead on the way and at most
    `distance` away.
    """
    state, command = moment.state, moment.command
    ahead = [
        (math.hypot(row[X] - state[X], row[Y] - state[Y]), row)
        for row in moment.robots
        if along_way(moment, row)[0] > 0
    ]
    away, row = min(ahead, default=(math.inf, state))
    if away > distance or moment.goal is None:
        return Status.SUCCESS
    gx, gy = way(moment)
    aside = _way_aside(moment, row, (-gx, -gy), clearance)
    command[ROBOT_ROLE] = ROLES[robot]
    command[GOAL_X] = state[X] + _AHEAD * gx + aside.way * aside.nx
    command[GOAL_Y] = state[Y] + _AHEAD * gy + aside.way * aside.ny
    moment.behavior_status = 1
    return Status.RUNNING


class _Aside(NamedTuple):
    """The way to the side of a course.

    Attributes:
        nx: Its direction in W: a unit vector.
        ny: Likewise.
        way: Its length, in meters.
        free: How much of it the walls leave.
    """

    nx: float
    ny: float
    way: float
    free: float


def _way_aside(
    moment: Moment, robot: Row, course: tuple[float, float], clearance: float
) -> _Aside:
    """Returns the way to the side on which to be `clearance` off a course."""
    state = moment.state
    x, y = state[X], state[Y]
    hx, hy = course
    # The left of the robot: the right of someone who faces it.
    nx, ny = -hy, hx
    beside = (x - robot[X]) * nx + (y - robot[Y]) * ny
    side = -1.0 if beside < -_BESIDE else 1.0

    def aside(side: float) -> _Aside:
        way = max(clearance - side * beside, 0.0)
        gap = state[RADIUS] + _WALL_GAP
        reach = way + gap
        free = reach * moment.clear_part(
            x + side * reach * nx, y + side * reach * ny
        )
        return _Aside(side * nx, side * ny, way, min(way, max(free - gap, 0.0)))

    near, far = aside(side), aside(-side)
    # How much farther off the course the other side leads.
    gain = (far.free - side * beside) - (near.free + side * beside)
    return far if near.free < near.way and gain > _WORTH else near
