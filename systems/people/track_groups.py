"""Groups of recorded people, found by geometry."""

import itertools

import numpy as np

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
