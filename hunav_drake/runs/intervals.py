"""Confidence intervals of means and rates."""

import math

import numpy as np

from hunav_drake.systems.common.arrays import Array

# The smallest number of values for the bootstrap.
LEAST_DRAWN = 20

# From this number of values on, a mean is nearly normal, and the bootstrap,
# which takes a second for each metric of 10 000 runs, hardly improves it.
MOST_DRAWN = 2000

# The maximum number of values that are drawn at once, to save memory.
_AT_ONCE = 1_000_000

_RESAMPLES = 5000


def mean_interval(
    values: Array, confidence: float = 0.95, seed: int = 0
) -> tuple[float, float]:
    """Returns the confidence interval of a mean.

    For less than `LEAST_DRAWN` values, it is that of Student 1908, mean +- t
    sd / sqrt(n), which is exact for a normal distribution. From there on, it
    is the percentile interval of the bootstrap, widened by the ratio of
    Student's interval to that of a known deviation (Hesterberg 2015, "expanded
    percentile"). From `MOST_DRAWN` values on, it is Student's again.

    Args:
        values: Finite values, shape (n,); for n < 2 the interval is NaN.
        confidence: In (0, 1).
        seed: The seed of the draws.
    """
    from scipy.stats import norm, t

    n = len(values)
    if n < 2:
        return math.nan, math.nan
    # A float is not always the mean of its copies.
    if (values == values[0]).all():
        return float(values[0]), float(values[0])
    reach = float(t.ppf((1 + confidence) / 2, n - 1))
    if not LEAST_DRAWN <= n < MOST_DRAWN:
        mean = float(values.mean())
        half = reach * float(values.std(ddof=1)) / math.sqrt(n)
        return mean - half, mean + half
    # The bootstrap divides by n, not by n - 1.
    wider = 2 * float(norm.cdf(reach * math.sqrt(n / (n - 1)))) - 1
    return bootstrap_interval(values, wider, seed)


def bootstrap_interval(
    values: Array, confidence: float = 0.95, seed: int = 0
) -> tuple[float, float]:
    """Returns the percentile interval of a mean (Efron 1979).

    It is too narrow for few values: see `mean_interval`.

    Args:
        values: Finite values, shape (n,); for n < 2 the interval is NaN.
        confidence: In (0, 1).
        seed: The seed of the draws.
    """
    from scipy.stats import bootstrap

    if len(values) < 2:
        return math.nan, math.nan
    if (values == values[0]).all():
        return float(values[0]), float(values[0])
    interval = bootstrap(
        (values,),
        np.mean,
        confidence_level=confidence,
        n_resamples=_RESAMPLES,
        batch=max(1, _AT_ONCE // len(values)),
        method="percentile",
        random_state=np.random.default_rng(seed),
    ).confidence_interval
    return float(interval.low), float(interval.high)


def wilson_interval(
    successes: float, n: int, confidence: float = 0.95
) -> tuple[float, float]:
    """Returns the score interval of a rate (Wilson 1927).

    Args:
        successes: The number of successes; it need not be whole, because an
            observation may be a mean.
        n: The number of observations; for 0 the interval is NaN.
        confidence: In (0, 1).
    """
    from scipy.special import ndtri

    if n == 0:
        return math.nan, math.nan
    z = float(ndtri((1 + confidence) / 2))
    p = successes / n
    middle = (2 * n * p + z**2) / (2 * (n + z**2))
    reach = z / (2 * (n + z**2)) * math.sqrt(4 * n * p * (1 - p) + z**2)
    low = 0.0 if successes <= 0 else middle - reach
    return low, 1.0 if successes >= n else middle + reach


def paired_rate_interval(
    a: Array, b: Array, confidence: float = 0.95
) -> tuple[float, float]:
    """Returns the interval of the difference b - a of two rates in pairs.

    It combines Wilson's intervals of both rates with their correlation,
    corrected for continuity (Newcombe 1998, "Improved confidence intervals for
    the difference between binomial proportions based on paired data", method
    10). Unlike the interval of the mean difference, it has a width even if all
    pairs are equal.

    Args:
        a: Shape (n,), in [0, 1]; for n = 0 the interval is NaN.
        b: Shape (n,), in [0, 1], in the same order.
        confidence: In (0, 1).
    """
    n = len(a)
    if n == 0:
        return math.nan, math.nan
    p_a, p_b = float(a.mean()), float(b.mean())
    low_a, high_a = wilson_interval(float(a.sum()), n, confidence)
    low_b, high_b = wilson_interval(float(b.sum()), n, confidence)
    spread = math.sqrt(p_a * (1 - p_a) * p_b * (1 - p_b))
    together = float(np.mean(a * b)) - p_a * p_b
    if together > 0:
        # Few pairs may seem correlated by chance.
        together = max(together - 0.5 / n, 0.0)
    phi = together / spread if spread else 0.0

    def reach(x: float, y: float) -> float:
        return math.sqrt(max(x * x - 2 * phi * x * y + y * y, 0.0))

    difference = p_b - p_a
    return (
        difference - reach(p_b - low_b, high_a - p_a),
        difference + reach(high_b - p_b, p_a - low_a),
    )


def within_bounds(
    ends: tuple[float, float], values: Array, bounds: tuple[float, float]
) -> tuple[float, float]:
    """Returns the part of an interval that is within the bounds of a metric.

    If values are out of bounds, they are of another program, and the interval
    is not changed.
    """
    if ((values < bounds[0]) | (values > bounds[1])).any():
        return ends
    low, high = (float(np.clip(end, *bounds)) for end in ends)
    return low, high


def exact_interval(
    successes: int, n: int, confidence: float = 0.95
) -> tuple[float, float]:
    """Returns the exact interval of a rate (Clopper and Pearson 1934).

    It holds the rate with at least this confidence, for any n.

    Args:
        successes: Of n independent runs.
        n: At least 1.
        confidence: In (0, 1).
    """
    from scipy.stats import binomtest

    ends = binomtest(successes, n).proportion_ci(confidence, method="exact")
    return float(ends.low), float(ends.high)
