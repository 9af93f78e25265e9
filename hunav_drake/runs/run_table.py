"""The table of runs, made when it is read: a row per run, with its metrics."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from hunav_drake.runs.files import CSV_NUMBERS, read_summaries
from hunav_drake.runs.run_summary import RunSummary, make_summary
from hunav_drake.systems.common.files import atomic_write
from hunav_drake.trial.metric_facts import FACTS
from hunav_drake.trial.result import TrialResult

# The columns that are texts, even if they look like numbers.
_TEXTS = (
    *("tag", "scenario", "planner", "setting", "drawn", "end_reason"),
    *("end_message", "behavior"),
)

# What stands for no value in the others.
_MISSING = ["", "nan", "NaN", "NA"]


def ReadRuns(path: str | Path, *, by_behavior: bool = False) -> pd.DataFrame:
    """Makes the table of all runs in a folder, or reads one from a file.

    Args:
        path: A folder of results, or a table such as the `runs.csv` that
            `hunav report` writes. Of a folder only the summaries are read.
        by_behavior: Makes a row for each behavior of each run instead, with
            the metrics as if only the people of that behavior were there, and
            the column `behavior`.

    Returns:
        A row per run: tag, scenario, planner, setting, seed (empty if there
        is none), drawn (what the seed draws, "nothing" where all seeds are the
        same trial, empty where that is not known), end_reason, end_message,
        end_time in seconds, and a column per metric. For a folder, what is
        known of the metrics is in `attrs`, by name: "units", "families" and
        "directions".

    Raises:
        OSError: If it cannot be read, or there are no results.
        ValueError: If a run is damaged, or the file is not a table.
    """
    path = Path(path)
    if path.is_dir():
        return _table(read_summaries(path).items(), by_behavior)
    try:
        columns = pd.read_csv(path, nrows=0, compression=None).columns
        missing = {c: _MISSING for c in columns if c not in _TEXTS}
        return pd.read_csv(
            path,
            compression=None,
            dtype=dict.fromkeys(_TEXTS, str),
            keep_default_na=False,
            na_values=missing,
        )
    except ValueError as error:
        raise ValueError(f"{path}: is not a table of runs: {error}") from error


def tabulate_runs(
    results: Iterable[TrialResult], *, by_behavior: bool = False
) -> pd.DataFrame:
    """Makes the same table as `ReadRuns` from results in memory."""
    return _table(
        ((result.tag, make_summary(result)) for result in results), by_behavior
    )


def WriteTables(results: Iterable[TrialResult], folder: Path) -> Path:
    """Writes `runs.csv` and `runs_by_behavior.csv`, each in one piece.

    They are for spreadsheets and the like: nothing here reads them unless it
    is told to. Numbers have twelve digits; NaN is an empty cell.

    Returns:
        The path of `runs.csv`.

    Raises:
        OSError: If a file cannot be written.
    """
    results = list(results)
    for name, by_behavior in (("runs_by_behavior", True), ("runs", False)):
        table = tabulate_runs(results, by_behavior=by_behavior)
        path = folder / f"{name}.csv"
        with atomic_write(path) as file:
            text = table.to_csv(index=False, float_format=CSV_NUMBERS)
            file.write(text.encode())
    return path


def _table(
    runs: Iterable[tuple[str, RunSummary]], by_behavior: bool
) -> pd.DataFrame:
    rows: list[Mapping[str, Any]] = []
    facts: dict[str, dict[str, str]] = {key: {} for key in FACTS.values()}
    for tag, run in runs:
        about = {
            "tag": tag,
            "scenario": run.scenario,
            "planner": str(run.provenance.get("planner", "")),
            "setting": run.setting,
            "seed": run.provenance.get("seed", ""),
            "drawn": str(run.provenance.get("drawn", "")),
            "end_reason": run.end_reason,
            "end_message": run.end_message,
            "end_time": run.end_time,
        }
        metrics = run.metric_values()
        for key in facts:
            facts[key] |= metrics.attrs[key]
        if by_behavior:
            rows += [
                about | {"behavior": behavior} | values
                for behavior, values in run.by_behavior.items()
            ]
        else:
            rows.append(about | metrics.to_dict())
    table = pd.DataFrame(rows)
    table.attrs |= facts
    return table
