"""Tables of a suite, planners side by side, and as text."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import pandas as pd

from hunav_drake.runs.comparison.paper import (
    METRICS,
    PUBLISHED_BY_BEHAVIOR,
    printed_values,
)
from hunav_drake.runs.outcomes import count_outcomes, outcome_text
from hunav_drake.runs.statistics import RATES, early_mark, summarize
from hunav_drake.runs.suite_result import SuiteResult
from hunav_drake.trial.metric_facts import unit_of
from hunav_drake.trial.quantity_text import ROUNDING, number_text, unit_text

# What the tables of a suite show: those of the paper, which most people know.
PAPER_METRICS = tuple(name for name, _, _ in METRICS)

# How a cell is to be read.
NOTE = (
    "In brackets: n, over how many seeds a mean is. * Not all of these runs"
    " arrive, so the mean is also of ways that end early."
)

# The row that tells for which reasons runs ended.
ENDS = "ends"

_BEHAVIOR_METRICS = tuple(PUBLISHED_BY_BEHAVIOR["regular"]["dwb"])


@dataclass(frozen=True)
class Table:
    """A table as texts.

    Attributes:
        title: What it is about.
        header: The names of the columns.
        rows: The cells; the first is the name of the row.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def scenario_tables(result: SuiteResult) -> list[Table]:
    """Returns a table for each scenario and setting: metrics by planner.

    A cell is as `mean_text` tells; beside it, for the paper's own suite, is the
    value that the paper printed.
    """
    runs = result.runs()
    if runs.empty:
        return []
    keys = dict.fromkeys((c.scenario, c.setting) for c in result.cells)
    tables = []
    for scenario, setting in keys:
        part = runs[(runs.scenario == scenario) & (runs.setting == setting)]
        if part.empty:
            continue
        part.attrs = runs.attrs
        published = printed_values(result.suite.name, scenario)
        title = " ".join(word for word in (scenario, setting) if word)
        table = _table(title, part, PAPER_METRICS, published)
        tables += [table] if table else []
    return tables


def behavior_tables(result: SuiteResult) -> list[Table]:
    """Returns, where people differ, a table for each behavior (Table IV)."""
    runs = result.runs(by_behavior=True)
    if runs.empty:
        return []
    tables = []
    for scenario, setting in dict.fromkeys(
        zip(runs.scenario, runs.setting, strict=True)
    ):
        part = runs[(runs.scenario == scenario) & (runs.setting == setting)]
        behaviors = part.behavior.unique()
        if len(behaviors) < 2:
            continue
        for behavior in behaviors:
            rows = part[part.behavior == behavior]
            rows.attrs = runs.attrs
            name = result.suite.name
            published = printed_values(name, scenario, behavior)
            place = " ".join(word for word in (scenario, setting) if word)
            title = f"{place}, {behavior} people"
            table = _table(title, rows, _BEHAVIOR_METRICS, published)
            tables += [table] if table else []
    return tables


def _table(
    title: str,
    runs: pd.DataFrame,
    metrics: Sequence[str],
    published: dict[str, dict[str, float]],
) -> Table | None:
    names = [name for name in metrics if name in runs.columns]
    if not names:
        return None
    planners = list(dict.fromkeys(runs.planner))
    statistics = summarize(runs, "planner", metrics=names)
    header = [""]
    for planner in planners:
        header += [planner] + (["paper"] if planner in published else [])
    rows: list[tuple[str, ...]] = []
    for name in names:
        unit = shown_unit(runs, name)
        row = [name]
        for planner in planners:
            row.append(mean_text(statistics.loc[planner, name], name, unit))
            if planner in published:
                value = published[planner].get(name, math.nan)
                row.append(number_text(value, unit))
        rows.append((*row, unit_text(unit)))
    if "behavior" not in runs:
        ends = count_outcomes(runs, ["planner"])
        row = [ENDS]
        for planner in planners:
            row.append(outcome_text(ends[ends.planner == planner]))
            row += ["-"] * (planner in published)
        rows.append((*row, ""))
    return Table(title, (*header, "unit"), tuple(rows))


def shown_unit(runs: pd.DataFrame, metric: str) -> str:
    """Returns the unit that tables show a metric in: rates are in percent."""
    return "%" if metric in RATES else unit_of(runs, metric)


def mean_text(described: pd.Series, metric: str, unit: str) -> str:
    """Returns what tables tell of a metric in a cell.

    It is the mean, half the width of its 95 % interval, or, of rates, the
    interval, and n in brackets; an asterisk as `NOTE` explains it.

    Args:
        described: A row of `summarize`.
        metric: Its name.
        unit: The unit to show it in.
    """
    scale = 100.0 if metric in RATES else 1.0
    mean, low, high = (
        scale * float(described[key]) for key in ("mean", "low", "high")
    )
    half = (high - low) / 2
    text = number_text(mean, unit)
    if metric in RATES:
        text = text.removesuffix(".0")
        # It does not reach as far to both sides.
        text += f" [{low:.0f}, {high:.0f}]" * math.isfinite(half)
    elif math.isfinite(half) and half > ROUNDING * max(1.0, abs(mean)):
        reach = number_text(half, unit, scale=abs(mean))
        if float(reach) == 0:
            # Other decimals than those of the mean are better than none.
            reach = number_text(half)
        text += f" \N{PLUS-MINUS SIGN} {reach}"
    mark = early_mark(metric, described)
    return f"{text} ({described['n']:.0f}){mark}"


def to_text(table: Table) -> str:
    """Returns a table for a terminal."""
    rows = [table.header, *table.rows]
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = [table.title]
    for row in rows:
        first, *others = (
            text.ljust(width) if i == 0 else text.rjust(width)
            for i, (text, width) in enumerate(zip(row, widths, strict=True))
        )
        lines.append("  ".join([first, *others]).rstrip())
    return "\n".join(lines)
