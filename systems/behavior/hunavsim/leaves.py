"""HuNavSim's leaves, where they differ from those of this package.

With the profile "hunavsim", trees have these under HuNavSim's names. They
follow its functions `lineOfSight`, `updateGoal`, `lookAtTheRobot`,
`approximateRobot`, `avoidRobot` and `blockRobot`, and `SFM.updatePosition` of
`lightsfm`. Values in single precision there are in single precision here.
"""

from collections.abc import Callable, Mapping
import math
from types import MappingProxyType
from typing import Annotated, Any

import numpy as np

from hunav_drake.systems.behavior.leaves.pacing import head_for
from hunav_drake.systems.behavior.leaves.robot_conditions import FIELD_OF_VIEW
from hunav_drake.systems.behavior.leaves.walking import IGNORED, is_goal_reached
from hunav_drake.systems.behavior.nodes.compiled_leaf import CompiledLeaf
from hunav_drake.systems.behavior.nodes.node import Category, NodeType
from hunav_drake.systems.behavior.nodes.operations import AROUND, Operation
from hunav_drake.systems.behavior.nodes.registry import (
    NODE_TYPES,
    make_leaf_type,
)
from hunav_drake.systems.behavior.nodes.status import IDLE, NodeStatus
from hunav_drake.systems.behavior.nodes.tick import (
    Tick,
    goal_of,
    has_goal,
    next_goal,
)
from hunav_drake.systems.behavior.nodes.tick_context import Row, TickContext
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.layout import (
    RADIUS,
    YAW,
    Command,
    Hold,
    RobotRole,
    X,
    Y,
)
from hunav_drake.systems.common.poses import wrap_angle
from hunav_drake.systems.common.schema import within
from hunav_drake.systems.people.single_precision import (
    bearing,
    bearing_in_view,
    cosine,
    sine,
)

_Speed = Annotated[float, within(0, 10, "m/s")]
_Distance = Annotated[float, within(0, 1e5, "m")]
_PositiveDistance = Annotated[float, within(0, 1e5, "m", low_open=True)]


def _single(value: float) -> float:
    return float(np.float32(value))


# HuNavSim's largest turn rate, in rad/s.
_SINGLE_PI = _single(math.pi)


def _turn_at_once(context: TickContext, yaw: float) -> None:
    command = context.command
    command[Command.YAW_TARGET] = yaw
    command[Command.TURN_RATE] = 2 * math.pi / context.person.time_step


def _offset(context: TickContext, robot: Row) -> tuple[Any, Any]:
    """Returns the offset from the person to a robot, in single precision."""
    state = context.state
    dx = np.float32(robot[X]) - np.float32(state[X])
    dy = np.float32(robot[Y]) - np.float32(state[Y])
    return dx, dy


def _bearing(
    context: TickContext, robot: Row, *, rounded_yaw: bool = True
) -> float:
    """Returns the bearing of a robot from the heading, in [-pi, pi]."""
    dx, dy = _offset(context, robot)
    # (In single precision, pi is beyond pi.)
    yaw = wrap_angle(context.state[YAW])
    found: float = (
        bearing(dx, dy, yaw) if rounded_yaw else bearing_in_view(dx, dy, yaw)
    )
    return found


def _distance(context: TickContext, robot: Row) -> float:
    """Returns the distance to the robot, in single precision."""
    dx, dy = _offset(context, robot)
    return float(np.sqrt(dx * dx + dy * dy))


def _react(context: TickContext, speed: float | None = None) -> None:
    """Sets what all reactions share: the robot exerts no force."""
    command = context.command
    command[Command.ROBOT_ROLE] = float(RobotRole.UNSEEN_IN_TURN)
    context.behavior_status = 1
    if speed is None:
        command[Command.HOLD] = float(Hold.STAY)
    else:
        command[Command.DESIRED_SPEED] = speed
        command[Command.MAX_SPEED] = speed


def _is_robot_visible(
    context: TickContext,
    *,
    distance: _Distance,
    field_of_view: Annotated[
        float, within(0, 2 * math.pi, "rad")
    ] = FIELD_OF_VIEW,
    occlusion: bool = False,
) -> bool:
    """Holds if a robot is near and in view; the nearest is noticed."""
    found = []
    for i, robot in enumerate(context.robots):
        dx, dy = _offset(context, robot)
        if float(dx * dx + dy * dy) > distance * distance:
            continue
        if occlusion and not context.sees(robot[X], robot[Y]):
            continue
        bearing = _bearing(context, robot, rounded_yaw=False)
        if abs(bearing) <= field_of_view / 2:
            found.append((_distance(context, robot), i))
    if found:
        context.notice(min(found)[1])
    return bool(found)


def _is_goal_reached(context: TickContext) -> bool:
    """Holds within 0.1 m of the goal's radius, even if people stand there."""
    return is_goal_reached(context, shared=False)


def _update_goal(context: TickContext) -> NodeStatus:
    """Drops the first goal, and stands still for the step."""
    context.command[Command.HOLD] = float(Hold.STAY)
    return (
        NodeStatus.SUCCESS if context.go_to_next_goal() else NodeStatus.FAILURE
    )


def _surprised_nav(
    context: TickContext,
    *,
    turn: Annotated[float, within(0, math.pi, "rad")] = _SINGLE_PI * 0.01,
) -> NodeStatus:
    """Stops and turns by `turn` per step; overshoots a robot on the right."""
    robot = context.robot
    if robot is None:
        return NodeStatus.FAILURE
    bearing = _bearing(context, robot)
    _react(context)
    change = -turn if bearing < 0 else min(bearing, turn)
    _turn_at_once(context, context.state[YAW] + change)
    return NodeStatus.SUCCESS


def _scared_nav(
    context: TickContext,
    *,
    speed: _Speed = 0.6,
    push: Annotated[float, within(0, 1e4, "m/s^2")] = 20.0,
    push_range: _Distance = 0.2,
) -> NodeStatus:
    """Walks on slowly, pushed away from the robot."""
    if context.robot is None:
        return NodeStatus.FAILURE
    _react(context, speed)
    context.command[Command.ROBOT_REPULSION] = push * push_range
    return NodeStatus.SUCCESS


def _curious_nav(
    context: TickContext,
    *,
    stop_distance: _Distance = 1.5,
    speed: _Speed = 1.8,
    speed_distance: _PositiveDistance = 10.0,
) -> NodeStatus:
    """Walks to the robot without a speed limit, and turns to it on arrival."""
    robot = context.robot
    if robot is None:
        return NodeStatus.FAILURE
    distance = _distance(context, robot)
    if distance <= stop_distance:
        _react(context)
        _turn_at_once(context, context.state[YAW] + _bearing(context, robot))
    else:
        part = np.float32(distance) / np.float32(speed_distance)
        _react(context, speed * float(part))
        x, y = _single(robot[X]), _single(robot[Y])
        head_for(context, x, y, robot[RADIUS])
    return NodeStatus.SUCCESS


def _threatening_nav(
    context: TickContext,
    *,
    goal_distance: _Distance = 1.1,
    goal_radius: _Distance = 0.05,
    speed: _Speed = 2.0,
    face_distance: _Distance = 1.2,
) -> NodeStatus:
    """Walks beside the robot: sine and cosine of its heading are swapped."""
    robot = context.robot
    if robot is None:
        return NodeStatus.FAILURE
    yaw = _single(math.remainder(_single(robot[YAW]), 2 * math.pi))
    x = _single(robot[X]) + goal_distance * sine(yaw)
    y = _single(robot[Y]) + goal_distance * cosine(yaw)
    _react(context, speed)
    head_for(context, _single(x), _single(y), goal_radius)
    # The range within which the person looks at the robot after the step.
    context.command[Command.YAW_TARGET] = face_distance
    return NodeStatus.SUCCESS


@jit
def _follow_goals(tick: Tick, own: Array, status: float) -> int:
    """Drops goals as a step of HuNavSim's crowd does: before and after one.

    A step to the own goal that ends within its radius drops the goal; and the
    behavior status stays as it is in a step without a walk or a reaction.
    """
    if status == IDLE:
        if own[0] and has_goal(tick):
            x, y = goal_of(tick)
            if math.hypot(x - tick.x, y - tick.y) <= tick.reach:
                next_goal(tick)
        return 0
    walks = tick.hold == Hold.WALK
    own[0] = 0.0
    if walks and has_goal(tick):
        x, y = goal_of(tick)
        own[0] = tick.goal_x == x and tick.goal_y == y
    if not walks and not tick.behavior_status:
        tick.behavior_status = own[1]
    own[1] = tick.behavior_status
    return 0


def _leaf(
    name: str, function: Callable[..., Any], category: Category = "Action"
) -> tuple[str, NodeType]:
    ignored = frozenset(IGNORED)
    return name, make_leaf_type(name, category, function, {}, ignored)


# All node types of the profile, by name.
HUNAVSIM_NODE_TYPES: Mapping[str, NodeType] = MappingProxyType(
    {
        **dict(
            [
                _leaf("IsGoalReached", _is_goal_reached, "Condition"),
                _leaf("IsRobotVisible", _is_robot_visible, "Condition"),
                _leaf("UpdateGoal", _update_goal),
                _leaf("SurprisedNav", _surprised_nav),
                _leaf("ScaredNav", _scared_nav),
                _leaf("CuriousNav", _curious_nav),
                _leaf("ThreateningNav", _threatening_nav),
            ]
        ),
        "FollowGoals": NodeType(
            "FollowGoals",
            "Decorator",
            Operation(AROUND),
            "Drops goals as a step of the crowd does in HuNavSim.",
            children=(1, 1),
            slots={"walked": 0.0, "status": 0.0},
            kept=("walked", "status"),
            leaf=CompiledLeaf(_follow_goals, 1, True),
        ),
    }
)


def hunavsim_node_types() -> dict[str, NodeType]:
    """Returns all node types, those of HuNavSim in place of ours."""
    return {**NODE_TYPES, **HUNAVSIM_NODE_TYPES}
