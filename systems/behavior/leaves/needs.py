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
from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.schema import within


@register_condition("NeedBelow", ignored=IGNORED, social=True)
@jit
def need_below(
    tick: Tick, need: NeedName, level: Annotated[float, within(0, 100)] = 30.0
) -> bool:
    """Holds if the level of a need of the person is below `level`."""
    return bool(numbers_at(tick.memory)[np.int64(need)] < level)


@register_condition("TimeOfTrial", ignored=IGNORED, social=True)
@jit
def time_of_trial(tick: Tick, start: Seconds = 0.0, end: Seconds = 1e9) -> bool:
    """Holds from the time `start` of the trial to `end`, in whole steps."""
    ticks = ticks_of(tick)
    has_begun = steps_reach(ticks, tick.time_step, start)
    return bool(has_begun and not steps_reach(ticks, tick.time_step, end))
