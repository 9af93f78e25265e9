"""Statistics over runs: how good a planner is, and which one is better.

The tables of runs are those that `ReadRuns` gives: a row per run, with columns
that tell it from others and a column per metric. What is NaN or infinite is no
value: it is left out, and `n` tells how many are left. Runs that differ in the
column `repetition` alone are no independent ones: their mean counts once. Nor
are runs of which the column `drawn` tells that their seeds draw nothing: equal
ones count once, whatever their seeds, and stand for every seed of the runs
that they are compared with.
"""

from collections.abc import Hashable, Iterable
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
from hunav_drake.runs.settings import has_settings
from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.suggest import shown, suggestion
from hunav_drake.systems.evaluation.metric import ABOUT_RUNS
from hunav_drake.trial.metric_facts import bounds_of, direction_of, unit_of
from hunav_drake.trial.quantity_text import ROUNDING

Names = str | Iterable[str]

# Metrics that are 0 or 1, whose mean is a rate.
RATES = ("completed",)

# What counts the runs that do not arrive in; all other metrics of these are of
# another way, or another time, than of those that do.
OF_ALL_RUNS = (*RATES, "success_weighted_path_length")

# What is less of a way that ends early.
_OF_THE_WAY = ("path_length", "cumulative_heading_changes")

# With fewer pairs of runs than this none is called better: even if all of 5
# point the same way, that happens by chance once in 16 times.
LEAST_PAIRS = 6


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
    """Describes each metric over runs of a kind.

    Args:
        runs: A row per run.
        by: The columns that tell the kinds of runs apart, () to take all
            runs together; by default scenario, planner, and setting if any
            run has one.
        metrics: The columns to describe; by default all that have numbers and
            are metrics.
        rates: Those among them that are 0 or 1.
        confidence: That of the intervals.
        seed: The seed of the bootstrap.
        bounded: Whether intervals end at the least and the largest value that
            a metric can have; else they may reach below 0.

    Returns:
        A row for each kind and metric, indexed by both, with the columns `n`
        (runs, or seeds that are run several times, in which the metric has a
        finite value), `mean`, `sd` (of the sample, dividing by n - 1),
        `median`, and `low` and `high`: the
        interval of the mean, `wilson_interval` for rates, else
        `mean_interval`, and none of a run of which nothing is drawn; and
        `arrived`: how many of the `n` reach the goal, NaN if that is not known.
        What too few runs do not give is NaN.

    Raises:
        ValueError: If a column is missing, there is nothing to describe, or
            `confidence` is not in (0, 1).
    """
    if by is None:
        by = ("scenario", "planner", *(["setting"] * has_settings(runs)))
    by = _listed(by)
    _check_confidence(confidence)
    names = _metric_columns(runs, by, metrics)
    rates = set(_listed(rates))
    for name in rates.intersection(names):
        _check_rate(name, runs)
    known = RATES[0] if RATES[0] in runs else None
    columns = list(dict.fromkeys([*names, *([known] if known else [])]))
    rows = {}
    for kind, part in _groups(once_per_seed(_bare(runs), by, columns), by):
        done = part[known].to_numpy(dtype=float) if known else np.zeros(0)
        has_goals = bool(np.isfinite(done).any())
        for name in names:
            values = part[name].to_numpy(dtype=float)
            finite = np.isfinite(values)
            values = values[finite]
            if len(part) == 1 and draws_nothing(part).all():
                ends = math.nan, math.nan
            elif name in rates:
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
    """Compares two planners, run by run, on the same seeds.

    Of many metrics that do not differ, 1 in 20 shows a difference all the
    same at a confidence of 0.95: choose beforehand the ones that matter.

    A run that does not reach the goal has a shorter way than it needs, and no
    time. So where one of the two does not arrive in some pair, metrics are
    compared in the pairs in which both do, but for those that tell how often.

    Args:
        runs: A row per run.
        a: What the runs of the one have in the column `on`.
        b: What the runs of the other have in it.
        on: The column that tells the two apart.
        pair: The columns in which runs that belong together are equal.
        by: The columns that tell kinds of runs apart.
        metrics: The columns to compare; by default all that have numbers and
            are metrics.
        confidence: That of the intervals.

    Returns:
        A row for each kind and metric, indexed by both, with the columns `n`
        (pairs in which both have a finite value), `pairs` (which ones: "all"
        or "both arrive"), `a` and `b` (the means over those pairs),
        `difference` (b - a; rounding counts as 0), `sd` and `median` of the
        differences, `low` and `high` (the interval of the mean difference,
        `paired_rate_interval` for `RATES`, else `mean_interval` over pairs),
        and `better`: a or b, if there are at least `LEAST_PAIRS` pairs, the
        interval leaves out 0, and the metric says what is better; else None.

    Raises:
        ValueError: If a column is missing, a and b are the same, a run comes
            twice, no run of the one has its like among those of the other, or
            `confidence` is not in (0, 1).
    """
    by, pair = _listed(by), _listed(pair)
    _check_confidence(confidence)
    names = _metric_columns(runs, [*by, *pair, on], metrics)
    columns = list(dict.fromkeys([*names, *(r for r in RATES if r in runs)]))
    for name in RATES:
        if name in runs:
            _check_rate(name, runs)
    told = once_per_seed(_bare(runs), [*by, *pair, on], columns)
    one, other = _pairs(told, (a, b), on, [*by, *pair], columns)
    kinds = one.index.to_frame(index=False)
    rows = {}
    for kind, part in _groups(kinds, by):
        xs, ys = (it.iloc[part.index] for it in (one, other))
        both = None
        if RATES[0] in columns:
            both = where_all_arrive([it[RATES[0]] for it in (xs, ys)])
        for name in names:
            x, y = (it[name].to_numpy(dtype=float) for it in (xs, ys))
            some = both is not None and name not in OF_ALL_RUNS
            if some:
                x, y = x[both], y[both]
            row = _describe_pairs(x, y, name in RATES, confidence)
            row["pairs"] = "both arrive" if some else "all"
            better = _better(direction_of(runs, name), row)
            rows[(*kind, name)] = row | {"better": {"a": a, "b": b}.get(better)}
    table = _table(runs, rows, [*by, "metric"])
    # pandas would make NaN of None among texts.
    verdicts = [row["better"] for row in rows.values()]
    table["better"] = pd.Series(verdicts, table.index, dtype=object)
    return table


def early_mark(metric: str, described: pd.Series) -> str:
    """Returns an asterisk if a mean is also of ways that end early.

    Args:
        metric: The metric.
        described: Its row of `summarize`.
    """
    is_early = described["arrived"] < described["n"]
    return "*" if metric in _OF_THE_WAY and is_early else ""


def where_all_arrive(completed: Iterable[ArrayLike]) -> Mask | None:
    """Returns the seeds in which all arrive; None where all count.

    Args:
        completed: Of each planner, how often it arrives in each seed, shape
            (seeds,); NaN if that is not known, as without a goal.
    """
    rates = np.array([np.asarray(it, dtype=float) for it in completed])
    fails: Mask = (np.isfinite(rates) & (rates != 1)).any(axis=0)
    return ~fails if fails.any() else None


def _bare(runs: pd.DataFrame) -> pd.DataFrame:
    """Returns a table without `attrs`, which pandas copies at every step."""
    return pd.DataFrame(runs)


def _groups(table: pd.DataFrame, by: list[str]) -> Any:
    """Returns the kinds of rows that columns tell apart, and their rows."""
    return table.groupby(by, sort=False, dropna=False) if by else [((), table)]


def _pairs(
    runs: pd.DataFrame,
    sides: tuple[Hashable, Hashable],
    on: str,
    keys: list[str],
    names: list[str],
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Returns the runs of both sides that belong together, row by row."""
    if sides[0] == sides[1]:
        raise ValueError(f"{sides[0]!r} cannot be compared with itself")
    tables = []
    for side in sides:
        part = runs[runs[on] == side]
        if part.empty:
            known = ", ".join(map(repr, runs[on].unique()))
            raise ValueError(
                f"no run has the {on} {shown(side)}; there are {known}"
            )
        twice = part.duplicated(keys)
        if twice.any():
            first = part[twice].iloc[0][keys].to_dict()
            raise ValueError(
                f"the {on} {shown(side)} has more than one run with"
                f" {first}; name"
                " the columns in which they differ in `pair`, or choose the"
                " runs beforehand"
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
    """Returns what is told of a metric over pairs of runs."""
    both = np.isfinite(x) & np.isfinite(y)
    x, y = x[both], y[both]
    gaps = np.where(np.isclose(x, y, ROUNDING, ROUNDING), 0.0, y - x)
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


def _better(direction: str, row: dict[str, Any]) -> str:
    """Returns which of "a" and "b" is better; nothing if neither is."""
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
    for name in [*keys, *names]:
        if name not in runs:
            raise ValueError(
                f"the table of runs has no column {shown(name)};"
                f" {suggestion(str(name), list(map(str, runs.columns)))}"
            )
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
    table.attrs["units"] = {name: unit for name, unit in units.items() if unit}
    return table
