"""How planners, or anything else, compare over many runs."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from hunav_drake.plots.style import (
    PALETTE,
    SMALL_SIZE,
    new_axes,
    note,
    shown,
)
from hunav_drake.results import TrialResult
from hunav_drake.statistics import summarize
from hunav_drake.systems.evaluation.metrics import METRICS

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_comparison(
    runs: pd.DataFrame | Iterable[TrialResult],
    metric: str,
    *,
    by: str = "planner",
    ax: "Axes | None" = None,
) -> "Axes":
    """Draws the mean of a metric over runs, with its 95 % interval, as bars.

    The dots are the single runs. What has no value does not count. See
    `hunav_drake.statistics.summarize`.

    Args:
        runs: Results, or a table with a row per run, such as `metrics.csv`.
        metric: A column of the table.
        by: The column that tells what is compared; a bar for each value.
        ax: Where to draw; by default a new figure.

    Raises:
        ValueError: If the table does not have such columns.
    """
    table = runs if isinstance(runs, pd.DataFrame) else run_table(runs)
    statistics = summarize(table, [by], metrics=[metric]).droplevel("metric")
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
        samples = table.loc[table[by] == name, metric].dropna()
        # Side by side, so that equal ones are not hidden.
        spread = np.linspace(-0.2, 0.2, len(samples) + 2)[1:-1]
        ax.plot(samples, row + spread, ".", ms=3, color="0.25", mew=0)
        if pd.notna(values["low"]) and pd.notna(values["high"]):
            ax.errorbar(
                values["mean"],
                row,
                xerr=[
                    [values["mean"] - values["low"]],
                    [values["high"] - values["mean"]],
                ],
                color="black",
                lw=1.2,
                capsize=3,
            )
    if statistics["mean"].isna().all():
        note(ax, "there are no values")
    units = table.attrs.get("units", {})
    unit = METRICS[metric].unit if metric in METRICS else units.get(metric, "-")
    values = table[metric].to_numpy(dtype=float)
    if not (values < 0).any():
        # Where all is 0, there still is a scale.
        ax.set_xlim(left=0, right=None if (values > 0).any() else 1)
    ax.set(
        xlabel=metric if unit == "-" else f"{metric} ({_unit(unit)})",
        yticks=rows,
        ylim=(len(rows) - 0.5, -0.5),
    )
    ax.set_yticklabels(
        [shown(str(name)) for name in statistics.index],
        fontsize=SMALL_SIZE,
        parse_math=False,
    )
    ax.tick_params(axis="y", length=0)
    return ax


def comparison_height(bars: int) -> float:
    """Returns the height of a figure with so many bars, in inches."""
    return 0.55 + 0.24 * max(2, bars)


def run_table(results: Iterable[TrialResult]) -> pd.DataFrame:
    """Returns a table with a row per run: what it is, and its metrics.

    The units of the metrics are in `attrs["units"]`.
    """
    rows = []
    units: dict[str, str] = {}
    for result in results:
        units |= result.metrics.attrs.get("units", {})
        rows.append(
            {
                "scenario": result.scenario_name,
                "planner": str(result.provenance.get("planner", "")),
                "seed": result.provenance.get("seed", ""),
                "end_reason": result.end_reason,
                "end_time": result.end_time,
            }
            | result.metrics.to_dict()
        )
    table = pd.DataFrame(rows)
    table.attrs["units"] = units
    return table


def _unit(unit: str) -> str:
    return unit.replace("^2", "²").replace("^3", "³")
