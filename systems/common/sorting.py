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
def heap_between(low, high, keys, heap, places):
    """Makes a heap of the indices of keys (n,) in [low, high).

    A few of many indices are found faster than by sorting all. They are written
    to the start of `heap` (n,), and to `places` (n,) where each is in it, or
    -1; both are of integers. Returns their number.
    """
    count = 0
    for i in range(len(keys)):
        places[i] = -1
        if low <= keys[i] < high:
            heap[count] = i
            count += 1
    for i in range(count - 1, -1, -1):
        _sink(keys, heap, places, i, count)
    return count


@jit
def pop_least(keys, heap, places, count):
    """Takes the index with the least key from a heap of `count` indices.

    Of equal keys, the least index comes first.
    """
    least = heap[0]
    heap[0] = heap[count - 1]
    _sink(keys, heap, places, 0, count - 1)
    places[least] = -1
    return least


@jit
def rise(keys, heap, places, index, count):
    """Adds an index to a heap, or moves it up as its key became smaller.

    Returns the number of indices in the heap, `count` or one more.
    """
    at = places[index]
    if at < 0:
        at = count
        count += 1
    while at > 0 and _is_before(keys, index, heap[(at - 1) // 2]):
        heap[at] = heap[(at - 1) // 2]
        places[heap[at]] = at
        at = (at - 1) // 2
    heap[at] = index
    places[index] = at
    return count


@jit
def _sink(keys, heap, places, at, count):
    """Moves the index at `at` down to its place in a heap."""
    index = heap[at]
    while 2 * at + 1 < count:
        child = 2 * at + 1
        if child + 1 < count and _is_before(keys, heap[child + 1], heap[child]):
            child += 1
        if not _is_before(keys, heap[child], index):
            break
        heap[at] = heap[child]
        places[heap[at]] = at
        at = child
    heap[at] = index
    places[index] = at


@jit
def _is_before(keys, one, other):
    if keys[one] == keys[other]:
        return one < other
    return keys[one] < keys[other]
