"""Tables of a suite, planners side by side, and as text."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import math

import pandas as pd

from hunav_drake.runs.comparison.paper import (
    METRICS,
    PUBLISHED_BY_BEHAVIOR,
    printed_values,
)
from hunav_drake.runs.outcomes import count_outcomes, outcome_text
from hunav_drake.runs.statistics import early_mark, is_rate, summarize
from hunav_drake.runs.suite_result import SuiteResult
from hunav_drake.systems.evaluation.metric import DERIVED_FAMILIES, base_name
from hunav_drake.systems.evaluation.metrics import METRICS as KNOWN
from hunav_drake.trial.metric_facts import family_of, unit_of
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


def by_place(runs: pd.DataFrame) -> Iterator[tuple[str, str, pd.DataFrame]]:
    """Yields each scenario and setting, with its runs."""
    if runs.empty:
        return
    keys = ["scenario", "setting"]
    for (scenario, setting), part in runs.groupby(keys, sort=False):
        part.attrs = runs.attrs
        yield scenario, setting, part


def scenario_tables(result: SuiteResult) -> list[Table]:
    """Returns a table for each scenario and setting: metrics by planner.

    For cells see `mean_text`. The paper's suite also has the paper's values.
    """
    tables = []
    for scenario, setting, runs in by_place(result.runs()):
        published = printed_values(result.suite.name, scenario)
        title = " ".join(filter(None, (scenario, setting)))
        names = (*PAPER_METRICS, *scores(runs))
        tables.append(_table(title, runs, names, published))
    return [table for table in tables if table]


def behavior_tables(result: SuiteResult) -> list[Table]:
    """Returns a table for each behavior, if there are several (Table IV)."""
    tables = []
    for scenario, setting, runs in by_place(result.runs(by_behavior=True)):
        behaviors = runs.behavior.unique()
        for behavior in behaviors if len(behaviors) > 1 else ():
            rows = runs[runs.behavior == behavior]
            rows.attrs = runs.attrs
            published = printed_values(result.suite.name, scenario, behavior)
            place = " ".join(filter(None, (scenario, setting)))
            title = f"{place}, {behavior} people"
            tables.append(_table(title, rows, _BEHAVIOR_METRICS, published))
    return [table for table in tables if table]


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


def scores(runs: pd.DataFrame) -> list[str]:
    """Returns the numbers of runs that kinds of scenarios have."""
    return [
        it
        for it in runs.attrs["units"]
        if base_name(it) not in KNOWN
        and family_of(runs, it) not in DERIVED_FAMILIES
        and runs[it].notna().any()
    ]


def shown_unit(runs: pd.DataFrame, metric: str) -> str:
    """Returns the unit of a metric in tables: rates are in percent."""
    return "%" if is_rate(metric) else unit_of(runs, metric)


def mean_text(described: pd.Series, metric: str, unit: str) -> str:
    """Returns the text of a metric in a cell.

    It has the mean, half the width of its 95 % interval (for rates, the
    interval), n in brackets, and perhaps an asterisk: see `NOTE`.

    Args:
        described: A row of `summarize`.
        metric: The name of the metric.
        unit: The unit in which it is shown.
    """
    scale = 100.0 if is_rate(metric) else 1.0
    mean, low, high = (
        scale * float(described[key]) for key in ("mean", "low", "high")
    )
    half = (high - low) / 2
    text = number_text(mean, unit)
    if is_rate(metric):
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
