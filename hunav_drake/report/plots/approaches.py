"""Approaches: periods in which a person is near the robot."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.evaluation.metrics.proxemics import PERSONAL
from hunav_drake.systems.evaluation.recording import Recording

# A person nearer than this is in the personal or intimate zone of the robot, in
# meters.
NEAR = PERSONAL


@dataclass(frozen=True, kw_only=True)
class Approach:
    """A period in which one person is near the robot.

    Attributes:
        person: The index of the person.
        start: The time of the first sample with the person near, in seconds.
        end: The time of the last such sample, in seconds.
        time: The time when the person is nearest, in seconds.
        gap: The gap at that time, surface to surface, in meters.
    """

    person: int
    start: float
    end: float
    time: float
    gap: float


def find_approaches(
    recording: Recording, *, near: float = NEAR
) -> list[Approach]:
    """Returns the approaches of each person, ordered by start.

    Args:
        recording: The recording of a trial.
        near: The gap, surface to surface, below which a person is near, in
            meters.

    Raises:
        ValueError: If `near` is not positive.
    """
    if not near > 0:
        raise ValueError(f"near must be positive, got {near}")
    times, gaps = recording.times, recording.features.gaps
    found = []
    for person in range(recording.num_humans):
        for first, last in runs_of(gaps[:, person] < near):
            closest = first + int(np.argmin(gaps[first : last + 1, person]))
            found.append(
                Approach(
                    person=person,
                    start=float(times[first]),
                    end=float(times[last]),
                    time=float(times[closest]),
                    gap=float(gaps[closest, person]),
                )
            )
    return sorted(found, key=lambda e: (e.start, e.person))


def runs_of(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Returns the first and last index of each unbroken run of true values."""
    edges = np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8))
    first, after = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return list(zip(first.tolist(), (after - 1).tolist(), strict=True))


def spans(
    recording: Recording, flags: NDArray[np.bool_]
) -> list[tuple[float, float]]:
    """Returns the periods in which flags are true: (start, end) in seconds.

    A sample covers the time until the next one; the last sample is as long as
    the one before it.
    """
    times = recording.times
    last_interval = times[-1] - times[-2] if len(times) > 1 else 0.0
    ends = np.append(times[1:], times[-1] + last_interval)
    return [(float(times[i]), float(ends[j])) for i, j in runs_of(flags)]
