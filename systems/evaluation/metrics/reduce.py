"""Functions that reduce a series to one number; they skip NaN."""

import numpy as np

from hunav_drake.systems.common.arrays import Array


def mean(series: Array) -> float:
    """Returns the mean over the samples."""
    values = series[~np.isnan(series)]
    return float(values.mean()) if values.size else np.nan


def time_average(series: Array, times: Array) -> float:
    """Returns the mean over time, linear between samples.

    Intervals without a value at one end are left out. NaN if there are no
    others.
    """
    middle = (series[1:] + series[:-1]) / 2
    known = ~np.isnan(middle)
    if not known.any():
        return np.nan
    dt = np.diff(times)[known]
    return float((middle[known] * dt).sum() / dt.sum())


def total(series: Array) -> float:
    """Returns the sum; NaN if there is nothing to sum."""
    values = series[~np.isnan(series)]
    return float(values.sum()) if values.size else np.nan


def last(series: Array) -> float:
    """Returns the last value, NaN or not."""
    return float(series[-1])


def share(series: Array) -> float:
    """Returns the percentage of samples that are 1.

    Samples without a value count in the total; NaN if there are no others.
    """
    if np.isnan(series).all():
        return np.nan
    return float(100 * np.count_nonzero(series == 1) / len(series))
