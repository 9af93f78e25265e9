"""Kernels for the tests of `late_as`, which finds them here by their names."""

import numpy as np

from hunav_drake.systems.common.kernels import REAL, VECTOR, jit_as
from hunav_drake.systems.common.late import late_as


@late_as(VECTOR.copy(readonly=False), VECTOR, REAL)
def scaled(vector, factor):
    if factor > 100:
        raise ValueError("the factor is too large")
    return vector * factor


@jit_as(VECTOR.copy(readonly=False), VECTOR, REAL)
def twice_scaled(vector, factor):
    if factor == 0:
        return np.zeros(len(vector))
    # An array that may be written to, and a whole number, are converted.
    writable = vector.copy()
    return scaled(writable, factor) + scaled(vector, int(factor))
