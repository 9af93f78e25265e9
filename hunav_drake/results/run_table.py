"""The table of runs: a row per run, what it was and its metrics."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pandas as pd

from hunav_drake.results.metric_facts import FACTS
from hunav_drake.results.trial_result import TrialResult

# The columns that are no metrics. Tables by behavior have the last one too.
ABOUT = (
    "tag",
    "scenario",
    "planner",
    "setting",
    "seed",
    "end_reason",
    "end_time",
    "behavior",
)

# Those of them that are texts, even if they look like numbers.
_TEXTS = ("tag", "scenario", "planner", "setting", "end_reason", "behavior")

# What stands for no value in the others.
_MISSING = ["", "nan", "NaN", "NA"]


def run_row(
    result: TrialResult, tag: str, behavior: str | None = None
) -> dict[str, Any]:
    """Returns the row of a run, or of its people of one behavior."""
    row: dict[str, Any] = {
        "tag": tag,
        "scenario": result.scenario_name,
        "planner": str(result.provenance.get("planner", "")),
        "setting": result.setting,
        "seed": result.provenance.get("seed", ""),
        "end_reason": result.end_reason,
        "end_time": result.end_time,
    }
    if behavior is None:
        row |= result.metrics.to_dict()
    else:
        row["behavior"] = behavior
        row |= result.by_behavior.loc[behavior].to_dict()
    return row


def tabulate_runs(results: Iterable[TrialResult]) -> pd.DataFrame:
    """Returns a table with a row per run: what it is, and its metrics.

    What is known of the metrics is in `attrs`, by name: "units", "families"
    and "directions".
    """
    results = list(results)
    table = pd.DataFrame([run_row(result, result.tag) for result in results])
    for key in FACTS.values():
        table.attrs[key] = {}
        for result in results:
            table.attrs[key] |= result.metrics.attrs.get(key, {})
    return table


def ReadRuns(path: str | Path) -> pd.DataFrame:
    """Reads a table of runs.

    Args:
        path: A `metrics.csv`, or the folder that it is in.

    Returns:
        A row per run. Tables of older versions have no column `setting`.

    Raises:
        OSError: If it cannot be read.
        ValueError: If it is not a table.
    """
    path = Path(path)
    if path.is_dir():
        path = path / "metrics.csv"
    try:
        columns = pd.read_csv(path, nrows=0).columns
        missing = {c: _MISSING for c in columns if c not in _TEXTS}
        return pd.read_csv(
            path,
            dtype=dict.fromkeys(_TEXTS, str),
            keep_default_na=False,
            na_values=missing,
        )
    except ValueError as error:
        raise ValueError(f"{path}: is not a table of runs: {error}") from error
