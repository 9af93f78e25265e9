"""The deviation of the robot's path from a reference, and entanglement.

The reference is `Recording.reference_path`: for example that of a robot which a
person drives, or of the same robot without people. Compiled code is loaded
where it is used, so that metrics can be listed without it.
"""

from functools import partial

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import X, Y
from hunav_drake.systems.evaluation.metric import register_metric
from hunav_drake.systems.evaluation.metrics import reduce
from hunav_drake.systems.evaluation.metrics.efficiency import GAO_HUANG
from hunav_drake.systems.evaluation.path_features import polyline_length
from hunav_drake.systems.evaluation.recording import Recording

_metric = partial(register_metric, family="comparison")


def displacement(times: Array, positions: Array, reference: Array) -> Array:
    """Returns the distances of two moving points at the times of the first.

    The clocks of both start at 0 with their first row. The reference, rows
    (time, x, y), moves straight between its rows and stays at the last one.
    """
    t = times - times[0]
    clock = reference[:, 0] - reference[0, 0]
    dx = positions[:, 0] - np.interp(t, clock, reference[:, 1])
    dy = positions[:, 1] - np.interp(t, clock, reference[:, 2])
    distance: Array = np.hypot(dx, dy)
    return distance


def warped_distance(first: Array, second: Array) -> float:
    """Returns the asymmetric dynamic time warping distance of two paths.

    It is the minimum mean distance of the points of the shorter path (the
    first, if they are equal) from segments of the other, matched in order.
    """
    from hunav_drake.systems.evaluation import curves

    a, b = np.ascontiguousarray(second), np.ascontiguousarray(first)
    if polyline_length(a) < polyline_length(b):
        a, b = b, a
    return float(curves.warped_distance(a, b))


@_metric(
    unit="m",
    direction="lower",
    source=GAO_HUANG,
    aliases=["ade"],
    reduce=reduce.mean,
)
def avg_displacement_error(recording: Recording) -> Array:
    """ADE: the mean distance from the reference at the same time.

    mean_k |p_k - q(t_k - t_0)|, where q is the reference path, timed from its
    start, straight between its rows, at rest after them. NaN without a
    reference. Series: that distance.
    """
    if recording.reference_path is None:
        return np.full(len(recording), np.nan)
    return displacement(
        recording.times, recording.robot[:, : Y + 1], recording.reference_path
    )


@_metric(unit="m", direction="lower", source=GAO_HUANG, aliases=["fde"])
def final_displacement_error(recording: Recording) -> float:
    """FDE: the final distance from the reference.

    |p_N - q(t_N - t_0)|, where q is the reference path, timed from its start,
    straight between its rows, at rest after them. NaN without a reference.
    """
    return reduce.last(avg_displacement_error(recording))


@_metric(unit="m", direction="lower", source=GAO_HUANG, aliases=["adtw"])
def asymmetric_dtw(recording: Recording) -> float:
    """The distance from the reference path, independent of speeds.

    Each point of the path that is shorter in meters (the robot's, if they are
    equal) is matched to a segment of the other, in the order of both, so that
    the mean of their distances is minimal; the metric is that mean. With j the
    points and i the segments, the sum is the last C(i, j) = min(C(i - 1, j),
    C(i, j - 1) + dist(segment_i, point_j)). NaN without a reference.
    """
    if recording.reference_path is None:
        return np.nan
    return warped_distance(
        recording.robot[:, : Y + 1], recording.reference_path[:, 1:]
    )


@_metric(unit="-", source=f"Mavrogiannis et al. 2018; {GAO_HUANG}")
def topological_complexity(recording: Recording) -> float:
    """The entanglement of the paths of robot and people: sum_{i<j} |w_ij|.

    Winding replaces the entropy of the paths as a braid: w_ij is the winding
    number of a pair of the n + 1 bodies, the total change of the bearing from i
    to j, divided by 2 pi, between samples at which both are present. Two bodies
    that pass each other on long straight lines have 1/2. 0 without people.
    """
    from hunav_drake.systems.evaluation import curves

    bodies = np.concatenate(
        [recording.robot[:, None], recording.humans], axis=1
    )
    x, y = (np.ascontiguousarray(bodies[..., axis]) for axis in (X, Y))
    return float(curves.total_winding(x, y))
