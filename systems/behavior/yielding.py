"""The actions of people who make way for the robot."""

import math

from hunav_drake.systems.behavior.leaves import IGNORED
from hunav_drake.systems.behavior.person import Moment, Row
from hunav_drake.systems.behavior.reactions import (
    TURN_RATE,
    PortDistance,
    TurnRate,
    face,
)
from hunav_drake.systems.behavior.registry import register_action
from hunav_drake.systems.behavior.status import Status
from hunav_drake.systems.behavior.visibility import SLOW
from hunav_drake.systems.layout import RADIUS, VX, VY, YAW, Command, X, Y

# What is left free between the body and a wall, in meters.
_WALL_GAP = 0.15

# The person has arrived this near to the spot, in meters.
_ARRIVED = 0.1

# Someone less far beside the robot's course is on it, in meters.
_BESIDE = 0.1


@register_action("StandStill", ignored=IGNORED)
def stand_still(moment: Moment, *, turn_rate: TurnRate = TURN_RATE) -> None:
    """Stands still and turns to the robot, if there is one."""
    moment.command[Command.HOLD] = 1.0
    robot = moment.robot
    if robot is not None:
        face(moment, robot[X], robot[Y], turn_rate)
    moment.behavior_status = 1


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
        own[:] = [1.0, *_spot_aside(moment, robot, clearance)]
    state, command = moment.state, moment.command
    moment.behavior_status = 1
    if math.hypot(own[1] - state[X], own[2] - state[Y]) <= _ARRIVED:
        own[0] = 0.0
        command[Command.HOLD] = 1.0
        return Status.SUCCESS
    command[Command.GOAL_X] = own[1]
    command[Command.GOAL_Y] = own[2]
    command[Command.GOAL_RADIUS] = _ARRIVED / 2
    command[Command.HAS_GOAL] = 1.0
    return Status.RUNNING


def _spot_aside(
    moment: Moment, robot: Row, clearance: float
) -> tuple[float, float]:
    """Returns the point to step aside to, in W, in meters."""
    state = moment.state
    x, y = state[X], state[Y]
    speed = math.hypot(robot[VX], robot[VY])
    if speed < SLOW:
        hx, hy = math.cos(robot[YAW]), math.sin(robot[YAW])
    else:
        hx, hy = robot[VX] / speed, robot[VY] / speed
    # The left of the robot: the right of someone who faces it.
    nx, ny = -hy, hx
    beside = (x - robot[X]) * nx + (y - robot[Y]) * ny
    first = -1.0 if beside < -_BESIDE else 1.0
    steps = []
    for side in (first, -first):
        way = max(clearance - side * beside, 0.0)
        gap = state[RADIUS] + _WALL_GAP
        reach = way + gap
        free = reach * moment.clear_part(
            x + side * reach * nx, y + side * reach * ny
        )
        step = min(way, max(free - gap, 0.0))
        steps.append((side * beside + step, side * step))
        if step == way:
            # There is all the room that it takes.
            break
    # How far beside the course each side leads; the first wins a draw.
    _, step = max(steps, key=lambda item: item[0])
    return x + step * nx, y + step * ny
