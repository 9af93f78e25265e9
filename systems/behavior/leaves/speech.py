"""Speaking, and hearing others speak: SaySomething, IsAnyoneSpeaking, ..."""

import math

from hunav_drake.systems.behavior.leaves.others import distance_between
from hunav_drake.systems.behavior.leaves.robot_conditions import Distance
from hunav_drake.systems.behavior.leaves.social_ports import (
    NO_RESULT,
    NOBODY,
    PersonNumber,
    Result,
    Seconds,
)
from hunav_drake.systems.behavior.leaves.walking import IGNORED
from hunav_drake.systems.behavior.nodes.control_flow import (
    steps_of,
    steps_reach,
)
from hunav_drake.systems.behavior.nodes.registry import register_action
from hunav_drake.systems.behavior.nodes.social import (
    body_at,
    comes_first,
    give_result,
    notice,
    num_bodies,
    number_of,
    row_of,
    say,
    signal_of,
    social_memory,
)
from hunav_drake.systems.behavior.nodes.status import (
    FAILURE,
    RUNNING,
    SUCCESS,
    NodeStatus,
)
from hunav_drake.systems.behavior.nodes.texts import WORDS
from hunav_drake.systems.behavior.nodes.tick import Tick
from hunav_drake.systems.behavior.nodes.tick_context import TICKS_LEFT
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.kernels import jit, jit_part
from hunav_drake.systems.common.layout import Signal

# The time of a word, and the least of an utterance, in seconds.
_WORD, _LEAST = 0.4, 1.0

_SAID = int(Signal.UTTERANCE)


@register_action(
    "SaySomething", memory={"has said": 0.0}, ignored=IGNORED, social=True
)
@jit
def say_something(
    tick: Tick,
    own: Array,
    message: str,
    to: PersonNumber = NOBODY,
    duration: Seconds = 0.0,
    wait: bool = False,
) -> NodeStatus:
    """Says a text, to one person or to all.

    It lasts `duration`, by default 0.4 s a word and at least 1 s; another text
    replaces it. The person walks on meanwhile. With `wait`, it runs until the
    text is said. It fails if the person to hear it is not there.
    """
    if own[0] == 0:
        if duration == 0:
            duration = max(_LEAST, _WORD * (float(message) % WORDS))
        addressee = row_of(tick, to) if to != NOBODY else -1
        if to != NOBODY and addressee < 0:
            return FAILURE
        say(tick, message, addressee, steps_of(duration, tick.time_step))
        own[0] = 1.0
    if wait != 0 and social_memory(tick)[TICKS_LEFT] > 0:
        return RUNNING
    own[0] = 0.0
    return SUCCESS


@jit_part
def _wait(tick, own, duration):
    """Returns whether to wait on, or to fail: once `duration` has passed."""
    own[0] += 1
    if steps_reach(own[0], tick.time_step, duration):
        own[0] = 0.0
        return FAILURE
    return RUNNING


@jit_part
def _hears(tick, index, distance):
    """Returns the distance of a body that speaks near; else infinity."""
    if index == tick.index or signal_of(tick, index)[_SAID] == 0:
        return math.inf
    away = distance_between(tick, body_at(tick, index))
    return away if away <= distance else math.inf


@register_action(
    "IsAnyoneSpeaking", memory={"ticks": 0.0}, ignored=IGNORED, social=True
)
@jit
def is_anyone_speaking(
    tick: Tick,
    own: Array,
    distance_threshold: Distance = 5.0,
    duration: Seconds = 5.0,
    speaker_id: Result = NO_RESULT,
) -> NodeStatus:
    """Waits until somebody speaks near; fails after `duration`.

    The entry of `speaker_id` gets the number of the nearest; if it is a robot,
    -1, and that robot is noticed. The person walks on meanwhile.
    """
    found, nearest = -1, math.inf
    for i in range(num_bodies(tick)):
        away = _hears(tick, i, distance_threshold)
        if comes_first(tick, i, away, found, nearest):
            found, nearest = i, away
    if found < 0:
        status: NodeStatus = _wait(tick, own, duration)
        return status
    own[0] = 0.0
    notice(tick, found)
    give_result(tick, speaker_id, number_of(tick, found))
    return SUCCESS


@register_action(
    "IsSpeaking", memory={"ticks": 0.0}, ignored=IGNORED, social=True
)
@jit
def is_speaking(
    tick: Tick,
    own: Array,
    target_id: PersonNumber,
    distance_threshold: Distance = 5.0,
    duration: Seconds = 10.0,
) -> NodeStatus:
    """Waits until a person speaks near; fails after `duration`.

    The person walks on meanwhile.
    """
    target = row_of(tick, target_id)
    if target < 0 or _hears(tick, target, distance_threshold) == math.inf:
        status: NodeStatus = _wait(tick, own, duration)
        return status
    own[0] = 0.0
    return SUCCESS
