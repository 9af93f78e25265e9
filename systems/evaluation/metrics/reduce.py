"""Reduces a series over the samples to one number; NaN is skipped."""

import numpy as np

from hunav_drake.systems.common.arrays import Array


def mean(series: Array) -> float:
    """Returns the mean, every sample counting the same."""
    values = series[~np.isnan(series)]
    return float(values.mean()) if values.size else np.nan


def time_average(series: Array, times: Array) -> float:
    """Returns the mean over time, straight from sample to sample.

    Intervals at one end of which there is no value are left out. NaN if that
    leaves none, as of a single value, or of single ones: no time passes.
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
    """Returns how many of the samples are 1, in percent of all samples.

    Samples without a value count among all; NaN if there are only such.
    """
    if np.isnan(series).all():
        return np.nan
    return float(100 * np.count_nonzero(series == 1) / len(series))
