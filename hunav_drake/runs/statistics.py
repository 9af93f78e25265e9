"""Statistics over runs, and comparisons of planners.

The tables of runs are those of `ReadRuns`, or their CSV read by pandas, where
empty names are NaN: a row per run, with columns that identify it and a column
per metric. In metrics, NaN and infinity are not values: they are left out, and
`n` is the number of values. Runs that differ only in the column `repetition`
are not independent: their mean counts once. Nor are runs whose seeds draw
nothing, according to the column `drawn`: equal ones count once, and represent
every seed of the runs that they are compared with.
"""

from collections.abc import Hashable, Iterable, Iterator
import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
import pandas as pd

from hunav_drake.runs.independent_runs import (
    draws_nothing,
    once_per_seed,
    over_all_seeds,
)
from hunav_drake.runs.intervals import (
    mean_interval,
    paired_rate_interval,
    wilson_interval,
    within_bounds,
)
from hunav_drake.runs.settings import has_settings, with_names
from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.suggest import shown, suggestion
from hunav_drake.systems.evaluation.metric import (
    ABOUT_RUNS,
    FLEET_FAMILY,
    METRICS,
    base_name,
)
from hunav_drake.trial.metric_facts import (
    Facts,
    bounds_of,
    direction_of,
    unit_of,
)
from hunav_drake.trial.quantity_text import ROUNDING

Names = str | Iterable[str]

# Metrics that are 0 or 1, whose mean is a rate.
RATES = ("completed",)


# Metrics that include runs that do not arrive. All other metrics of such runs
# are for another path, or another time.
OF_ALL_RUNS = (
    *RATES,
    "success_weighted_path_length",
    "success_weighted_time_length",
    "barn_score",
)

# Times that a run that never arrives does not have.
TIMES = ("time_to_reach_goal", "makespan")

# Metrics that are smaller if a run ends early.
_OF_THE_WAY = ("path_length", "cumulative_heading_changes")

# The smallest number of pairs to call one better: even if all of 5 pairs have
# the same sign, this happens by chance once in 16 times.
LEAST_PAIRS = 6


def is_rate(metric: str) -> bool:
    """Returns whether a metric is a rate, also of one of several robots."""
    return base_name(metric) in RATES


def summarize(
    runs: pd.DataFrame,
    by: Names | None = None,
    *,
    metrics: Names | None = None,
    rates: Names = RATES,
    confidence: float = 0.95,
    seed: int = 0,
    bounded: bool = False,
) -> pd.DataFrame:
    """Returns statistics of each metric over each kind of runs.

    Args:
        runs: A row per run.
        by: The columns that distinguish kinds of runs, () for one kind; by
            default scenario, planner, and setting if a run has one.
        metrics: The columns to describe; by default all numeric metrics.
        rates: The metrics that are 0 or 1, also of one of several robots.
        confidence: The confidence of the intervals.
        seed: The seed of the bootstrap.
        bounded: Whether intervals are limited to the possible values of a
            metric; else they may reach below 0.

    Returns:
        A row for each kind and metric, indexed by both, with the columns `n`
        (the number of runs, or of repeated seeds, with a finite value),
        `mean`, `sd` (of the sample, dividing by n - 1), `median`, `low` and
        `high` (the interval of the mean: `wilson_interval` for rates, else
        `mean_interval`; NaN for one run of which nothing is drawn), and
        `arrived`: how many of the `n` reach the goal, NaN if unknown.
        Statistics that need more runs are NaN.

    Raises:
        ValueError: If a column is missing, there is nothing to describe, or
            `confidence` is not in (0, 1).
    """
    if by is None:
        by = ("scenario", "planner", *(["setting"] * has_settings(runs)))
    by = _listed(by)
    _check_confidence(confidence)
    bare = with_numbers(_bare(runs), metrics)
    names = _metric_columns(bare, by, metrics)
    known_rates = _listed(rates)
    found = [name for name in names if {name, base_name(name)} & {*known_rates}]
    for name in found:
        _check_rate(name, bare)
    goals = arrival_rates(bare)
    columns = list(dict.fromkeys([*names, *goals]))
    rows = {}
    for kind, part in _groups(once_per_seed(bare, by, columns), by):
        ends_of_runs = part[goals]
        for name in names:
            done = arrivals(ends_of_runs, name)
            has_goals = bool(np.isfinite(done).any())
            values = part[name].to_numpy(dtype=float)
            finite = np.isfinite(values)
            values = values[finite]
            if len(part) == 1 and draws_nothing(part).all():
                ends = math.nan, math.nan
            elif name in found:
                successes = float(values.sum())
                ends = wilson_interval(successes, len(values), confidence)
            else:
                ends = mean_interval(values, confidence, seed)
                if bounded:
                    ends = within_bounds(ends, values, bounds_of(name))
            arrived = int((done[finite] == 1).sum()) if has_goals else math.nan
            about = {"low": ends[0], "high": ends[1], "arrived": arrived}
            rows[(*kind, name)] = _describe(values) | about
    return _table(runs, rows, [*by, "metric"])


def compare(
    runs: pd.DataFrame,
    a: Hashable,
    b: Hashable,
    *,
    on: str = "planner",
    pair: Names = ("seed",),
    by: Names = ("scenario",),
    metrics: Names | None = None,
    confidence: float = 0.95,
) -> pd.DataFrame:
    """Compares two planners on the same seeds.

    At a confidence of 0.95, 1 in 20 metrics without a true difference shows
    one by chance: choose the metrics that matter in advance.

    A run that does not reach the goal has a shorter path, and no time to the
    goal. So if one of the two does not arrive in some pair, only pairs in
    which both arrive are compared, except for metrics of how often they do.

    Args:
        runs: A row per run.
        a: The value of the first planner in the column `on`.
        b: The value of the second planner.
        on: The column that distinguishes the two.
        pair: The columns that are equal in the runs of a pair.
        by: The columns that distinguish kinds of runs.
        metrics: The columns to compare; by default all numeric metrics.
        confidence: The confidence of the intervals.

    Returns:
        A row for each kind and metric, indexed by both, with the columns `n`
        (the number of pairs with two finite values), `pairs` ("all" or "both
        arrive"), `a` and `b` (the means over those pairs), `difference` (b -
        a; rounding errors count as 0), `sd` and `median` of the differences,
        `low` and `high` (the interval of the mean difference:
        `paired_rate_interval` for `RATES`, else `mean_interval` over pairs),
        and `better`: a or b, if there are at least `LEAST_PAIRS` pairs, the
        interval excludes 0, and the metric has a better direction; else None.

    Raises:
        ValueError: If a column is missing, a and b are the same, a pair has
            two runs of one planner, there are no pairs, or `confidence` is not
            in (0, 1).
    """
    by, pair = _listed(by), _listed(pair)
    _check_confidence(confidence)
    rows = {}
    for kind, name, x, y, some in _values(runs, (a, b), on, pair, by, metrics):
        row = _describe_pairs(x, y, is_rate(name), confidence)
        row["pairs"] = "both arrive" if some else "all"
        better = _better(direction_of(runs, name), row)
        rows[(*kind, name)] = row | {"better": {"a": a, "b": b}.get(better)}
    table = _table(runs, rows, [*by, "metric"])
    # pandas would make NaN of None among texts.
    verdicts = [row["better"] for row in rows.values()]
    table["better"] = pd.Series(verdicts, table.index, dtype=object)
    return table


def differences(
    runs: pd.DataFrame,
    a: Hashable,
    b: Hashable,
    metric: str,
    *,
    on: str = "planner",
    pair: Names = ("seed",),
) -> Array:
    """Returns b - a of each pair that `compare` compares, in any scenario.

    Args:
        runs: A row per run.
        a: The value of the first planner in the column `on`.
        b: The value of the second planner.
        metric: A column of the table.
        on: The column that distinguishes the two.
        pair: The columns that are equal in the runs of a pair.

    Returns:
        Shape (pairs,), in the unit of the metric; rounding errors are 0.

    Raises:
        ValueError: See `compare`.
    """
    found = _values(runs, (a, b), on, _listed(pair), ["scenario"], metric)
    return np.concatenate([_gaps(x, y) for _, _, x, y, _ in found])


def early_mark(metric: str, described: pd.Series) -> str:
    """Returns an asterisk if a mean includes paths that end early.

    Args:
        metric: The metric.
        described: Its row of `summarize`.
    """
    is_early = described["arrived"] < described["n"]
    return "*" if base_name(metric) in _OF_THE_WAY and is_early else ""


def arrival_rates(runs: pd.DataFrame) -> list[str]:
    """Returns the rates of arrival in a table, also of several robots."""
    return [str(name) for name in runs if is_rate(str(name))]


def arrivals(runs: pd.DataFrame, metric: str = "") -> Array:
    """Returns how often runs arrive, shape (runs,); NaN if unknown.

    Args:
        runs: A row per run.
        metric: The metric for which this counts. For one of several robots it
            is that robot's rate, else the rate of the one that arrives least;
            a single robot has no metrics of several.
    """
    names = arrival_rates(runs)
    own = metric.removesuffix(base_name(metric)) + RATES[0]
    if own in names and own not in RATES:
        names = [own]
    elif metric in METRICS and METRICS[metric].family == FLEET_FAMILY:
        names = [it for it in names if it not in RATES]
    rates = runs[names].to_numpy(dtype=float)
    # (NaN, too, if there is no rate.)
    least: Array = np.fmin.reduce(rates, axis=1, initial=np.nan)
    return least


def where_all_arrive(completed: Iterable[ArrayLike]) -> Mask | None:
    """Returns the seeds in which all planners arrive; None for all seeds.

    Args:
        completed: The rate of arrival of each planner in each seed, shape
            (seeds,); NaN if unknown, as without a goal.
    """
    rates = np.array([np.asarray(it, dtype=float) for it in completed])
    fails: Mask = (np.isfinite(rates) & (rates != 1)).any(axis=0)
    return ~fails if fails.any() else None


def _bare(runs: pd.DataFrame) -> pd.DataFrame:
    """Returns a table with all names, and without `attrs`.

    (pandas would copy these each time.)
    """
    return with_names(pd.DataFrame(runs))


def _groups(table: pd.DataFrame, by: list[str]) -> Any:
    """Returns the values of some columns, and the rows of each."""
    return table.groupby(by, sort=False, dropna=False) if by else [((), table)]


def _values(
    runs: pd.DataFrame,
    sides: tuple[Hashable, Hashable],
    on: str,
    pair: list[str],
    by: list[str],
    metrics: Names | None,
) -> Iterator[tuple[Any, str, Array, Array, bool]]:
    """Yields the values of two planners that are compared, in pairs.

    Yields:
        The kind of runs, the metric, the values of both sides, and whether
        they are those of pairs in which both arrive.
    """
    runs = with_numbers(_bare(runs), metrics)
    names = _metric_columns(runs, [*by, *pair, on], metrics)
    goals = arrival_rates(runs)
    columns = list(dict.fromkeys([*names, *goals]))
    for name in filter(is_rate, columns):
        _check_rate(name, runs)
    told = once_per_seed(runs, [*by, *pair, on], columns)
    one, other = _pairs(told, sides, on, [*by, *pair], columns)
    kinds = one.index.to_frame(index=False)
    for kind, part in _groups(kinds, by):
        xs, ys = (it.iloc[part.index] for it in (one, other))
        for name in names:
            both = where_all_arrive(
                arrivals(it[goals], name) for it in (xs, ys)
            )
            x, y = (it[name].to_numpy(dtype=float) for it in (xs, ys))
            if both is not None and base_name(name) not in OF_ALL_RUNS:
                yield kind, name, x[both], y[both], True
            else:
                yield kind, name, x, y, False


def _pairs(
    runs: pd.DataFrame,
    sides: tuple[Hashable, Hashable],
    on: str,
    keys: list[str],
    names: list[str],
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Returns the runs of both sides, paired row by row."""
    if sides[0] == sides[1]:
        raise ValueError(f"{sides[0]!r} cannot be compared with itself")
    tables = []
    for side in sides:
        part = runs[runs[on] == side]
        if part.empty:
            known = ", ".join(map(repr, runs[on].unique().tolist()))
            raise ValueError(
                f"no run has the {on} {shown(side)}; there are {known}"
            )
        twice = part.duplicated(keys)
        if twice.any():
            first = part[twice].iloc[0][keys].to_dict()
            raise ValueError(
                f"the {on} {shown(side)} has more than one run with"
                f" {first}; name"
                " the columns in which they differ in `pair`, or select runs"
                " first"
            )
        tables.append(part)
    one = over_all_seeds(tables[0], tables[1], keys)
    other = over_all_seeds(tables[1], one, keys)
    one, other = (it.set_index(keys)[names] for it in (one, other))
    common = one.index[one.index.isin(other.index)]
    if common.empty:
        raise ValueError(
            f"no two runs of {sides[0]!r} and {sides[1]!r} have the same"
            f" {', '.join(keys)}"
        )
    return one.loc[common], other.loc[common]


def _describe_pairs(
    x: Array, y: Array, is_rate: bool, confidence: float
) -> dict[str, Any]:
    """Returns the statistics of a metric over pairs of runs."""
    gaps = _gaps(x, y)
    both = np.isfinite(x) & np.isfinite(y)
    x, y = x[both], y[both]
    if is_rate:
        low, high = paired_rate_interval(x, y, confidence)
    else:
        low, high = mean_interval(gaps, confidence)
    about = _describe(gaps)
    return {
        "n": len(x),
        "a": pd.Series(x).mean(),
        "b": pd.Series(y).mean(),
        "difference": about.pop("mean"),
        **about,
        "low": low,
        "high": high,
    }


def _gaps(x: Array, y: Array) -> Array:
    """Returns y - x of all pairs of finite numbers; rounding errors are 0."""
    both = np.isfinite(x) & np.isfinite(y)
    x, y = x[both], y[both]
    return np.where(np.isclose(x, y, ROUNDING, ROUNDING), 0.0, y - x)


def _better(direction: str, row: dict[str, Any]) -> str:
    """Returns which of "a" and "b" is better; "" if neither is."""
    if direction == "none" or row["n"] < LEAST_PAIRS:
        return ""
    # The difference is b - a.
    if row["low"] <= 0 <= row["high"]:
        return ""
    return "b" if (row["high"] < 0) == (direction == "lower") else "a"


def _describe(values: Array) -> dict[str, float]:
    series = pd.Series(values)
    return {
        "n": len(series),
        "mean": series.mean(),
        "sd": series.std(),
        "median": series.median(),
    }


def _listed(names: Names) -> list[str]:
    return [names] if isinstance(names, str) else list(names)


def check_columns(runs: pd.DataFrame, names: Iterable[Hashable]) -> None:
    """Raises a ValueError if a table of runs does not have such columns."""
    for name in names:
        if name not in runs:
            raise ValueError(
                f"the table of runs has no column {shown(name)};"
                f" {suggestion(str(name), list(map(str, runs.columns)))}"
            )


def with_numbers(runs: pd.DataFrame, metrics: Names | None) -> pd.DataFrame:
    """Returns a table whose columns of metrics hold numbers.

    (A single cell of text makes texts of a whole column of a CSV file.)

    Args:
        runs: A row per run.
        metrics: The columns of the metrics, besides the rates of arrival; by
            default all metrics that are known.

    Raises:
        ValueError: If a cell is neither a number nor empty.
    """
    if metrics is None:
        metrics = [it for it in map(str, runs) if base_name(it) in METRICS]
    columns = {}
    for name in dict.fromkeys([*_listed(metrics), *arrival_rates(runs)]):
        if name in runs and not pd.api.types.is_numeric_dtype(runs[name]):
            numbers = pd.to_numeric(runs[name], errors="coerce")
            told = runs[name].notna() & (runs[name] != "")
            bad = (numbers.isna() & told).to_numpy()
            if bad.any():
                row = int(bad.argmax())
                raise ValueError(
                    f"row {row + 1} of the runs: {shown(name)} must be a"
                    f" number, or empty, got {shown(str(runs[name].iloc[row]))}"
                )
            columns[name] = numbers.astype(float)
    return runs.assign(**columns)


def _metric_columns(
    runs: pd.DataFrame, keys: list[str], metrics: Names | None
) -> list[str]:
    names = (
        _listed(metrics)
        if metrics is not None
        else [
            name
            for name in runs.columns
            if name not in (*ABOUT_RUNS, *keys)
            and pd.api.types.is_numeric_dtype(runs[name])
        ]
    )
    check_columns(runs, [*keys, *names])
    if runs.empty or not names:
        raise ValueError(
            f"there is nothing to describe: {len(runs)} runs, {len(names)}"
            " metrics"
        )
    return names


def _check_rate(name: str, runs: pd.DataFrame) -> None:
    found = runs[name].to_numpy(dtype=float)
    if not np.isin(found[np.isfinite(found)], (0, 1)).all():
        raise ValueError(
            f"the column {shown(name)} is not a rate: it has values other"
            " than 0 and 1"
        )


def _check_confidence(confidence: float) -> None:
    if not 0 < confidence < 1:
        raise ValueError(f"confidence must be in (0, 1), got {confidence}")


def _table(
    runs: pd.DataFrame, rows: dict[Any, dict[str, Any]], names: list[str]
) -> pd.DataFrame:
    table = pd.DataFrame(list(rows.values()))
    table.index = pd.MultiIndex.from_tuples(list(rows), names=names)
    units = {row[-1]: unit_of(runs, row[-1]) for row in rows}
    table.attrs["units"] = Facts((it, units[it]) for it in units if units[it])
    return table
