"""Numbers of a run that only comparisons with the paper need."""

import math

import numpy as np

from hunav_drake.systems.common.layout import RADIUS, VX, VY, X, Y
from hunav_drake.systems.evaluation.recording import Recording

# The personal space of a person, in meters (Hall 1966).
_NEAR = 1.2


def extra_values(recording: Recording) -> dict[str, float]:
    """Returns further numbers of a recording, by name; NaN for no value.

    "lowest_speed_near_people": the lowest speed of the robot while a person is
    within 1.2 m, from surface to surface, in m/s. "cruising_speed": the median
    speed of the robot between samples, in m/s. "walked_per_person": the mean
    length of a person's path, in meters. "min_dist_to_person_1", ...: the
    smallest distance between the surfaces of the robot and each person, in
    meters.
    """
    robot, people = recording.robot, recording.humans
    offsets = people[:, :, [X, Y]] - robot[:, None, [X, Y]]
    gaps = (
        np.hypot(offsets[..., 0], offsets[..., 1])
        - robot[:, None, RADIUS]
        - people[:, :, RADIUS]
    )
    speeds = np.hypot(robot[:, VX], robot[:, VY])
    way = np.hypot(*np.diff(robot[:, [X, Y]], axis=0).T)
    paces = way / np.diff(recording.times)
    near = (gaps < _NEAR).any(axis=1)
    steps = np.diff(people[:, :, [X, Y]], axis=0)
    walked = np.nansum(np.hypot(steps[..., 0], steps[..., 1]), axis=0)
    values = {
        "cruising_speed": np.median(paces) if len(paces) else None,
        "lowest_speed_near_people": speeds[near].min() if near.any() else None,
        "walked_per_person": walked.mean() if walked.size else None,
    }
    for i, gap in enumerate(gaps.T, start=1):
        present = gap[np.isfinite(gap)]
        values[f"min_dist_to_person_{i}"] = (
            max(float(present.min()), 0.0) if present.size else None
        )
    return {k: math.nan if v is None else float(v) for k, v in values.items()}
