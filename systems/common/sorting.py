"""The order of numbers, compiled by numba.

That of NumPy takes seconds to compile wherever it is used.
"""

import numpy as np

from hunav_drake.systems.common.kernels import jit

# Up to so many numbers are sorted one by one, before they are merged.
_RUN = 16


@jit
def stable_order(values):
    """Returns where some numbers stand, from the smallest to the largest.

    Equal ones keep their order. None may be NaN.

    Args:
        values: Shape (n,), contiguous.

    Returns:
        Shape (n,), of indices.
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
