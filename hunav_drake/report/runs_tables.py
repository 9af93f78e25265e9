"""The tables of statistics in a report on several runs."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
import math
from typing import Any

import pandas as pd

from hunav_drake.report.tables import (
    Cell,
    Estimate,
    Marked,
    MetricRows,
    Table,
    metric_cell,
    number,
)
from hunav_drake.runs.independent_runs import comparable
from hunav_drake.runs.statistics import compare, early_mark, is_rate, summarize
from hunav_drake.systems.evaluation.metric import LEAST_GAP, base_name
from hunav_drake.trial.metric_facts import headline_of, unit_of
from hunav_drake.trial.quantity_text import label_text

# With more contenders (planners with their settings), only the first one is
# compared with the others, to limit the number of pairs.
_MOST_CONTENDERS = 4

# The values of a paper, by planner and metric.
Printed = Mapping[str, Mapping[str, float]]


# What runs without a name of planner or scenario are called.
_ALL, _TRIALS = "all", "trials"

# What robots do to people, besides the least gap.
_RESPONSIBILITY = ("aggregated_time", "contacts_charged")


def headline_table(
    runs: pd.DataFrame, metrics: Sequence[str] | None = None
) -> Table:
    """Returns the headline metrics of each contender in each scenario.

    They are means over runs, with confidence intervals.

    Args:
        runs: The runs, with the column `contender`.
        metrics: Other metrics instead.
    """
    if metrics is None:
        metrics = headline_of(runs)
    keys = ["scenario", "contender"]
    counts = runs.groupby(keys, sort=False).size()
    statistics = pd.DataFrame()
    if metrics:
        statistics = summarize(runs, keys, metrics=metrics, bounded=True)
    groups: dict[str, list[list[Cell]]] = {}
    for (scenario, contender), count in counts.items():
        row: list[Cell] = [contender or _ALL, str(count)]
        for name in metrics:
            described = statistics.loc[(scenario, contender, name)]
            row.append(_mean(described, name, *_unit(runs, name), count))
        groups.setdefault(scenario or _TRIALS, []).append(row)
    head: list[Cell] = ["planner", "runs"]
    for name in metrics:
        cell = metric_cell(runs, name)
        unit = _unit(runs, name)[0]
        label = label_text(name.replace("_", " "), unit)
        head.append(cell._replace(name=label))
    return Table(head, groups, numbers=range(1, len(head)), kind="headline")


def responsibility_table(
    runs: pd.DataFrame, links: Mapping[Any, Mapping[str, str]]
) -> Table | None:
    """Returns the delays of people, contacts, and the worst encounters.

    An encounter is worst where the gap of robot and person is least.

    Args:
        runs: The runs, with the column `contender`.
        links: The addresses of the pages of runs, by index and kind.

    Returns:
        A row for each contender in each scenario; None where runs have neither
        relative metrics nor those of encounters.
    """
    found = [it for it in runs if base_name(it) in _RESPONSIBILITY]
    gaps = [it for it in runs if base_name(it) == LEAST_GAP]
    if not found and not gaps:
        return None
    table = headline_table(runs, found)
    if not gaps:
        return table
    worst: dict[tuple[str, Cell], Cell] = {}
    least = (
        runs[gaps].min(axis=1).groupby([runs["scenario"], runs["contender"]])
    )
    for (scenario, contender), own in least:
        cell: Cell = number(math.nan)
        if own.notna().any():
            i = own.idxmin()
            text, seed = f"{number(own[i], 'm')} m", runs.at[i, "seed"]
            text += f", seed {seed}" if seed != "" else ""
            page = links.get(i, {}).get("replay")
            cell = {text: page} if page else text
        worst[scenario or _TRIALS, contender or _ALL] = cell
    groups = {
        scenario: [[*row, worst[scenario, row[0]]] for row in rows]
        for scenario, rows in table.groups.items()
    }
    head = [*table.head, "worst encounter: gap"]
    return replace(table, head=head, groups=groups)


def planner_tables(
    runs: pd.DataFrame, printed: Printed
) -> tuple[Table, Table] | None:
    """Returns the mean of each metric for each planner, and its spread.

    Args:
        runs: The runs in one scenario, with the column `contender`.
        printed: The values of a paper, for extra columns.

    Returns:
        The table of means with confidence intervals, and the table of counts,
        means, standard deviations and medians; None without metrics.
    """
    planners = list(dict.fromkeys(runs["contender"]))
    metrics = _metrics(runs)
    if not metrics:
        return None
    several = len(planners) > 1
    counts = runs["contender"].value_counts()
    statistics = summarize(runs, "contender", metrics=metrics, bounded=True)
    means, spread = MetricRows(runs), MetricRows(runs)
    for name in metrics:
        unit, factor = _unit(runs, name)
        cells: list[Cell] = []
        for planner in planners:
            row = statistics.loc[(planner, name)]
            mean = _mean(row, name, unit, factor, counts[planner])
            cells.append(mean)
            if planner in printed:
                value = printed[planner].get(name, math.nan)
                cells.append(Marked(number(value, unit), "printed"))
            more: list[Cell] = [
                f"{row['n']:.0f}",
                mean._replace(n=""),
                _number(factor * row["sd"], unit),
                _number(factor * row["median"], unit),
            ]
            spread.add(name, [planner, *more] if several else more, unit)
        means.add(name, cells, unit)
    heads: list[Cell] = []
    for planner in planners:
        heads.append(planner or "value")
        heads += ["paper"] if planner in printed else []
    columns: list[Cell] = ["n", "mean", "standard deviation", "median"]
    if several:
        columns.insert(0, "planner")
    return (_table(heads, means), _table(columns, spread, first=1 + several))


def paired_tables(
    runs: pd.DataFrame, key_metrics: Sequence[str]
) -> list[dict[str, Any]]:
    """Returns the differences between planners on equal seeds.

    Returns:
        For each pair of planners, `a` and `b`: either the `problem` of the
        comparison, or the tables `key_metrics` and `all_metrics`. Empty for a
        single planner or without seeds.
    """
    seeded = comparable(runs, "contender")
    planners = list(dict.fromkeys(seeded["contender"]))
    metrics = _metrics(runs)
    if len(planners) < 2 or not metrics:
        return []
    found: list[dict[str, Any]] = []
    for a, b in _choose_pairs(planners):
        pair: dict[str, Any] = {"a": a, "b": b, "problem": ""}
        found.append(pair)
        try:
            compared = compare(seeded, a, b, on="contender", metrics=metrics)
        except ValueError as error:
            pair["problem"] = str(error)
            continue
        compared = compared.droplevel("scenario")
        key = [name for name in key_metrics if name in compared.index]
        few = MetricRows(runs, by_family=False)
        pair["key_metrics"] = _differences(few, compared.loc[key], a, b)
        pair["verdict"] = _verdict(compared.loc[key, "better"], a, b)
        pair["all_metrics"] = _differences(MetricRows(runs), compared, a, b)
    return found


def ambiguous_seeds(runs: pd.DataFrame) -> list[dict[str, Any]]:
    """Returns the seeds for which a contender has several different runs.

    Each entry has the `contender`, its `seeds`, and the `tags` of the runs.
    """
    seeded = runs[runs["seed"] != ""]
    several = seeded[seeded.duplicated(_run_keys(runs), keep=False)]
    return [
        {
            "contender": contender,
            "seeds": list(dict.fromkeys(own["seed"])),
            "tags": list(own["tag"]) if "tag" in own else [],
        }
        for contender, own in several.groupby("contender", sort=False)
    ]


def _run_keys(runs: pd.DataFrame) -> list[str]:
    """Returns the columns that identify a run in one scenario."""
    return ["contender", "seed", *(["repetition"] * ("repetition" in runs))]


def _choose_pairs(planners: list[str]) -> Iterator[tuple[str, str]]:
    if len(planners) <= _MOST_CONTENDERS:
        yield from combinations(planners, 2)
    else:
        yield from ((planners[0], other) for other in planners[1:])


def _verdict(better: pd.Series, a: str, b: str) -> str:
    """Returns the numbers of metrics in which each of two is better."""
    counts = [(name, int((better == name).sum())) for name in (a, b)]
    told = [f"{name} is better in {n}" for name, n in counts if n]
    words = ", ".join(told) or "neither is better in any"
    return f"{words} of {len(better)} metrics"


def _differences(
    rows: MetricRows, compared: pd.DataFrame, a: str, b: str
) -> Table:
    for name, row in compared.iterrows():
        unit, factor = _unit(rows.metrics, str(name))
        cells: list[Cell] = [
            _number(factor * row["a"], unit),
            _number(factor * row["b"], unit),
            _estimate(row, "difference", unit, factor),
            f"{row['n']:.0f}" + ("" if row["pairs"] == "all" else " arriving"),
            row["better"] or "",
        ]
        rows.add(str(name), cells, unit)
    columns: list[Cell] = [a, b, f"{b} \N{MINUS SIGN} {a}", "pairs", "better"]
    return _table(columns, rows, last=4, kind="paired")


def _table(
    columns: Sequence[Cell],
    rows: MetricRows,
    *,
    first: int = 1,
    last: int | None = None,
    kind: str = "",
) -> Table:
    """Returns a table of metrics with numbers in some of its columns."""
    head: list[Cell] = ["metric", *columns, "unit"]
    numbers = range(first, 1 + (len(columns) if last is None else last))
    return Table(head, rows.groups, numbers=numbers, kind=kind)


def _metrics(runs: pd.DataFrame) -> list[str]:
    return [name for name in runs.attrs["units"] if name in runs]


def _unit(runs: Any, name: str) -> tuple[str, float]:
    """Returns the unit in which a metric is shown, and the factor to it."""
    return ("%", 100.0) if is_rate(name) else (unit_of(runs, name), 1.0)


def _estimate(
    row: pd.Series, column: str, unit: str, factor: float
) -> Estimate:
    ends = [factor * float(row[end]) for end in (column, "low", "high")]
    if math.isnan(ends[1]):
        return Estimate(_number(ends[0], unit))
    scale = max(map(abs, ends))
    return Estimate(*(_number(end, unit, scale) for end in ends))


def _mean(
    row: pd.Series, name: str, unit: str, factor: float, count: int
) -> Estimate:
    """Returns a mean, with its number of runs if some have no value."""
    mean = _estimate(row, "mean", unit, factor)
    n = f"{row['n']:.0f}" if 0 < row["n"] < count else ""
    return mean._replace(text=mean.text + early_mark(name, row), n=n)


def _number(value: float, unit: str, scale: float = 0.0) -> str:
    # The mean of counts may not be whole.
    return number(float(value), "" if unit == "-" else unit, scale=scale)
