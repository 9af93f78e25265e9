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

from numba import float32, float64
import numpy as np

from hunav_drake.systems.behavior.leaves.pacing import head_for, wrapped
from hunav_drake.systems.behavior.leaves.robot_conditions import FIELD_OF_VIEW
from hunav_drake.systems.behavior.leaves.walking import GOAL_MARGIN, IGNORED
from hunav_drake.systems.behavior.nodes.compiled_leaf import CompiledLeaf
from hunav_drake.systems.behavior.nodes.node import Category, NodeType
from hunav_drake.systems.behavior.nodes.operations import AROUND, Operation
from hunav_drake.systems.behavior.nodes.registry import (
    NODE_TYPES,
    make_leaf_type,
)
from hunav_drake.systems.behavior.nodes.status import (
    FAILURE,
    IDLE,
    SUCCESS,
    NodeStatus,
)
from hunav_drake.systems.behavior.nodes.tick import (
    Tick,
    goal_of,
    has_goal,
    next_goal,
    robot_at,
    robot_of,
    sees,
)
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit, jit_part
from hunav_drake.systems.common.layout import Hold, RobotRole
from hunav_drake.systems.common.schema import within
from hunav_drake.systems.people.single_precision import (
    bearing,
    bearing_in_view,
    cosine,
    sine,
)

# The status of the child before it is ticked.
_BEFORE = float(IDLE)

_UNSEEN_IN_TURN = float(RobotRole.UNSEEN_IN_TURN)
_STAY = float(Hold.STAY)

_Speed = Annotated[float, within(0, 10, "m/s")]
_Distance = Annotated[float, within(0, 1e5, "m")]
_PositiveDistance = Annotated[float, within(0, 1e5, "m", low_open=True)]


@jit_part
def _single(value):
    """Returns a number in single precision."""
    return float64(float32(value))


# HuNavSim's largest turn rate, in rad/s.
_SINGLE_PI = float(np.float32(math.pi))


@jit_part
def _turn_at_once(tick, yaw):
    tick.yaw_target = yaw
    tick.turn_rate = 2 * math.pi / tick.time_step


@jit_part
def _offset(tick, robot):
    """Returns the offset from the person to a robot, in single precision."""
    dx = float32(robot.x) - float32(tick.x)
    dy = float32(robot.y) - float32(tick.y)
    return dx, dy


@jit_part
def _yaw(tick):
    """Returns the heading of the person in (-pi, pi], in radians."""
    # (In single precision, pi is beyond pi.)
    yaw = wrapped(tick.yaw)
    return math.pi if yaw == -math.pi else yaw


@jit_part
def _bearing(tick, robot):
    """Returns the bearing of a robot from the heading, in [-pi, pi]."""
    dx, dy = _offset(tick, robot)
    return float64(bearing(dx, dy, float32(_yaw(tick))))


@jit_part
def _distance(tick, robot):
    """Returns the distance to the robot, in single precision."""
    dx, dy = _offset(tick, robot)
    return float64(np.sqrt(dx * dx + dy * dy))


@jit_part
def _react(tick):
    """Sets what all reactions share: the robot exerts no force."""
    tick.robot_role = _UNSEEN_IN_TURN
    tick.behavior_status = 1


@jit_part
def _walk(tick, speed):
    tick.desired_speed = speed
    tick.max_speed = speed


@jit
def _is_robot_visible(
    tick: Tick,
    distance: _Distance,
    field_of_view: Annotated[
        float, within(0, 2 * math.pi, "rad")
    ] = FIELD_OF_VIEW,
    occlusion: bool = False,
) -> bool:
    """Holds if a robot is near and in view; the nearest is noticed."""
    nearest, found = math.inf, -1
    for i in range(tick.num_robots):
        robot = robot_at(tick, i)
        dx, dy = _offset(tick, robot)
        if float64(dx * dx + dy * dy) > distance * distance:
            continue
        if occlusion and not sees(tick, robot.x, robot.y):
            continue
        off = abs(float64(bearing_in_view(dx, dy, _yaw(tick))))
        if off <= field_of_view / 2 and _distance(tick, robot) < nearest:
            nearest, found = _distance(tick, robot), i
    if found >= 0:
        tick.noticed = found
    return found >= 0


@jit
def _is_goal_reached(tick: Tick) -> bool:
    """Holds within 0.1 m of the goal's radius, even if people stand there."""
    if not has_goal(tick):
        return False
    x, y = goal_of(tick)
    away = math.hypot(x - tick.x, y - tick.y)
    return bool(away <= tick.reach + GOAL_MARGIN)


@jit
def _update_goal(tick: Tick) -> NodeStatus:
    """Drops the first goal, and stands still for the step."""
    tick.hold = _STAY
    return SUCCESS if next_goal(tick) else FAILURE


@jit
def _surprised_nav(
    tick: Tick,
    turn: Annotated[float, within(0, math.pi, "rad")] = _SINGLE_PI * 0.01,
) -> NodeStatus:
    """Stops and turns by `turn` per step; overshoots a robot on the right."""
    index = robot_of(tick)
    if index < 0:
        return FAILURE
    left = _bearing(tick, robot_at(tick, index))
    _react(tick)
    tick.hold = _STAY
    _turn_at_once(tick, tick.yaw + (-turn if left < 0 else min(left, turn)))
    return SUCCESS


@jit
def _scared_nav(
    tick: Tick,
    speed: _Speed = 0.6,
    push: Annotated[float, within(0, 1e4, "m/s^2")] = 20.0,
    push_range: _Distance = 0.2,
) -> NodeStatus:
    """Walks on slowly, pushed away from the robot."""
    if robot_of(tick) < 0:
        return FAILURE
    _react(tick)
    _walk(tick, speed)
    tick.robot_repulsion = push * push_range
    return SUCCESS


@jit
def _curious_nav(
    tick: Tick,
    stop_distance: _Distance = 1.5,
    speed: _Speed = 1.8,
    speed_distance: _PositiveDistance = 10.0,
) -> NodeStatus:
    """Walks to the robot without a speed limit, and turns to it on arrival."""
    index = robot_of(tick)
    if index < 0:
        return FAILURE
    robot = robot_at(tick, index)
    distance = _distance(tick, robot)
    _react(tick)
    if distance <= stop_distance:
        tick.hold = _STAY
        _turn_at_once(tick, tick.yaw + _bearing(tick, robot))
    else:
        part = float32(distance) / float32(speed_distance)
        _walk(tick, speed * float64(part))
        head_for(tick, _single(robot.x), _single(robot.y), robot.radius)
    return SUCCESS


@jit
def _threatening_nav(
    tick: Tick,
    goal_distance: _Distance = 1.1,
    goal_radius: _Distance = 0.05,
    speed: _Speed = 2.0,
    face_distance: _Distance = 1.2,
) -> NodeStatus:
    """Walks beside the robot: sine and cosine of its heading are swapped."""
    index = robot_of(tick)
    if index < 0:
        return FAILURE
    robot = robot_at(tick, index)
    yaw = float32(wrapped(_single(robot.yaw)))
    x = _single(robot.x) + goal_distance * float64(sine(yaw))
    y = _single(robot.y) + goal_distance * float64(cosine(yaw))
    _react(tick)
    _walk(tick, speed)
    head_for(tick, _single(x), _single(y), goal_radius)
    # The range within which the person looks at the robot after the step.
    tick.yaw_target = face_distance
    return SUCCESS


@jit
def _follow_goals(tick: Tick, own: Array, status: float) -> int:
    """Drops goals as a step of HuNavSim's crowd does: before and after one.

    A step to the own goal that ends within its radius drops the goal; and the
    behavior status stays as it is in a step without a walk or a reaction.
    """
    if status == _BEFORE:
        if own[0] and has_goal(tick):
            x, y = goal_of(tick)
            if math.hypot(x - tick.x, y - tick.y) <= tick.reach:
                next_goal(tick)
        return 0
    walks = tick.hold == 0
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
