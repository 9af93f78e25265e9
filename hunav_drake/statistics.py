"""Statistics over runs: how good a planner is, and which one is better.

The tables of runs are those that `WriteResult` adds rows to: a row per run,
with columns that tell it from others and a column per metric.
"""

from collections.abc import Callable, Hashable, Iterable, Sequence
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
import pandas as pd

from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.systems.evaluation.names import COMPLETED

Array = NDArray[np.float64]

# The columns of a table of runs that are no metrics.
ABOUT = ("tag", "scenario", "planner", "seed", "end_reason", "end_time")

# Metrics that are 0 or 1, whose mean is a rate.
RATES = (COMPLETED,)

_RESAMPLES = 5000


def ReadRuns(path: str | Path) -> pd.DataFrame:
    """Reads a table of runs.

    Args:
        path: A `metrics.csv`, or the folder that it is in.

    Returns:
        A row per run.

    Raises:
        OSError: If it cannot be read.
        ValueError: If it is not a table.
    """
    path = Path(path)
    if path.is_dir():
        path = path / "metrics.csv"
    try:
        return pd.read_csv(path)
    except (ValueError, pd.errors.ParserError) as error:
        raise ValueError(f"{path}: is not a table of runs: {error}") from error


def summarize(
    runs: pd.DataFrame,
    by: Sequence[str] = ("scenario", "planner"),
    *,
    metrics: Iterable[str] | None = None,
    rates: Iterable[str] = RATES,
    confidence: float = 0.95,
    seed: int = 0,
) -> pd.DataFrame:
    """Describes each metric over runs of a kind.

    Args:
        runs: A row per run.
        by: The columns that tell the kinds of runs apart; none to take all
            runs together.
        metrics: The columns to describe; by default all that have numbers and
            are metrics.
        rates: Those among them that are 0 or 1.
        confidence: That of the intervals.
        seed: The seed of the bootstrap.

    Returns:
        A row for each kind and metric, indexed by both, with the columns `n`
        (runs in which the metric has a value), `mean`, `sd` (of the sample,
        dividing by n - 1), `median`, and `low` and `high`: the interval of the
        mean, Wilson's for rates, or else the percentile interval of the
        bootstrap. What too few runs do not give is NaN.

    Raises:
        ValueError: If a column is missing, or `confidence` is not in (0, 1).
    """
    by = list(by)
    _check_confidence(confidence)
    names = _metric_columns(runs, by, metrics)
    rates = set(rates)
    kinds: Iterable[tuple[Any, pd.DataFrame]] = (
        runs.groupby(by, sort=False, dropna=False) if by else [((), runs)]
    )
    rows = {}
    for kind, part in kinds:
        for name in names:
            values = _values(part[name])
            if name not in rates:
                ends = bootstrap_interval(values, confidence, seed)
            elif np.isin(values, (0, 1)).all():
                ends = wilson_interval(
                    int(values.sum()), len(values), confidence
                )
            else:
                raise ValueError(
                    f"the column {name!r} is not a rate: it has values other"
                    " than 0 and 1"
                )
            rows[(*kind, name)] = _describe(values) | dict(
                zip(("low", "high"), ends, strict=True)
            )
    return _table(rows, [*by, "metric"])


def compare(
    runs: pd.DataFrame,
    a: Hashable,
    b: Hashable,
    *,
    on: str = "planner",
    pair: Sequence[str] = ("seed",),
    by: Sequence[str] = ("scenario",),
    metrics: Iterable[str] | None = None,
    confidence: float = 0.95,
    seed: int = 0,
) -> pd.DataFrame:
    """Compares two planners, run by run, on the same seeds.

    Args:
        runs: A row per run.
        a: What the runs of the one have in the column `on`.
        b: Likewise, of the other.
        on: The column that tells the two apart.
        pair: The columns in which runs that belong together are equal.
        by: The columns that tell kinds of runs apart.
        metrics: The columns to compare; by default all that have numbers and
            are metrics.
        confidence: That of the intervals.
        seed: The seed of the bootstrap.

    Returns:
        A row for each kind and metric, indexed by both, with the columns `n`
        (pairs in which both have a value), `a` and `b` (the means over those
        pairs), `difference` (b - a), `sd` and `median` of the differences,
        `low` and `high` (the interval of the mean difference, the percentile
        interval of the bootstrap over pairs), and `better`: a or b, if the
        interval leaves out 0 and the metric says what is better, else None.

    Raises:
        ValueError: If a column is missing, a run comes twice, no run of the
            one has its like among those of the other, or `confidence` is not
            in (0, 1).
    """
    by, pair = list(by), list(pair)
    _check_confidence(confidence)
    keys = [*by, *pair]
    names = _metric_columns(runs, [*keys, on], metrics)
    sides = []
    for side in (a, b):
        part = runs[runs[on] == side]
        if part.empty:
            known = ", ".join(map(repr, runs[on].unique()))
            raise ValueError(f"no run has the {on} {side!r}; there are {known}")
        twice = part.duplicated(keys)
        if twice.any():
            first = part[twice].iloc[0][keys].to_dict()
            raise ValueError(
                f"the {on} {side!r} has more than one run with {first}; name"
                " the columns in which they differ in `pair`"
            )
        sides.append(part.set_index(keys)[names])
    one, other = sides
    common = one.index[one.index.isin(other.index)]
    if common.empty:
        raise ValueError(
            f"no two runs of {a!r} and {b!r} have the same {', '.join(keys)}"
        )
    one, other = one.loc[common], other.loc[common]
    kinds = common.to_frame(index=False)
    groups: Iterable[tuple[Any, pd.DataFrame]] = (
        kinds.groupby(by, sort=False, dropna=False) if by else [((), kinds)]
    )
    rows = {}
    for kind, part in groups:
        for name in names:
            x = one[name].to_numpy(dtype=float)[part.index]
            y = other[name].to_numpy(dtype=float)[part.index]
            both = ~np.isnan(x) & ~np.isnan(y)
            x, y = x[both], y[both]
            about = _describe(y - x)
            low, high = bootstrap_interval(y - x, confidence, seed)
            rows[(*kind, name)] = {
                "n": len(x),
                "a": _or_nan(np.mean, x),
                "b": _or_nan(np.mean, y),
                "difference": about["mean"],
                "sd": about["sd"],
                "median": about["median"],
                "low": low,
                "high": high,
                "better": _better(name, low, high, a, b),
            }
    table = _table(rows, [*by, "metric"])
    # pandas would make NaN of None among texts.
    table["better"] = pd.Series(
        [row["better"] for row in rows.values()],
        index=table.index,
        dtype=object,
    )
    return table


def wilson_interval(
    successes: int, n: int, confidence: float = 0.95
) -> tuple[float, float]:
    """Returns the score interval of a rate (Wilson 1927).

    Args:
        successes: How often it happened.
        n: Of how many times; for 0 the interval is NaN.
        confidence: In (0, 1).
    """
    from scipy.stats import norm

    if n == 0:
        return math.nan, math.nan
    z = float(norm.ppf((1 + confidence) / 2))
    p = successes / n
    center = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = (
        z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / (1 + z * z / n)
    )
    # The ends are 0 and 1 exactly, but for rounding.
    low = 0.0 if successes == 0 else center - half
    high = 1.0 if successes == n else center + half
    return low, high


def bootstrap_interval(
    values: Array, confidence: float = 0.95, seed: int = 0
) -> tuple[float, float]:
    """Returns the percentile interval of a mean (Efron 1979).

    Args:
        values: Shape (n,), none of them NaN; for n < 2 the interval is NaN.
        confidence: In (0, 1).
        seed: The seed of the draws.
    """
    from scipy.stats import bootstrap

    if len(values) < 2:
        return math.nan, math.nan
    # A float is not always the mean of its copies.
    if (values == values[0]).all():
        return float(values[0]), float(values[0])
    interval = bootstrap(
        (values,),
        np.mean,
        confidence_level=confidence,
        n_resamples=_RESAMPLES,
        method="percentile",
        random_state=np.random.default_rng(seed),
    ).confidence_interval
    return float(interval.low), float(interval.high)


def _better(
    name: str, low: float, high: float, a: Hashable, b: Hashable
) -> Hashable:
    metric = METRICS.get(name)
    if metric is None or metric.direction == "none":
        return None
    # The difference is b - a.
    if high < 0:
        return b if metric.direction == "lower" else a
    if low > 0:
        return a if metric.direction == "lower" else b
    return None


def _describe(values: Array) -> dict[str, float]:
    return {
        "n": len(values),
        "mean": _or_nan(np.mean, values),
        "sd": float(values.std(ddof=1)) if len(values) > 1 else math.nan,
        "median": _or_nan(np.median, values),
    }


def _or_nan(function: Callable[[Array], Any], values: Array) -> float:
    return float(function(values)) if len(values) else math.nan


def _values(column: pd.Series) -> Array:
    values: Array = column.to_numpy(dtype=float)
    return values[~np.isnan(values)]


def _metric_columns(
    runs: pd.DataFrame, keys: list[str], metrics: Iterable[str] | None
) -> list[str]:
    names = list(
        metrics
        if metrics is not None
        else [
            name
            for name in runs.columns
            if name not in (*ABOUT, *keys)
            and pd.api.types.is_numeric_dtype(runs[name])
        ]
    )
    for name in [*keys, *names]:
        if name not in runs:
            raise ValueError(
                f"the table of runs has no column {name!r}; it has"
                f" {', '.join(map(str, runs.columns))}"
            )
    return names


def _check_confidence(confidence: float) -> None:
    if not 0 < confidence < 1:
        raise ValueError(f"confidence must be in (0, 1), got {confidence}")


def _table(rows: dict[Any, dict[str, Any]], names: list[str]) -> pd.DataFrame:
    table = pd.DataFrame(list(rows.values()))
    table.index = pd.MultiIndex.from_tuples(list(rows), names=names)
    table.attrs["units"] = {
        row[-1]: METRICS[row[-1]].unit for row in rows if row[-1] in METRICS
    }
    return table
