"""Numbers of a run that only comparisons with the paper ask for."""

import math

import numpy as np

from hunav_drake.systems.common.layout import RADIUS, VX, VY, X, Y
from hunav_drake.systems.evaluation.recording import Recording

# What is within a person's personal space, in meters (Hall 1966).
_NEAR = 1.2


def extra_values(recording: Recording) -> dict[str, float]:
    """Returns further numbers of a recording, by name.

    "lowest_speed_near_people": the least speed of the robot while somebody's
    body is within 1.2 m of its own, in m/s. "cruising_speed": the median of
    how fast it came from one sample to the next, in m/s. "walked_per_person":
    the length of the path of a person, in meters, on average.
    "min_dist_to_person_1", ...: the least distance between the robot's body
    and each person's, in meters. What has no value is NaN.
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
