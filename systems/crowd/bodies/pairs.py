"""Finds pairs of people who are near each other, compiled by numba."""

import math

import numpy as np

from hunav_drake.systems.common.kernels import jit
from hunav_drake.systems.common.sorting import stable_order

# The number of people from which on they are sorted first.
_SORT_FROM = 16

# Room for this many more pairs than are found, at the end of the array.
_SPARE = 8

# The part of a distance that rounding may change, and the same in meters.
_ROUNDING = 1e-9


@jit
def near_pairs(x, y, reach):
    """Returns the pairs (p, 2) of people, by their numbers, whose reaches meet.

    They are sorted along the longer side of their bounding box, and compared
    with those that follow until no later one can be near. The arguments have
    shape (n,), in meters.
    """
    n = len(x)
    pairs = np.empty((4 * n + _SPARE, 2), np.int64)
    count = 0
    if n < 2:
        return pairs[:0]
    far = math.inf
    along = np.empty(n)
    across = np.empty(n)
    reaches = np.empty(n)
    if n > _SORT_FROM:
        longest = 0.0
        left, right, bottom, top = x[0], x[0], y[0], y[0]
        for i in range(n):
            longest = max(longest, reach[i])
            left, right = min(left, x[i]), max(right, x[i])
            bottom, top = min(bottom, y[i]), max(top, y[i])
        far = 2 * longest
        wide = right - left >= top - bottom
        for i in range(n):
            across[i] = x[i] if wide else y[i]
        order = stable_order(across)
        for a in range(n):
            i = order[a]
            along[a] = x[i] if wide else y[i]
            across[a] = y[i] if wide else x[i]
            reaches[a] = reach[i]
    else:
        order = np.empty(n, np.int64)
        for i in range(n):
            order[i] = i
            along[i] = x[i]
            across[i] = y[i]
            reaches[i] = reach[i]
    end = 0
    for a in range(n):
        at = along[a]
        beside = across[a]
        own = reaches[a]
        end = max(end, a + 1)
        while end < n and along[end] - at <= far:
            end += 1
        if count + end - a > len(pairs):
            more = np.empty((2 * len(pairs) + end - a, 2), np.int64)
            for p in range(count):
                more[p, 0] = pairs[p, 0]
                more[p, 1] = pairs[p, 1]
            pairs = more
        # (Each pair is written, and kept if it is near: to jump over those
        # that are not takes longer.)
        for b in range(a + 1, end):
            dx = along[b] - at
            dy = across[b] - beside
            both = own + reaches[b]
            pairs[count, 0] = order[a]
            pairs[count, 1] = order[b]
            count += dx * dx + dy * dy < both * both
    return pairs[:count]


@jit
def covered(distance):
    """Returns the search radius that misses nobody within a distance."""
    return distance * (1 + _ROUNDING) + _ROUNDING
