"""What recorded people have in common: groups, and room for bodies."""

import itertools

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.people.tracks import Tracks, motion_at

# People walk together who are, on average over the time when both are there,
# nearer than the distance, in meters, and whose velocities differ by less, in
# m/s; that time is at least the first one, in seconds, and this share of the
# shorter of both recordings. They are compared at the period, in seconds.
_NEAR = 1.5
_ALIKE = 0.3
_LEAST = 3.0
_SHARE = 0.5
_PERIOD = 0.4


def walking_groups(tracks: Tracks) -> list[int]:
    """Returns the number of each person's group, -1 for people alone.

    People are of one group who walk near each other and alike for some seconds,
    or are joined by others who do. Groups are 0, 1, ... in the order of their
    first people.
    """
    times, places, velocities = [], [], []
    for it in tracks.people:
        first = int(np.ceil(it.times[0] / _PERIOD - 1e-9))
        last = int(np.floor(it.times[-1] / _PERIOD + 1e-9))
        steps = np.arange(first, last + 1)
        motion = motion_at(it, steps * _PERIOD)
        times.append((first, last + 1))
        places.append(motion.positions)
        velocities.append(motion.velocities)
    root = list(range(len(times)))
    for i, k in itertools.combinations(range(len(times)), 2):
        first = max(times[i][0], times[k][0])
        end = min(times[i][1], times[k][1])
        shorter = min(times[i][1] - times[i][0], times[k][1] - times[k][0])
        if (end - first) * _PERIOD < max(_LEAST, _SHARE * shorter * _PERIOD):
            continue
        own = slice(first - times[i][0], end - times[i][0])
        others = slice(first - times[k][0], end - times[k][0])
        apart = np.hypot(*(places[i][own] - places[k][others]).T).mean()
        unlike = np.hypot(
            *(velocities[i][own] - velocities[k][others]).T
        ).mean()
        if apart < _NEAR and unlike < _ALIKE:
            old, new = root[k], root[i]
            root = [new if it == old else it for it in root]
    numbers: dict[int, int] = {}
    return [
        numbers.setdefault(it, len(numbers)) if root.count(it) > 1 else -1
        for it in root
    ]


def nearest_others(tracks: Tracks) -> dict[int, float]:
    """Returns the least distance of each person from any other, in meters.

    The keys are the numbers of people. It is infinite for people who are alone.
    """
    found = {it.id: np.inf for it in tracks.people}
    sampled = tracks.resampled(_PERIOD).people
    if not sampled:
        return found
    ids = np.repeat(
        [it.id for it in sampled], [len(it.times) for it in sampled]
    )
    steps = np.concatenate([np.round(it.times / _PERIOD) for it in sampled])
    places = np.concatenate([it.positions for it in sampled])
    order = np.argsort(steps, kind="stable")
    starts = np.flatnonzero(np.diff(steps[order])) + 1
    for rows in np.split(order, starts):
        dx, dy = (column[:, None] - column for column in places[rows].T)
        apart: Array = np.hypot(dx, dy)
        np.fill_diagonal(apart, np.inf)
        for person, away in zip(
            ids[rows].tolist(), apart.min(axis=1).tolist(), strict=True
        ):
            found[person] = min(found[person], away)
    return found
