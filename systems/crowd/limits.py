"""Limits that keep forces finite.

The forces contain squares, and products of them: of finite numbers beyond
1e154, they are not finite.
"""

from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray
from pydrake.autodiffutils import AutoDiffXd, ExtractValue

from hunav_drake.systems.common.kernels import MATRIX, jit_as

# In SI units: numbers of a greater size count as this.
LARGEST = 1e12


@jit_as(numba.boolean, MATRIX)
def is_within(rows):
    """Tells whether no number of an array is too large."""
    for i in range(rows.shape[0]):
        for j in range(rows.shape[1]):
            if abs(rows[i, j]) > LARGEST:
                return False
    return True


def limited(rows: NDArray[Any]) -> NDArray[Any]:
    """Returns rows of floats whose size is at most `LARGEST`.

    They are the argument itself if they all are. Scalars with derivatives are
    left as they are.
    """
    if rows.dtype == object or is_within(rows):
        return rows
    clipped: NDArray[Any] = np.clip(rows, -LARGEST, LARGEST)
    return clipped


def lifted(values: NDArray[np.float64]) -> NDArray[Any]:
    """Returns numbers as scalars with derivatives, of which they have none."""
    scalars: NDArray[Any] = np.array(
        [AutoDiffXd(value) for value in values.ravel()], dtype=object
    )
    return scalars.reshape(values.shape)


def plain(scalars: NDArray[Any]) -> NDArray[np.float64]:
    """Returns the values of floats, or of scalars with derivatives."""
    if scalars.dtype != object:
        return scalars
    return np.ascontiguousarray(ExtractValue(scalars))


def changed_to(
    scalars: NDArray[Any], values: NDArray[np.float64]
) -> NDArray[Any]:
    """Returns numbers with other values, read-only.

    With derivatives, if the scalars have some; those of what changes are 0.
    """
    if scalars.dtype != object:
        values.setflags(write=False)
        return values
    differs = values != plain(scalars)
    changed = scalars.copy()
    changed[differs] = lifted(values[differs])
    return changed
