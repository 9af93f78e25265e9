"""The parts of straight motions that lie within a distance."""

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask

# The smallest u after the begin of a motion, and the largest before its end.
_AFTER_BEGIN, _BEFORE_END = np.finfo(float).tiny, np.nextafter(1.0, 0.0)


def chords_within(
    first: Array, last: Array, reach: Array
) -> tuple[Array, Array]:
    """Returns which part of each straight motion lies within a distance.

    A point moves from `first` to `last`, relative to a center, while u grows
    from 0 to 1. It is within R where |d0 + D u|^2 <= R^2, which is between the
    roots of a quadratic: also where both ends are outside.

    Args:
        first: Shape (..., 2), in meters.
        last: The same.
        reach: The distance R, shape (...), in meters.

    Returns:
        The u at which the part begins and ends, in [0, 1], shape (...); NaN
        where there is none, or where a number is NaN. Motions that follow each
        other agree on whether the point between them is inside.
    """
    change = last - first
    a = (change * change).sum(axis=-1)
    b = (first * change).sum(axis=-1)
    inside, stays = _within(first, reach), _within(last, reach)
    c = (first * first).sum(axis=-1) - reach * reach
    with np.errstate(invalid="ignore", divide="ignore"):
        square = b * b - a * c
        # (By rounding, it may be negative where an end is at the border.)
        square = np.where(inside | stays, np.maximum(square, 0.0), square)
        root = np.sqrt(square)
        # This form of the roots avoids cancellation.
        q = -(b + np.copysign(root, b))
        # (At the border, and nearest there, q = c = 0.)
        other = np.where(q == 0, 0.0, c / q)
        roots = np.sort(np.stack([q / a, other]), axis=0)
    begin = np.where(inside, 0.0, roots[0])
    end = np.where(stays, 1.0, roots[1])
    # It is nearest on the way, within the distance. (The signs are those of
    # the roots; a root may miss [0, 1] by rounding.)
    crosses = (b < 0) & (a + b > 0) & (begin < end) & (reach >= 0)
    # (Who begins outside enters, and an end that is outside is an exit.)
    begin = np.where(inside, begin, np.clip(begin, _AFTER_BEGIN, 1.0))
    end = np.where(stays, end, np.clip(end, 0.0, _BEFORE_END))
    known = ~np.isnan(a + reach)
    good = known & (inside | stays | crosses)
    return np.where(good, begin, np.nan), np.where(good, end, np.nan)


def nearest_on_chords(first: Array, last: Array) -> tuple[Array, Array]:
    """Returns where straight motions are nearest to the center.

    Returns:
        The u in [0, 1], and the distance there in meters, shape (...).
    """
    change = last - first
    a = (change * change).sum(axis=-1)
    b = (first * change).sum(axis=-1)
    u = np.clip(-b / np.where(a > 0, a, 1.0), 0.0, 1.0)
    nearest = first + u[..., None] * change
    return u, np.hypot(nearest[..., 0], nearest[..., 1])


def _within(point: Array, reach: Array) -> Mask:
    result: Mask = (reach >= 0) & (
        (point * point).sum(axis=-1) <= reach * reach
    )
    return result
