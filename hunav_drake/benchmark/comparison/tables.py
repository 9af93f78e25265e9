"""Tables of a suite, planners side by side, and as text."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import pandas as pd

from hunav_drake.benchmark.comparison.paper import (
    METRICS,
    PUBLISHED,
    PUBLISHED_BY_BEHAVIOR,
)
from hunav_drake.benchmark.comparison.relations import Judgement
from hunav_drake.benchmark.suite_result import SuiteResult
from hunav_drake.results.metric_facts import unit_of
from hunav_drake.results.quantity_text import number_text, unit_text
from hunav_drake.results.statistics import RATES, summarize

# What the tables of a suite show: those of the paper, which most people know.
PAPER_METRICS = tuple(name for name, _, _ in METRICS)

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

    A cell is the mean and half the width of its 95 % interval, or, of rates,
    the interval; beside it, for the paper's own suite, is the value that the
    paper printed.
    """
    runs = result.runs()
    if runs.empty:
        return []
    is_paper = result.suite.name == "paper"
    keys = dict.fromkeys((c.scenario, c.setting) for c in result.cells)
    tables = []
    for scenario, setting in keys:
        part = runs[(runs.scenario == scenario) & (runs.setting == setting)]
        part.attrs = runs.attrs
        published = PUBLISHED.get(scenario, {}) if is_paper else {}
        title = " ".join(word for word in (scenario, setting) if word)
        table = _table(title, part, PAPER_METRICS, published)
        tables += [table] if table else []
    return tables


def behavior_tables(result: SuiteResult) -> list[Table]:
    """Returns, where people differ, a table for each behavior (Table IV)."""
    runs = result.runs(by_behavior=True)
    if runs.empty:
        return []
    is_paper = result.suite.name == "paper"
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
            published = (
                PUBLISHED_BY_BEHAVIOR.get(behavior, {})
                if is_paper and scenario == "combined"
                else {}
            )
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
    rows = []
    for name in names:
        unit = "%" if name == "completed" else unit_of(runs, name)
        scale = 100.0 if name == "completed" else 1.0
        row = [name]
        for planner in planners:
            described = statistics.loc[planner, name]
            row.append(_cell(described, unit, scale, is_rate=name in RATES))
            if planner in published:
                value = published[planner].get(name, math.nan)
                row.append(number_text(value, unit))
        rows.append((*row, unit_text(unit)))
    return Table(title, (*header, "unit"), tuple(rows))


def _cell(
    described: pd.Series, unit: str, scale: float, *, is_rate: bool
) -> str:
    mean, low, high = (
        scale * float(described[key]) for key in ("mean", "low", "high")
    )
    half = (high - low) / 2
    text = number_text(mean, unit)
    if is_rate and math.isfinite(half):
        # It does not reach as far to both sides.
        return f"{text} [{low:.0f}, {high:.0f}]"
    if math.isfinite(half) and half > 0:
        text += f" ± {number_text(half, unit, scale=abs(mean))}"
    return text


def relation_table(judgements: Sequence[Judgement]) -> Table:
    """Returns the relations as a list of what holds and what fails."""
    return Table(
        "relations",
        ("", "scenario", "relation", "strength", "verdict", "share", "numbers"),
        tuple(
            (
                str(it.number),
                it.scenarios,
                " ".join(it.text.split()),
                it.strength,
                it.verdict,
                "" if math.isnan(it.share) else f"{it.share:.2f}",
                it.numbers,
            )
            for it in judgements
        ),
    )


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
