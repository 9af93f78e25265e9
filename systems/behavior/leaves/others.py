"""Conditions about other people and places, and of chance: IsAgentClose, ..."""

import math
from typing import Annotated

from hunav_drake.systems.behavior.leaves.pacing import wrapped
from hunav_drake.systems.behavior.leaves.robot_conditions import (
    FIELD_OF_VIEW,
    Distance,
)
from hunav_drake.systems.behavior.leaves.social_ports import (
    NO_RESULT,
    NOBODY,
    PersonNumber,
    PlaceName,
    Result,
    Seconds,
)
from hunav_drake.systems.behavior.leaves.walking import IGNORED
from hunav_drake.systems.behavior.nodes.control_flow import steps_of
from hunav_drake.systems.behavior.nodes.registry import (
    register_action,
    register_condition,
)
from hunav_drake.systems.behavior.nodes.social import (
    CHANCE,
    comes_first,
    draw,
    give_result,
    is_clear,
    number_of,
    place_of,
    pose_of,
    row_of,
)
from hunav_drake.systems.behavior.nodes.status import (
    FAILURE,
    SUCCESS,
    NodeStatus,
)
from hunav_drake.systems.behavior.nodes.tick import (
    Tick,
    human_at,
    robot_at,
    way_to,
)
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit, jit_part
from hunav_drake.systems.common.schema import within

# The attributes without effect of leaves for which `agent_id` has one.
_OTHERS = tuple(it for it in IGNORED if it != "agent_id")


@jit_part
def observer(tick, number):
    """Returns the row of an observer: of oneself for `NOBODY`, or -1."""
    return tick.index if number == NOBODY else row_of(tick, number)


@jit_part
def distance_between(one, other):
    """Returns the distance between the centers of two bodies, in meters."""
    return math.hypot(other.x - one.x, other.y - one.y)


@jit_part
def is_in_view(one, other, distance, field_of_view):
    """Returns whether a body is near, and in the field of view of another."""
    if distance_between(one, other) > distance:
        return False
    bearing = math.atan2(other.y - one.y, other.x - one.x)
    return abs(wrapped(bearing - one.yaw)) <= field_of_view / 2


@register_condition("IsAgentVisible", ignored=_OTHERS, social=True)
@jit
def is_agent_visible(
    tick: Tick,
    agent_id: PersonNumber,
    observer_id: PersonNumber = NOBODY,
    distance: Distance = 5.0,
    field_of_view: Annotated[
        float, within(0, 2 * math.pi, "rad")
    ] = FIELD_OF_VIEW,
    occlusion: bool = True,
) -> bool:
    """Holds if a person is near, in view, and not behind a wall.

    The observer is the person itself, or the one of `observer_id`.
    """
    own, other = observer(tick, observer_id), row_of(tick, agent_id)
    if own < 0 or other < 0:
        return False
    one, it = human_at(tick, own), human_at(tick, other)
    if not is_in_view(one, it, distance, field_of_view):
        return False
    return occlusion == 0 or is_clear(tick, one, it)


@register_condition("IsAgentClose", ignored=IGNORED, social=True)
@jit
def is_agent_close(
    tick: Tick,
    target_agent_id: PersonNumber,
    observer_id: PersonNumber = NOBODY,
    threshold: Distance = 1.0,
) -> bool:
    """Holds if the center of a person is nearer than `threshold`.

    The observer is the person itself, or the one of `observer_id`.
    """
    own, other = observer(tick, observer_id), row_of(tick, target_agent_id)
    if own < 0 or other < 0:
        return False
    away = distance_between(human_at(tick, own), human_at(tick, other))
    return bool(away < threshold)


@register_condition("IsRobotCloseTo", ignored=IGNORED, social=True)
@jit
def is_robot_close_to(
    tick: Tick, target_agent_id: PersonNumber, threshold: Distance = 1.0
) -> bool:
    """Holds if a robot is nearer than `threshold` to another person.

    It notices the nearest such robot.
    """
    other = row_of(tick, target_agent_id)
    if other < 0:
        return False
    nearest = threshold
    for i in range(tick.num_robots):
        away = distance_between(human_at(tick, other), robot_at(tick, i))
        if away < nearest:
            nearest = away
            tick.noticed = i
    return bool(nearest < threshold)


@register_condition("IsAtPosition", ignored=IGNORED, social=True)
@jit
def is_at_position(
    tick: Tick, goal_id: PlaceName, tolerance: Distance = 0.1
) -> bool:
    """Holds if the person is at most `tolerance` away from a place.

    Who stands beside a seat is there, as who sits on it.
    """
    place = place_of(tick, goal_id)
    if place < 0:
        return False
    x, y, _ = pose_of(tick, place)
    wx, wy = way_to(tick, place)
    away = math.hypot(x - tick.x, y - tick.y)
    beside = math.hypot(wx - tick.x, wy - tick.y)
    return bool(min(away, beside) <= tolerance)


@register_action("FindNearestAgent", ignored=IGNORED, social=True)
@jit
def find_nearest_agent(
    tick: Tick,
    max_distance: Distance = 1e5,
    visible: bool = False,
    target_agent_id: Result = NO_RESULT,
) -> NodeStatus:
    """Finds the nearest other person; fails if there is none.

    The entry of `target_agent_id` gets the number. With `visible`, people
    count that are in view and not behind a wall.
    """
    found, nearest = -1, math.inf
    for i in range(tick.num_humans):
        it = human_at(tick, i)
        away = distance_between(tick, it)
        if i == tick.index or away > max_distance:
            continue
        if not comes_first(tick, i, away, found, nearest):
            continue
        if visible != 0 and not (
            is_in_view(tick, it, max_distance, FIELD_OF_VIEW)
            and is_clear(tick, tick, it)
        ):
            continue
        found, nearest = i, away
    if found < 0:
        return FAILURE
    give_result(tick, target_agent_id, number_of(tick, found))
    return SUCCESS


@register_condition(
    "RandomChanceCondition",
    memory={"holds": 0.0, "ticks left": 0.0},
    ignored=IGNORED,
    social=True,
)
@jit
def random_chance(
    tick: Tick,
    own: Array,
    probability: Annotated[float, within(0, 1)] = 0.3,
    period: Seconds = 0.0,
) -> bool:
    """Holds with a probability, in each tick or for each `period`."""
    if period == 0:
        return bool(draw(tick, CHANCE) < probability)
    if own[1] > 0:
        own[1] -= 1
        return bool(own[0] != 0)
    own[0] = 1.0 if draw(tick, CHANCE) < probability else 0.0
    own[1] = steps_of(period, tick.time_step) - 1
    return bool(own[0] != 0)
