"""How several robots got along with each other."""

from functools import partial
import itertools

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import (
    CONTACT_GAP,
    CONTACT_PAUSE,
    RADIUS,
    VX,
    VY,
    X,
    Y,
)
from hunav_drake.systems.evaluation.metric import FLEET_FAMILY, register_metric
from hunav_drake.systems.evaluation.metrics import reduce
from hunav_drake.systems.evaluation.metrics.goal import time_to_reach_goal
from hunav_drake.systems.evaluation.recording import Recording

_metric = partial(register_metric, family=FLEET_FAMILY, direction="lower")

_STERN = "Stern et al., Multi-Agent Pathfinding, 2019"

# Robots below this speed stand, in m/s; for so long is a deadlock, in seconds.
_STANDS, _DEADLOCK = 0.05, 10.0


def _gaps(recording: Recording) -> Array:
    """Returns the gaps of each pair of robots, shape (pairs, N + 1), in m."""
    pairs = itertools.combinations((it.robot for it in recording.robots), 2)
    gaps = [
        np.hypot(a[:, X] - b[:, X], a[:, Y] - b[:, Y])
        - (a[:, RADIUS] + b[:, RADIUS])
        for a, b in pairs
    ]
    return np.array(gaps).reshape(-1, len(recording))


@register_metric(
    unit="m",
    family=FLEET_FAMILY,
    direction="higher",
    source="hunav_drake",
    reduce=np.fmin.reduce,
)
def min_dist_between_robots(recording: Recording) -> Array:
    """The smallest gap between the discs of two robots.

    NaN with one robot. Series: the smallest gap at that time.
    """
    gaps = _gaps(recording)
    if not len(gaps):
        return np.full(len(recording), np.nan)
    smallest: Array = gaps.min(axis=0)
    return smallest


@_metric(unit="-", source="hunav_drake")
def contacts_between_robots(recording: Recording) -> float:
    """The number of contacts of two robots.

    A contact begins with a gap below 2 cm between the discs of two robots, and
    ends once it has been larger for 0.25 s: see `layout.CONTACT_GAP`. NaN with
    one robot.
    """
    gaps = _gaps(recording)
    return float(sum(map(partial(_contacts, recording.times), gaps))) or (
        0.0 if len(gaps) else np.nan
    )


def _contacts(times: Array, gaps: Array) -> int:
    touches = np.flatnonzero(gaps < CONTACT_GAP)
    # (Samples may be farther apart than that.)
    begins = np.diff(touches, prepend=-2) > 1
    begins &= np.diff(times[touches], prepend=-np.inf) > CONTACT_PAUSE
    return int(np.count_nonzero(begins))


@_metric(unit="s", source="hunav_drake", reduce=reduce.last)
def deadlock_time(recording: Recording) -> Array:
    """The time for which all robots stood, none of them at its goal.

    Only times of at least 10 s count; robots without a goal do not. NaN with
    less than two. Series: the time until then.
    """
    robots = [it for it in recording.robots if it.goal is not None]
    if len(robots) < 2:
        return np.full(len(recording), np.nan)
    waits: Mask = np.all(
        [
            (np.hypot(it.robot[:, VX], it.robot[:, VY]) < _STANDS)
            & ~it.features.at_goal
            for it in robots
        ],
        axis=0,
    )
    times = recording.times
    total = np.zeros(len(times))
    # Each run of samples, as a first and a last one.
    edges = np.diff(waits.astype(int), prepend=0, append=0)
    for first, end in zip(
        np.flatnonzero(edges > 0), np.flatnonzero(edges < 0), strict=True
    ):
        if times[end - 1] - times[first] >= _DEADLOCK * (1 - 1e-9):
            total[first:end] += times[first:end] - times[first]
            total[end:] += times[end - 1] - times[first]
    return total


def _arrivals(recording: Recording) -> Array:
    """Returns the times to the goals of all robots that have one, in s.

    What happens after a robot's end does not count.
    """
    robots = [it for it in recording.robots if it.goal is not None]
    return np.array([time_to_reach_goal(it.until_end()) for it in robots])


@_metric(unit="s", source=_STERN)
def makespan(recording: Recording) -> float:
    """The time until the last robot reached its goal, max_i T_i.

    NaN unless all robots with a goal reached it.
    """
    times = _arrivals(recording)
    return float(times.max()) if len(times) else np.nan


@_metric(unit="s", source=_STERN)
def sum_of_costs(recording: Recording) -> float:
    """The sum of the times in which the robots reached their goals, sum_i T_i.

    NaN unless all robots with a goal reached it.
    """
    times = _arrivals(recording)
    return float(times.sum()) if len(times) else np.nan
