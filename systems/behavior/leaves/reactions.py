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
from hunav_drake.systems.behavior.nodes.status import (
    FAILURE,
    SUCCESS,
    NodeStatus,
)
from hunav_drake.systems.behavior.nodes.tick import Tick, robot_at, robot_of
from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.schema import within

# The rate at which people turn to the robot, in rad/s.
TURN_RATE = math.pi


@register_action("SurprisedNav", ignored=IGNORED)
@jit
def surprised_nav(
    tick: Tick,
    turn_rate: TurnRate = TURN_RATE,
    deceleration: Deceleration = 0.0,
) -> NodeStatus:
    """Stands still and turns to the robot.

    The person slows down by `deceleration` at most, or at once if it is 0.
    """
    index = robot_of(tick)
    if index < 0:
        return FAILURE
    it = robot_at(tick, index)
    come_to_rest(tick, deceleration)
    face(tick, it.x, it.y, turn_rate)
    tick.behavior_status = 1
    return SUCCESS


@register_action("ScaredNav", ignored=IGNORED)
@jit
def scared_nav(
    tick: Tick,
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
    if robot_of(tick) < 0:
        return FAILURE
    tick.robot_role = ROLES[int(robot)]
    tick.robot_repulsion = push * push_range
    if own_maximum:
        speed = min(speed, tick.max_speed)
    walk_at(tick, speed, deceleration)
    tick.behavior_status = 1
    return SUCCESS


@register_action("CuriousNav", ignored=IGNORED)
@jit
def curious_nav(
    tick: Tick,
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
    index = robot_of(tick)
    if index < 0:
        return FAILURE
    it = robot_at(tick, index)
    distance = math.hypot(it.x - tick.x, it.y - tick.y)
    tick.robot_role = ROLES[int(robot)]
    if distance <= stop_distance:
        come_to_rest(tick, deceleration)
        face(tick, it.x, it.y, turn_rate)
    else:
        approach = speed * (distance / speed_distance)
        approach = min(approach, tick.max_speed)
        if deceleration:
            left = distance - stop_distance
            approach = min(approach, math.sqrt(deceleration * left))
        head_for(tick, it.x, it.y, it.radius)
        walk_at(tick, approach, deceleration)
    tick.behavior_status = 1
    return SUCCESS


@register_action("ThreateningNav", ignored=IGNORED)
@jit
def threatening_nav(
    tick: Tick,
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
    index = robot_of(tick)
    if index < 0:
        return FAILURE
    it = robot_at(tick, index)
    tick.robot_role = ROLES[int(robot)]
    x = it.x + goal_distance * math.cos(it.yaw)
    y = it.y + goal_distance * math.sin(it.yaw)
    head_for(tick, x, y, goal_radius)
    walk_at(tick, speed, 0.0)
    if math.hypot(it.x - tick.x, it.y - tick.y) <= face_distance:
        face(tick, it.x, it.y, turn_rate)
    tick.behavior_status = 1
    return SUCCESS
