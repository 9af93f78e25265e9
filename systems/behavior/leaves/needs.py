"""Conditions of what people do by need and by the clock."""

from typing import Annotated

import numpy as np

from hunav_drake.systems.behavior.leaves.social_ports import NeedName, Seconds
from hunav_drake.systems.behavior.leaves.walking import IGNORED
from hunav_drake.systems.behavior.nodes.control_flow import steps_reach
from hunav_drake.systems.behavior.nodes.pointers import numbers_at
from hunav_drake.systems.behavior.nodes.registry import register_condition
from hunav_drake.systems.behavior.nodes.social import ticks_of
from hunav_drake.systems.behavior.nodes.tick import Tick
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.schema import within

# The last tick of a condition that holds for ever.
_EXPIRED = -3.0


@register_condition("NeedBelow", ignored=IGNORED, social=True)
@jit
def need_below(
    tick: Tick, need: NeedName, level: Annotated[float, within(0, 100)] = 30.0
) -> bool:
    """Holds if the level of a need of the person is below `level`."""
    return bool(numbers_at(tick.memory)[np.int64(need)] < level)


@register_condition(
    "HasRunFor",
    memory={"begin": 0.0, "last": -2.0},
    ignored=IGNORED,
    social=True,
)
@jit
def has_run_for(
    tick: Tick, own: Array, seconds: Seconds = 0.0, only_once: bool = False
) -> bool:
    """Holds after it has been ticked for `seconds`, until a tick without it.

    With `only_once` it holds for ever after; with 0 seconds it never holds.
    """
    ticks = ticks_of(tick)
    if only_once and own[1] == _EXPIRED:
        return True
    if ticks - own[1] > 1:
        own[0] = ticks
    own[1] = ticks
    lasted = ticks - own[0]
    expired = seconds > 0 and steps_reach(lasted, tick.time_step, seconds)
    if only_once and expired:
        own[1] = _EXPIRED
    return bool(expired)


@register_condition("TimeOfTrial", ignored=IGNORED, social=True)
@jit
def time_of_trial(tick: Tick, start: Seconds = 0.0, end: Seconds = 1e9) -> bool:
    """Holds from the time `start` of the trial to `end`, in whole steps."""
    ticks = ticks_of(tick)
    has_begun = steps_reach(ticks, tick.time_step, start)
    return bool(has_begun and not steps_reach(ticks, tick.time_step, end))
