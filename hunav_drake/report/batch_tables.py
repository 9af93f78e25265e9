"""The tables of statistics in a report on many trials."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations
import math

import pandas as pd

from hunav_drake.report.html import escape, number, table, wide
from hunav_drake.report.trial_page import name_cell, rows_by_family
from hunav_drake.results.metric_facts import family_of, unit_of
from hunav_drake.results.quantity_text import unit_text
from hunav_drake.results.statistics import (
    LEAST_PAIRS,
    RATES,
    compare,
    summarize,
)

# With more contenders than this only the first is compared with each other
# one: there are too many pairs.
_MOST_CONTENDERS = 4

# How many tags and seeds are listed of those that are to be named.
_MOST_LISTED = 5


def planner_tables(runs: pd.DataFrame) -> list[str]:
    """Returns what each metric is on average for each planner.

    Args:
        runs: The table of the runs in one scenario; the column `contender`
            tells planners and their settings apart.

    Returns:
        A table of means and intervals, and one to unfold with the spread.
    """
    planners = list(dict.fromkeys(runs["contender"]))
    metrics = _metrics(runs)
    if not metrics:
        return []
    counts = runs["contender"].value_counts()
    statistics = summarize(runs, "contender", metrics=metrics)
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
            spread.setdefault(family_of(runs, name), []).append(
                [
                    name_cell(runs, name),
                    *([escape(planner)] if len(planners) > 1 else []),
                    f"{row['n']:.0f}",
                    _mean(row, "mean", unit, factor),
                    _number(factor * row["sd"], unit),
                    _number(factor * row["median"], unit),
                    escape(unit_text(unit)),
                ]
            )
        means.setdefault(family_of(runs, name), []).append(
            [name_cell(runs, name), *cells, escape(unit_text(unit))]
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
    return [wide(text), _folded("Spread over the runs", more)]


def paired_tables(runs: pd.DataFrame, key_metrics: Sequence[str]) -> list[str]:
    """Returns how planners differ on equal seeds.

    Args:
        runs: The table of the runs in one scenario, as for `planner_tables`.
        key_metrics: What is shown at once; the rest is to unfold.

    Returns:
        Nothing for a single planner or without seeds.
    """
    seeded = runs[runs["seed"] != ""]
    # Nobody can tell which of several runs to compare.
    seeded = seeded[~seeded.duplicated(["contender", "seed"], keep=False)]
    planners = list(dict.fromkeys(seeded["contender"]))
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
            compared = compare(
                seeded, a, b, on="contender", metrics=_metrics(runs)
            )
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
            families.setdefault(family_of(runs, str(name)), []).append(
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
            parts.append(wide(table(head, rows, numbers=range(1, 5))))
        everything = table(head, rows_by_family(families), numbers=range(1, 5))
        parts.append(_folded(f"All metrics of {a} and {b}", everything))
    return parts


def ambiguous_seeds(runs: pd.DataFrame) -> list[str]:
    """Returns a note for each contender with several runs of one seed.

    Args:
        runs: The table of the runs in one scenario, as for `planner_tables`.
    """
    seeded = runs[runs["seed"] != ""]
    several = seeded[seeded.duplicated(["contender", "seed"], keep=False)]
    notes = []
    for contender, own in several.groupby("contender", sort=False):
        seeds = list(dict.fromkeys(own["seed"]))
        who = f"{escape(contender)} has" if contender else "There are"
        which = f"seed{'s' * (len(seeds) > 1)} {listed(seeds)}"
        tags = f": {listed(own['tag'])}" if own["tag"].any() else ""
        notes.append(
            f"<p><strong>{who} several different runs of {which}</strong>"
            f"{tags}. All of them count in the means, and none on equal seeds."
            " Was something changed between them, such as the scenario? Runs"
            " with a label of their own (<code>hunav run --label</code>) are"
            " told apart.</p>"
        )
    return notes


def listed(things: Iterable[object]) -> str:
    """Returns the first of some things, and how many more there are."""
    texts = [escape(thing) for thing in things]
    more = len(texts) - _MOST_LISTED
    told = ", ".join(texts[:_MOST_LISTED])
    return f"{told} and {more} more" if more > 0 else told


def _choose_pairs(planners: list[str]) -> Iterator[tuple[str, str]]:
    if len(planners) <= _MOST_CONTENDERS:
        yield from combinations(planners, 2)
    else:
        yield from ((planners[0], other) for other in planners[1:])


def _difference(runs: pd.DataFrame, name: str, row: pd.Series) -> list[str]:
    unit, factor = _unit(runs, name)
    better = row["better"]
    return [
        name_cell(runs, name),
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


def _folded(title: str, text: str) -> str:
    return f"<details><summary>{escape(title)}</summary>{wide(text)}</details>"
