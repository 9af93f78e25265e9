"""The duration, length and rotation of the robot's path."""

from functools import partial

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.evaluation.metric import register_metric
from hunav_drake.systems.evaluation.metrics import reduce
from hunav_drake.systems.evaluation.recording import Recording

_metric = partial(register_metric, family="path")

PEREZ_2018 = "Perez-Higueras et al. 2018"


def since_previous(changes: Array, first: float = 0.0) -> Array:
    """Returns the changes of the N intervals, each at the sample at its end."""
    return np.concatenate([[first], changes])


@_metric(unit="s", source="hunav_drake")
def duration(recording: Recording) -> float:
    """The length of the recording, t_N - t_0, with or without a goal."""
    return float(recording.times[-1] - recording.times[0])


@_metric(unit="m", direction="lower", source=PEREZ_2018, reduce=reduce.total)
def path_length(recording: Recording) -> Array:
    """The length of the robot's path, sum |p_{k+1} - p_k|.

    Series: the distance since the previous sample.
    """
    return since_previous(recording.features.step_lengths)


@_metric(unit="rad", direction="lower", source=PEREZ_2018, reduce=reduce.total)
def cumulative_heading_changes(recording: Recording) -> Array:
    """The total rotation of the robot, sum |wrap(yaw_{k+1} - yaw_k)|.

    Series: the turn since the previous sample.
    """
    return since_previous(recording.features.heading_changes)
