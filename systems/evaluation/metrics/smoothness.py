"""How smooth the robot's path was, whatever the speed along it.

The definitions are those of Bench-MR. They are of the path alone: its
direction is that of the robot's motion, not of its heading.
"""

from functools import partial
import itertools

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.evaluation.metric import register_metric
from hunav_drake.systems.evaluation.path_features import (
    LEAST_STEP,
    polyline_length,
    thinned,
)
from hunav_drake.systems.evaluation.recording import Recording

_metric = partial(register_metric, family="smoothness")

BENCH_MR = "Bench-MR, Heiden et al. 2021"

# The curvature is that of points at least so far apart, in meters.
_SPACING = 0.3

# A path that turns by more between two steps has a cusp there, in radians.
_CUSP = np.pi / 3


def _curvature(recording: Recording) -> tuple[Array, Array]:
    """Returns the curvature at points of the path, and how far each counts."""
    points, turns = recording.path_features.turns
    cusps = (np.flatnonzero(turns > _CUSP) + 1).tolist()
    parts = [
        thinned(points[first : last + 1], _SPACING)
        for first, last in itertools.pairwise([0, *cusps, len(points) - 1])
    ]
    corners = [
        (part[k], part[k + 1], part[k + 2])
        for part in parts
        for k in range(len(part) - 2)
    ]
    p, q, r = np.array(corners).reshape(-1, 3, 2).transpose(1, 2, 0)
    pq, qr, pr = q - p, r - q, r - p
    a, b, c = np.hypot(*pq), np.hypot(*qr), np.hypot(*pr)
    # (In a loop, a path may come back to where it was.)
    area = np.abs(pq[0] * qr[1] - pq[1] * qr[0]) / 2
    return 4 * area / (a * b * np.maximum(c, LEAST_STEP)), (a + b) / 2


@_metric(unit="rad/m", direction="lower", source=BENCH_MR)
def angle_over_length(recording: Recording) -> float:
    """AOL: by what the path turns, for its length.

    sum |wrap(a_{k+1} - a_k)| / L, where a_k is the direction of the motion
    from one point of the path to the next; a cusp is a turn by pi. The points
    are the positions at least 1 mm from the one before, and L is the length
    through them. NaN if there are none but the first.
    """
    points, turns = recording.path_features.turns
    if len(points) < 2:
        return np.nan
    return float(turns.sum() / polyline_length(points))


@_metric(unit="-", direction="lower", source=BENCH_MR)
def cusps(recording: Recording) -> float:
    """How often the path turns sharply, as where the robot reverses.

    The number of points at which it turns by more than 60 degrees, as
    `angle_over_length` tells points and turns.
    """
    return float(np.count_nonzero(recording.path_features.turns[1] > _CUSP))


@_metric(unit="rad", direction="lower", source=BENCH_MR)
def normalized_curvature(recording: Recording) -> float:
    """The curvature of the path, summed up along it between its cusps.

    sum_k c_k (|p_k - p_{k-1}| + |p_{k+1} - p_k|) / 2, which stands for the
    integral of the curvature over the length: the angle by which the path
    turns. c_k = 4 A / (u v w) is the curvature of the circle through p_{k-1},
    p_k and p_{k+1}: they make a triangle of the area A and the sides u, v, w.
    The points p_k are the positions at least 0.3 m from the one before; cusps
    are left out, as points begin anew there. 0 without three such points.
    """
    curvature, length = _curvature(recording)
    return float((curvature * length).sum())


@_metric(unit="1/m", direction="lower", source=BENCH_MR)
def max_curvature(recording: Recording) -> float:
    """The largest curvature of the path between its cusps, max_k c_k.

    c_k is that of `normalized_curvature`. 0 without three such points.
    """
    return float(_curvature(recording)[0].max(initial=0.0))
