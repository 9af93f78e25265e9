"""Limits that keep forces finite.

The forces contain squares and their products, which are not finite for finite
numbers beyond 1e154.
"""

from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray
from pydrake.autodiffutils import AutoDiffXd, ExtractValue

from hunav_drake.systems.common.kernels import MATRIX, jit_as

# In SI units: numbers of a larger magnitude count as this.
LARGEST = 1e12


@jit_as(numba.boolean, MATRIX)
def is_within(rows):
    """Returns whether no number of an array is too large."""
    for i in range(rows.shape[0]):
        for j in range(rows.shape[1]):
            if abs(rows[i, j]) > LARGEST:
                return False
    return True


def limited(rows: NDArray[Any]) -> NDArray[Any]:
    """Returns rows of floats with magnitudes of at most `LARGEST`.

    Rows within the limit are returned as they are, and so are scalars with
    derivatives.
    """
    if rows.dtype == object or is_within(rows):
        return rows
    clipped: NDArray[Any] = np.clip(rows, -LARGEST, LARGEST)
    return clipped


def lifted(values: NDArray[np.float64]) -> NDArray[Any]:
    """Returns numbers as AutoDiffXd without derivatives."""
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

    Scalars keep their derivatives; those of changed values are 0.
    """
    if scalars.dtype != object:
        values.setflags(write=False)
        return values
    differs = values != plain(scalars)
    changed = scalars.copy()
    changed[differs] = lifted(values[differs])
    return changed
