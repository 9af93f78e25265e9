"""Bar charts to compare planners over runs."""

from collections.abc import Iterable

import numpy as np
import pandas as pd

from hunav_drake.report.plots.style import (
    PALETTE,
    Axes,
    label_rows,
    new_axes,
    note,
    shown,
)
from hunav_drake.runs.independent_runs import draws_nothing
from hunav_drake.runs.run_table import tabulate_runs
from hunav_drake.runs.settings import contenders
from hunav_drake.runs.statistics import is_rate, summarize
from hunav_drake.trial.metric_facts import unit_of
from hunav_drake.trial.quantity_text import label_text
from hunav_drake.trial.result import TrialResult

# With more runs, dots would hide each other.
_MOST_DOTS = 200


def plot_comparison(
    runs: pd.DataFrame | Iterable[TrialResult],
    metric: str,
    *,
    by: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draws bars of a metric's mean over runs, with confidence intervals.

    The intervals are 95 % intervals. Dots are single runs, for at most 200
    runs per bar. Runs without a value do not count. Rates are in percent. Runs
    whose seeds draw nothing count once, without an interval, and with a note.
    See `hunav_drake.runs.statistics.summarize`.

    Args:
        runs: Results, or a table with a row per run: see `ReadRuns`.
        metric: A column of the table.
        by: The column to compare, with a bar for each value. By default
            planners, with separate settings.
        ax: Where to draw; by default a new figure.

    Raises:
        ValueError: If the table has no such column.
    """
    table = runs if isinstance(runs, pd.DataFrame) else tabulate_runs(runs)
    if by is None:
        by = "planner"
        if by in table:
            table = table.assign(planner=contenders(table))
    statistics = summarize(table, by, metrics=metric, bounded=True)
    statistics = statistics.droplevel("metric")
    unit = unit_of(table, metric)
    if is_rate(metric):
        unit = "%"
        table = table.assign(**{metric: 100.0 * table[metric]})
        statistics[["mean", "low", "high"]] *= 100.0
    ax = new_axes(ax, comparison_height(len(statistics)))
    rows = np.arange(len(statistics))
    ax.barh(
        rows,
        statistics["mean"].fillna(0.0),
        height=0.62,
        color=[PALETTE[i % len(PALETTE)] for i in rows],
        alpha=0.55,
    )
    for row, (name, values) in zip(rows, statistics.iterrows(), strict=True):
        samples = table.loc[table[by] == name, metric]
        samples = samples[np.isfinite(samples)]
        if len(samples) > _MOST_DOTS:
            samples = samples[:0]
        # Shifted, so that equal values do not hide each other.
        spread = np.linspace(-0.2, 0.2, len(samples) + 2)[1:-1]
        ax.plot(samples, row + spread, ".", ms=3, color="0.25", mew=0)
        if pd.notna(values["low"]) and pd.notna(values["high"]):
            ax.errorbar(
                values["mean"],
                row,
                # A float is not always the mean of its copies.
                xerr=[
                    [max(0.0, values["mean"] - values["low"])],
                    [max(0.0, values["high"] - values["mean"])],
                ],
                color="black",
                lw=1.2,
                capsize=3,
            )
    if statistics["mean"].isna().all():
        note(ax, "there are no values")
    values = table[metric].to_numpy(dtype=float)
    if not (values < 0).any():
        # An axis needs a length even if all values are 0.
        ax.set_xlim(left=0, right=None if (values > 0).any() else 1)
    # A long name has more room when it is aligned to the right.
    ax.set_xlabel(label_text(metric, unit), loc="right")
    # A planner, and below it its setting.
    names = [str(name).split(", ", 1) for name in statistics.index]
    fixed = draws_nothing(table).groupby(table[by]).all()
    for name, parts in zip(statistics.index, names, strict=True):
        parts += ["all seeds alike"] * bool(fixed[name])
    label_rows(ax, ["\n".join(map(shown, parts)) for parts in names])
    return ax


def comparison_height(bars: int) -> float:
    """Returns the height of the figure for a number of bars, in inches."""
    return 0.55 + 0.24 * max(2, bars)
