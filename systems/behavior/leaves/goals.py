"""Making places goals: SetGoal, SetRandomGoal."""

import math
from typing import Literal

from hunav_drake.systems.behavior.leaves.social_ports import PlaceName
from hunav_drake.systems.behavior.leaves.walking import GOAL_MARGIN, IGNORED
from hunav_drake.systems.behavior.nodes.pointers import numbers_at
from hunav_drake.systems.behavior.nodes.registry import register_action
from hunav_drake.systems.behavior.nodes.social import CHOICE, draw, place_of
from hunav_drake.systems.behavior.nodes.status import (
    FAILURE,
    SUCCESS,
    NodeStatus,
)
from hunav_drake.systems.behavior.nodes.tick import (
    Tick,
    aim,
    has_goal,
    place_at,
    way_to,
)
from hunav_drake.systems.behavior.nodes.tick_context import (
    LATER_PLACES,
    MAX_PLACES,
)
from hunav_drake.systems.common.kernels import jit, jit_part
from hunav_drake.systems.people.places import PlaceType

Mode = Literal["append", "next", "replace"]
_NEXT, _REPLACE = 1, 2


@register_action("SetGoal", ignored=IGNORED, social=True)
@jit
def set_goal(
    tick: Tick, goal_id: PlaceName, mode: Mode = "append"
) -> NodeStatus:
    """Makes a place a goal: the last one, the next one, or the only one.

    The person walks there once. The action fails if 16 places are to come.
    """
    place = place_of(tick, goal_id) + 1
    status: NodeStatus = FAILURE
    if place > 0:
        status = _make_goal(tick, place, int(mode))
    return status


@jit_part
def _make_goal(tick, place, mode):
    """Makes a place, 1 + its row, a goal; returns whether there is room."""
    later = numbers_at(tick.social + 8 * LATER_PLACES)
    if mode == _REPLACE:
        for i in range(MAX_PLACES):
            later[i] = 0.0
        tick.goal = tick.num_goals
        tick.goal_place = 0
    if not has_goal(tick):
        tick.goal_place = place
        aim(tick)
        return SUCCESS
    if later[MAX_PLACES - 1] != 0:
        return FAILURE
    at = 0
    if mode == _NEXT:
        for i in range(MAX_PLACES - 1, 0, -1):
            later[i] = later[i - 1]
    else:
        place = -place
        while later[at] != 0:
            at += 1
    later[at] = place
    return SUCCESS


@register_action("SetRandomGoal", ignored=IGNORED, social=True)
@jit
def set_random_goal(
    tick: Tick, kind: PlaceType = "point", mode: Mode = "replace"
) -> NodeStatus:
    """Makes a place a goal that is drawn among those of a type.

    It is neither the present goal nor where the person is; the action fails if
    there is none. The modes are those of `SetGoal`.
    """
    count = 0
    for p in range(tick.num_places):
        count += _may_be_drawn(tick, p, int(kind))
    status: NodeStatus = FAILURE
    left = int(draw(tick, CHOICE) * count)
    for p in range(tick.num_places):
        if _may_be_drawn(tick, p, int(kind)):
            if left == 0:
                status = _make_goal(tick, p + 1, int(mode))
            left -= 1
    return status


@jit_part
def _may_be_drawn(tick, place, kind):
    """Returns whether a place is another one, and of a type."""
    row = place_at(tick, place)
    x, y = way_to(tick, place)
    away = math.hypot(x - tick.x, y - tick.y)
    is_another = tick.goal_place != place + 1
    return is_another and row[7] == kind and away > tick.reach + GOAL_MARGIN
