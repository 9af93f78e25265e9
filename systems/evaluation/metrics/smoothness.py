"""The smoothness of the robot's path, independent of its speed.

The definitions are those of Bench-MR. They use the path alone: its direction is
that of the robot's motion, not its heading.
"""

from functools import partial
import itertools

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import Y
from hunav_drake.systems.evaluation.metric import register_metric
from hunav_drake.systems.evaluation.path_features import polyline_length
from hunav_drake.systems.evaluation.recording import Recording

_metric = partial(register_metric, family="smoothness")

BENCH_MR = "Bench-MR, Heiden et al. 2021"

# The minimum distance of points for the curvature, and the minimum side of
# their triangles, in meters.
_SPACING = 0.3
_LEAST_SIDE = 1e-9

# The maximum number of points, enough for 300 km; beyond, they are farther
# apart.
_MOST = 1_000_000

# A path has a cusp where it turns by more between two steps, in radians.
_CUSP = np.pi / 3


def _curvature(recording: Recording) -> tuple[Array, Array]:
    """Returns the curvature at points of the path and their lengths."""
    points, turns = recording.path_features.turns
    cusps = (np.flatnonzero(turns > _CUSP) + 1).tolist()
    points = np.vstack([points, recording.robot[-1, : Y + 1]])
    curvatures, lengths = [np.zeros(0)], [np.zeros(0)]
    for first, last in itertools.pairwise([0, *cusps, len(points) - 1]):
        part = points[first : last + 1]
        steps = np.diff(part, axis=0)
        at = np.append(0.0, np.hypot(steps[:, 0], steps[:, 1]).cumsum())
        count = int(min(at[-1] / _SPACING, _MOST))
        if count < 2:
            continue
        even = np.linspace(0.0, at[-1], count + 1)
        kept = np.unique(np.searchsorted((at[1:] + at[:-1]) / 2, even))
        x, y = part[kept].T
        dx, dy = np.diff(x), np.diff(y)
        side = np.maximum(np.hypot(dx, dy), _LEAST_SIDE)
        # (A loop may return to the same point.)
        across = np.hypot(x[2:] - x[:-2], y[2:] - y[:-2])
        area = np.abs(dx[:-1] * dy[1:] - dy[:-1] * dx[1:]) / 2
        curvatures.append(
            4 * area / (side[:-1] * side[1:] * np.maximum(across, _LEAST_SIDE))
        )
        ends = (at[kept][1:] + at[kept][:-1]) / 2
        ends[0], ends[-1] = 0.0, at[-1]
        lengths.append(np.diff(ends))
    return np.concatenate(curvatures), np.concatenate(lengths)


@_metric(unit="rad/m", direction="lower", source=BENCH_MR)
def angle_over_length(recording: Recording) -> float:
    """AOL: the turn of the path per length.

    sum |wrap(a_{k+1} - a_k)| / L, where a_k is the direction of motion from one
    point of the path to the next; a cusp is a turn by pi. The points are the
    positions at least 5 cm from the previous one, and L is the length through
    them, so noise of millimeters is no turn. NaN if there is only the first
    point.
    """
    points, turns = recording.path_features.turns
    if len(points) < 2:
        return np.nan
    return float(turns.sum() / polyline_length(points))


@_metric(unit="-", direction="lower", source=BENCH_MR)
def cusps(recording: Recording) -> float:
    """The number of sharp turns of the path, as where the robot reverses.

    It counts the points at which the path turns by more than 60 degrees, with
    the points and turns of `angle_over_length`.
    """
    return float(np.count_nonzero(recording.path_features.turns[1] > _CUSP))


@_metric(unit="rad", direction="lower", source=BENCH_MR)
def normalized_curvature(recording: Recording) -> float:
    """The curvature of the path, integrated along it between its cusps.

    sum_k c_k l_k, an approximation of the integral of the curvature over the
    length: the angle by which the path turns. Cusps divide the path of
    `angle_over_length`, extended to the last position, into parts. The points
    p_k of a part are those nearest to even distances along it, of 0.3 m or
    slightly more. c_k = 4 A / (u v w) is the curvature of the circle through
    p_{k-1}, p_k and p_{k+1}, which form a triangle of area A with sides u, v,
    w. l_k is the length of the path from halfway to the previous point to
    halfway to the next one; the first and the last c_k extend to the ends of
    the part. A part of less than 0.6 m counts as straight.
    """
    curvature, length = _curvature(recording)
    return float((curvature * length).sum())


@_metric(unit="1/m", direction="lower", source=BENCH_MR)
def max_curvature(recording: Recording) -> float:
    """The largest curvature of the path between its cusps, max_k c_k.

    c_k is that of `normalized_curvature`. 0 where all parts are too short.
    """
    return float(_curvature(recording)[0].max(initial=0.0))
