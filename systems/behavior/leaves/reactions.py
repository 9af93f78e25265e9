"""Actions that react to a robot: SurprisedNav, ScaredNav, CuriousNav, ...

Their default values are HuNavSim's. With several robots, people react to the
one that an earlier condition has noticed, or else to the nearest. The actions
fail if there is no robot.
"""

import math
from typing import Annotated

from hunav_drake.systems.behavior.leaves.pacing import (
    Deceleration,
    PortDistance,
    PortSpeed,
    PositiveDistance,
    TurnRate,
    come_to_rest,
    face,
    head_for,
    walk_at,
)
from hunav_drake.systems.behavior.leaves.walking import IGNORED, ROLES, Role
from hunav_drake.systems.behavior.nodes.registry import register_action
from hunav_drake.systems.behavior.nodes.status import NodeStatus
from hunav_drake.systems.behavior.nodes.tick_context import TickContext
from hunav_drake.systems.common.layout import RADIUS, YAW, Command, X, Y
from hunav_drake.systems.common.schema import within

# The rate at which people turn to the robot, in rad/s.
TURN_RATE = math.pi


@register_action("SurprisedNav", ignored=IGNORED)
def surprised_nav(
    context: TickContext,
    *,
    turn_rate: TurnRate = TURN_RATE,
    deceleration: Deceleration = 0.0,
) -> NodeStatus:
    """Stands still and turns to the robot.

    The person slows down by `deceleration` at most, or at once if it is 0.
    """
    robot = context.robot
    if robot is None:
        return NodeStatus.FAILURE
    come_to_rest(context, deceleration)
    face(context, robot[X], robot[Y], turn_rate)
    context.behavior_status = 1
    return NodeStatus.SUCCESS


@register_action("ScaredNav", ignored=IGNORED)
def scared_nav(
    context: TickContext,
    *,
    speed: PortSpeed = 0.6,
    push: Annotated[float, within(0, 1e4, "m/s^2")] = 20.0,
    push_range: PortDistance = 0.2,
    robot: Role = "unseen",
    deceleration: Deceleration = 0.0,
    own_maximum: bool = False,
) -> NodeStatus:
    """Walks on slowly, pushed away from the robot.

    The push is `push` times `push_range` over the distance from the body to
    the robot's center; that distance counts as 0.05 m at least. The person
    slows down by `deceleration` at most, or at once if it is 0. With
    `own_maximum`, a person whose own maximum is below `speed` does not exceed
    it; without, as in HuNavSim, fear makes such a person faster.
    """
    if context.robot is None:
        return NodeStatus.FAILURE
    command = context.command
    command[Command.ROBOT_ROLE] = ROLES[robot]
    command[Command.ROBOT_REPULSION] = push * push_range
    if own_maximum:
        speed = min(speed, command[Command.MAX_SPEED])
    walk_at(context, speed, deceleration)
    context.behavior_status = 1
    return NodeStatus.SUCCESS


@register_action("CuriousNav", ignored=IGNORED)
def curious_nav(
    context: TickContext,
    *,
    stop_distance: PortDistance = 1.5,
    speed: PortSpeed = 1.8,
    speed_distance: PositiveDistance = 10.0,
    turn_rate: TurnRate = TURN_RATE,
    robot: Role = "unseen",
    deceleration: Deceleration = 0.0,
) -> NodeStatus:
    """Walks to the robot, then stands before it and looks at it.

    The person comes at `speed` at the distance `speed_distance`, elsewhere in
    proportion to the distance, and never faster than the own maximum. It slows
    down by `deceleration` at most, as early as that demands, or stops at once
    if it is 0.
    """
    row = context.robot
    if row is None:
        return NodeStatus.FAILURE
    state, command = context.state, context.command
    distance = math.hypot(row[X] - state[X], row[Y] - state[Y])
    command[Command.ROBOT_ROLE] = ROLES[robot]
    if distance <= stop_distance:
        come_to_rest(context, deceleration)
        face(context, row[X], row[Y], turn_rate)
    else:
        approach = speed * (distance / speed_distance)
        approach = min(approach, command[Command.MAX_SPEED])
        if deceleration:
            left = distance - stop_distance
            approach = min(approach, math.sqrt(deceleration * left))
        head_for(context, row[X], row[Y], row[RADIUS])
        walk_at(context, approach, deceleration)
    context.behavior_status = 1
    return NodeStatus.SUCCESS


@register_action("ThreateningNav", ignored=IGNORED)
def threatening_nav(
    context: TickContext,
    *,
    goal_distance: PortDistance = 1.1,
    goal_radius: PortDistance = 0.05,
    speed: PortSpeed = 2.0,
    face_distance: PortDistance = 1.2,
    turn_rate: TurnRate = TURN_RATE,
    robot: Role = "unseen",
) -> NodeStatus:
    """Walks in front of the robot, straight, and looks at it from close by.

    The person walks at `speed`, which may be above the own maximum. This is
    HuNavSim's action, which leads through a robot that is on the way;
    BlockRobot leads around it.
    """
    row = context.robot
    if row is None:
        return NodeStatus.FAILURE
    state = context.state
    context.command[Command.ROBOT_ROLE] = ROLES[robot]
    x = row[X] + goal_distance * math.cos(row[YAW])
    y = row[Y] + goal_distance * math.sin(row[YAW])
    head_for(context, x, y, goal_radius)
    walk_at(context, speed)
    if math.hypot(row[X] - state[X], row[Y] - state[Y]) <= face_distance:
        face(context, row[X], row[Y], turn_rate)
    context.behavior_status = 1
    return NodeStatus.SUCCESS
