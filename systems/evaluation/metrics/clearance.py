"""Clearance of the robot to walls.

Clearance is the gap between the surface of the robot's disc and the nearest
wall: 0 where they overlap, and inside a solid.
"""

from functools import partial

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.evaluation.features import CONTACT_GAP
from hunav_drake.systems.evaluation.metric import register_metric
from hunav_drake.systems.evaluation.metrics import reduce
from hunav_drake.systems.evaluation.metrics.efficiency import FRANCIS
from hunav_drake.systems.evaluation.metrics.goal import SEAN
from hunav_drake.systems.evaluation.recording import Recording

_metric = partial(register_metric, family="clearance")


@_metric(unit="m", direction="higher", source=FRANCIS)
def min_clearance(recording: Recording) -> float:
    """The smallest gap to a wall, min_k c_k; NaN without walls.

    It is 0 where the robot's disc overlaps a wall, or its center is inside a
    solid.
    """
    return float(np.fmin.reduce(recording.path_features.wall_gap))


@_metric(unit="m", direction="higher", source=FRANCIS, reduce=reduce.mean)
def avg_clearance(recording: Recording) -> Array:
    """The mean over the samples of the gap to the nearest wall, mean_k c_k.

    The gap is 0 where they overlap, and inside a solid. NaN without walls.
    Series: that gap.
    """
    return recording.path_features.wall_gap


@_metric(unit="-", direction="lower", source=SEAN)
def static_obstacle_collisions(recording: Recording) -> tuple[float, Array]:
    """The number of contacts with walls.

    A contact begins where the gap c_k to the nearest wall falls below 0.02 m,
    or is below it at the start. NaN if the walls are not known. Series: 1 while
    in contact, else 0.
    """
    gap = recording.path_features.wall_gap
    if not recording.near_walls_known:
        return np.nan, gap
    contact = gap < CONTACT_GAP
    begins = np.count_nonzero(contact[1:] & ~contact[:-1]) + contact[0]
    return float(begins), contact.astype(float)
