"""The episodes of a situation, and what robot and people did in them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.situation_labels import MOVING, course

# Shorter gaps in an episode are closed, and shorter ones dropped, in seconds;
# times have rounding errors.
_GAP, _LEAST, _ROUNDING = 1.0, 0.5, 1e-9

# Who slows by more than this part of the speed gives way.
_SLOWED = 0.2


def edges_of(times: Array) -> Array:
    """Returns the times between which each sample counts, shape (N + 2,).

    A sample counts from the middle of the interval before it to that of the one
    after it.
    """
    middles = (times[1:] + times[:-1]) / 2
    return np.concatenate([times[:1], middles, times[-1:]])


def spans_of(flag: Mask, edges: Array) -> NDArray[np.int64]:
    """Returns the first sample of each episode and the one after it, (k, 2).

    Gaps of less than 1 s are closed; then, episodes of less than 0.5 s are
    dropped.

    Args:
        flag: Whether the situation holds at each sample, shape (N + 1,).
        edges: See `edges_of`.
    """
    change = np.diff(flag.astype(int), prepend=0, append=0)
    first, after = np.flatnonzero(change > 0), np.flatnonzero(change < 0)
    parts = edges[first[1:]] - edges[after[:-1]] >= _GAP - _ROUNDING
    spans = np.column_stack(
        [
            np.concatenate([first[:1], first[1:][parts]]),
            np.concatenate([after[:-1][parts], after[-1:]]),
        ]
    )
    length = edges[spans[:, 1]] - edges[spans[:, 0]]
    long: NDArray[np.int64] = spans[length >= _LEAST - _ROUNDING]
    return long


def time_lost(recording: Recording, edges: Array, empty: Mask) -> Array:
    """Returns the time that the robot has lost until each of the edges.

    That is the time since the start without what the way until then takes at
    the median speed of the robot while it moves and nobody is near; NaN if it
    never does.

    Args:
        recording: The recording of one robot.
        edges: See `edges_of`.
        empty: Whether nobody is near, shape (N + 1,).
    """
    speed = course(recording)[1][:, 0]
    free = speed[empty & (speed >= MOVING)]
    if not free.size:
        return np.full(len(edges), np.nan)
    way = np.concatenate([[0.0], np.cumsum(recording.features.step_lengths)])
    lost: Array = edges - np.interp(edges, recording.times, way) / np.median(
        free
    )
    return lost


def describe_episode(
    recording: Recording, first: int, after: int, made: Mask
) -> dict[str, Any]:
    """Returns what robot and people did in an episode.

    "least_gap" is the smallest gap between the robot and those who make the
    episode, in meters. "slowed" tells who lost more than 20 % of the speed from
    the begin to the nearest point, the least distance of centers to one of
    them: "robot", "person", "robot, person", or "" for nobody. "side" tells
    whether that person then is "left" or "right" of the robot's course. If
    nobody makes the episode, the first is NaN and the others are empty.

    Args:
        recording: The recording of one robot.
        first: The first sample.
        after: The sample after the last one.
        made: Who makes it, shape (after - first, n).
    """
    if not made.any():
        return {"least_gap": np.nan, "slowed": "", "side": ""}
    part = slice(first, after)
    distance = np.where(made, recording.encounters.distance[part], np.inf)
    k, i = np.unravel_index(distance.argmin(), distance.shape)
    until = slice(first, first + int(k) + 1)
    (cx, cy), speed = course(recording)
    speeds = {
        "robot": speed[until, 0],
        "person": recording.features.human_speed[until, i],
    }
    px, py = (it[first + k, i] for it in recording.encounters.offset)
    left = cx[first + k, 0] * py - cy[first + k, 0] * px > 0
    return {
        "least_gap": float(recording.features.gaps[part][made].min()),
        "slowed": ", ".join(it for it, v in speeds.items() if _slows(v)),
        "side": "left" if left else "right",
    }


def _slows(speed: Array) -> bool:
    """Returns whether a moving body loses speed; NaN if it is missing."""
    best = np.fmax.accumulate(speed)
    return bool(np.any((best >= MOVING) & (speed < (1 - _SLOWED) * best)))
