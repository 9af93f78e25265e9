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

# The metrics in the tables of a suite: those of the paper.
PAPER_METRICS = tuple(name for name, _, _ in METRICS)

# The legend of a cell.
NOTE = (
    "In brackets: n, the number of seeds. * Not all of these runs arrive, so"
    " the mean includes paths that end early."
)

# The row of end reasons.
ENDS = "ends"

_BEHAVIOR_METRICS = tuple(PUBLISHED_BY_BEHAVIOR["regular"]["dwb"])


@dataclass(frozen=True)
class Table:
    """A table of texts.

    Attributes:
        title: The title.
        header: The names of the columns.
        rows: The cells; the first is the name of the row.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def scenario_tables(result: SuiteResult) -> list[Table]:
    """Returns a table for each scenario and setting: metrics by planner.

    For cells see `mean_text`. The paper's suite also has the paper's values.
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
    """Returns a table for each behavior, if there are several (Table IV)."""
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
    """Returns the unit of a metric in tables: rates are in percent."""
    return "%" if metric in RATES else unit_of(runs, metric)


def mean_text(described: pd.Series, metric: str, unit: str) -> str:
    """Returns the text of a metric in a cell.

    It has the mean, half the width of its 95 % interval (for rates, the
    interval), n in brackets, and perhaps an asterisk: see `NOTE`.

    Args:
        described: A row of `summarize`.
        metric: The name of the metric.
        unit: The unit in which it is shown.
    """
    scale = 100.0 if metric in RATES else 1.0
    mean, low, high = (
        scale * float(described[key]) for key in ("mean", "low", "high")
    )
    half = (high - low) / 2
    text = number_text(mean, unit)
    if metric in RATES:
        text = text.removesuffix(".0")
        # This interval is not symmetric.
        text += f" [{low:.0f}, {high:.0f}]" * math.isfinite(half)
    elif math.isfinite(half) and half > ROUNDING * max(1.0, abs(mean)):
        reach = number_text(half, unit, scale=abs(mean))
        if float(reach) == 0:
            # More decimals than those of the mean are better than 0.
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
