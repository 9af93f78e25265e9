"""Statistics of the runs in the editor's table."""

from collections.abc import Sequence
import math
from typing import Any

import pandas as pd

from hunav_drake.runs.run_row import plain_number
from hunav_drake.runs.statistics import summarize
from hunav_drake.systems.evaluation.metric import base_name
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.trial.quantity_text import number_text


def value_text(metric: str, value: float) -> str:
    """Returns the text of a value in tables."""
    known = METRICS.get(base_name(metric))
    return number_text(float(value), known.unit if known else "")


def summary_rows(runs: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Returns mean and interval of each metric over the runs of a planner.

    Args:
        runs: The "planner" and "metrics" of each run, and perhaps "drawn".

    Returns:
        A row for each planner and metric with values: n, mean, low and high
        (95 %), and their texts.
    """
    values = [
        {
            name: math.nan if value is None else float(value)
            for name, value in run["metrics"].items()
        }
        for run in runs
    ]
    table = pd.DataFrame(values)
    metrics = [name for name in table.columns if table[name].notna().any()]
    if not metrics:
        return []
    table.insert(0, "planner", [run["planner"] for run in runs])
    table.insert(1, "drawn", [run.get("drawn") or "" for run in runs])
    summary = summarize(table, by="planner", metrics=metrics, bounded=True)
    rows = []
    for (planner, metric), row in summary.iterrows():
        numbers = {
            key: plain_number(float(row[key]))
            for key in ("mean", "low", "high")
        }
        texts = {
            f"{key}_text": value_text(metric, float(row[key]))
            for key in numbers
        }
        rows.append(
            {
                "planner": planner,
                "metric": metric,
                "n": int(row["n"]),
                **numbers,
                **texts,
            }
        )
    return rows
