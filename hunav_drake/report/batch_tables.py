"""The tables of statistics in a report on many trials."""

from collections.abc import Iterator, Sequence
from itertools import combinations
import math

import pandas as pd

from hunav_drake.report.html import escape, number, table
from hunav_drake.report.trial_page import (
    family_of,
    name_cell,
    rows_by_family,
    unit_of,
)
from hunav_drake.results.quantity_text import unit_text
from hunav_drake.results.statistics import (
    LEAST_PAIRS,
    RATES,
    compare,
    summarize,
)

# With more planners than this only the first is compared with each other one:
# there are too many pairs.
_MOST_PLANNERS = 4


def planner_tables(runs: pd.DataFrame) -> list[str]:
    """Returns what each metric is on average for each planner.

    Args:
        runs: The table of the runs in one scenario.

    Returns:
        A table of means and intervals, and one to unfold with the spread.
    """
    planners = list(dict.fromkeys(runs["planner"]))
    metrics = _metrics(runs)
    if not metrics:
        return []
    counts = runs["planner"].value_counts()
    statistics = summarize(runs, "planner", metrics=metrics)
    means: dict[str, list[list[str]]] = {}
    spread: dict[str, list[list[str]]] = {}
    for name in metrics:
        unit, factor = _unit(runs, name)
        cells = []
        for planner in planners:
            row = statistics.loc[(planner, name)]
            cells.append(_mean(row, "mean", unit, factor))
            if 0 < row["n"] < counts[planner]:
                cells[-1] += f" <small>n&nbsp;=&nbsp;{row['n']:.0f}</small>"
            spread.setdefault(family_of(name), []).append(
                [
                    name_cell(name),
                    *([escape(planner)] if len(planners) > 1 else []),
                    f"{row['n']:.0f}",
                    _mean(row, "mean", unit, factor),
                    _number(factor * row["sd"], unit),
                    _number(factor * row["median"], unit),
                    escape(unit_text(unit)),
                ]
            )
        means.setdefault(family_of(name), []).append(
            [name_cell(name), *cells, escape(unit_text(unit))]
        )
    head = ["metric", *(escape(p or "value") for p in planners), "unit"]
    text = table(head, rows_by_family(means), numbers=range(1, len(head) - 1))
    head = ["metric", "n", "mean", "standard deviation", "median", "unit"]
    if len(planners) > 1:
        head.insert(1, "planner")
    first = head.index("n")
    more = table(
        head, rows_by_family(spread), numbers=range(first, len(head) - 1)
    )
    return [_wide(text), _folded("Spread over the runs", more)]


def paired_tables(runs: pd.DataFrame, key_metrics: Sequence[str]) -> list[str]:
    """Returns how planners differ on equal seeds.

    Args:
        runs: The table of the runs in one scenario.
        key_metrics: What is shown at once; the rest is to unfold.

    Returns:
        Nothing for a single planner or without seeds.
    """
    seeded = runs[runs["seed"] != ""]
    planners = list(dict.fromkeys(seeded["planner"]))
    if len(planners) < 2 or not _metrics(runs):
        return []
    parts = [
        "<h3>On equal seeds</h3>",
        "<p><small>The mean over pairs of runs with the same seed, and that of"
        " the differences, with its 95&nbsp;% interval in brackets. A planner"
        f" is called better from {LEAST_PAIRS} pairs on, if the interval leaves"
        " out 0. Of 20 metrics that do not differ, one seems to.</small></p>",
    ]
    for a, b in _choose_pairs(planners):
        try:
            compared = compare(seeded, a, b, metrics=_metrics(runs))
        except ValueError as error:
            parts.append(
                f"<p>{escape(a)} and {escape(b)} are not compared:"
                f" {escape(error)}.</p>"
            )
            continue
        compared = compared.droplevel("scenario")
        key = [name for name in key_metrics if name in compared.index]
        rows = [_difference(runs, name, compared.loc[name]) for name in key]
        families: dict[str, list[list[str]]] = {}
        for name, row in compared.iterrows():
            families.setdefault(family_of(str(name)), []).append(
                _difference(runs, str(name), row)
            )
        head = [
            "metric",
            *(escape(name) for name in (a, b, f"{b} \N{MINUS SIGN} {a}")),
            "pairs",
            "better",
            "unit",
        ]
        if rows:
            parts.append(_wide(table(head, rows, numbers=range(1, 5))))
        everything = table(head, rows_by_family(families), numbers=range(1, 5))
        parts.append(_folded(f"All metrics of {a} and {b}", everything))
    return parts


def _choose_pairs(planners: list[str]) -> Iterator[tuple[str, str]]:
    if len(planners) <= _MOST_PLANNERS:
        yield from combinations(planners, 2)
    else:
        yield from ((planners[0], other) for other in planners[1:])


def _difference(runs: pd.DataFrame, name: str, row: pd.Series) -> list[str]:
    unit, factor = _unit(runs, name)
    better = row["better"]
    return [
        name_cell(name),
        _number(factor * row["a"], unit),
        _number(factor * row["b"], unit),
        _mean(row, "difference", unit, factor),
        f"{row['n']:.0f}",
        "" if better is None else f"<strong>{escape(better)}</strong>",
        escape(unit_text(unit)),
    ]


def _metrics(runs: pd.DataFrame) -> list[str]:
    return [name for name in runs.attrs["units"] if name in runs]


def _unit(runs: pd.DataFrame, name: str) -> tuple[str, float]:
    """Returns the unit to show a metric in, and what to multiply it with."""
    return ("%", 100.0) if name in RATES else (unit_of(runs, name), 1.0)


def _mean(row: pd.Series, column: str, unit: str, factor: float) -> str:
    """Returns a mean with its interval."""
    ends = [factor * float(row[end]) for end in (column, "low", "high")]
    if math.isnan(ends[1]):
        return _number(ends[0], unit)
    scale = max(map(abs, ends))
    mean, low, high = (_number(end, unit, scale) for end in ends)
    return f"{mean} <small>[{low}, {high}]</small>"


def _number(value: float, unit: str, scale: float = 0.0) -> str:
    # A mean of counts is no count.
    return number(float(value), "" if unit == "-" else unit, scale=scale)


def _wide(text: str) -> str:
    return f'<div class="wide">{text}</div>'


def _folded(title: str, text: str) -> str:
    return f"<details><summary>{escape(title)}</summary>{_wide(text)}</details>"
