"""Sorting of numbers, compiled by numba.

NumPy's takes seconds to compile wherever it is used.
"""

import numpy as np

from hunav_drake.systems.common.kernels import jit

# Runs of this length are sorted one by one, before they are merged.
_RUN = 16


@jit
def stable_order(values):
    """Returns the indices of numbers (n,) from the smallest to the largest.

    Equal ones keep their order. The array is contiguous, none is NaN.
    """
    n = len(values)
    order = np.empty(n, np.int64)
    for start in range(0, n, _RUN):
        for i in range(start, min(start + _RUN, n)):
            at = i
            while at > start and values[order[at - 1]] > values[i]:
                order[at] = order[at - 1]
                at -= 1
            order[at] = i
    merged = np.empty(n if n > _RUN else 0, np.int64)
    width = _RUN
    while width < n:
        for start in range(0, n, 2 * width):
            middle = min(start + width, n)
            end = min(start + 2 * width, n)
            left = start
            right = middle
            for at in range(start, end):
                if right >= end or (
                    left < middle
                    and not values[order[right]] < values[order[left]]
                ):
                    merged[at] = order[left]
                    left += 1
                else:
                    merged[at] = order[right]
                    right += 1
        order, merged = merged, order
        width *= 2
    return order


@jit
def heap_between(low, high, keys, heap):
    """Makes a heap of the indices of keys (n,) in [low, high).

    A few of many indices are found faster than by sorting all. They are written
    to the start of `heap` (n,), of integers; returns their number.
    """
    count = 0
    for i in range(len(keys)):
        if low <= keys[i] < high:
            heap[count] = i
            count += 1
    for i in range(count // 2 - 1, -1, -1):
        _sink(keys, heap, i, count)
    return count


@jit
def pop_least(keys, heap, count):
    """Takes the index with the least key from a heap of `count` indices.

    Of equal keys, the least index comes first.
    """
    least = heap[0]
    heap[0] = heap[count - 1]
    _sink(keys, heap, 0, count - 1)
    return least


@jit
def _sink(keys, heap, at, count):
    """Moves the index at `at` down to its place in a heap."""
    place = heap[at]
    while 2 * at + 1 < count:
        child = 2 * at + 1
        if child + 1 < count and _is_before(keys, heap[child + 1], heap[child]):
            child += 1
        if not _is_before(keys, heap[child], place):
            break
        heap[at] = heap[child]
        at = child
    heap[at] = place


@jit
def _is_before(keys, one, other):
    if keys[one] == keys[other]:
        return one < other
    return keys[one] < keys[other]
