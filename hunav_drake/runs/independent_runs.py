"""Which runs of a table are independent, and so count."""

from collections.abc import Iterable
import math
from typing import Any

import numpy as np
import pandas as pd

from hunav_drake.trial.provenance import NOTHING_DRAWN
from hunav_drake.trial.result import TrialResult

# What tells independent runs apart, where a table has such columns.
_RUN = ("scenario", "planner", "setting", "seed", "drawn", "behavior")

# What must be equal for two runs to be the same; which versions computed them
# does not matter where all metrics are equal.
_SAME = (
    "scenario_sha256",
    "behavior_sha256",
    "files_sha256",
    "source_sha256",
    "planner",
    "seed",
)


def once_per_seed(
    runs: pd.DataFrame, keys: list[str], names: list[str]
) -> pd.DataFrame:
    """Returns a table in which the same runs are one row.

    Those are the repetitions of a run, and equal runs of which nothing is
    drawn.

    Args:
        runs: A row per run.
        keys: The columns that tell independent runs apart, besides those that
            always do.
        names: Those of numbers, of which the means over repetitions are taken.
    """
    runs = _mean_repetitions(runs, keys, names)
    known = [key for key in (*keys, *_RUN) if key in runs and key != "seed"]
    again = runs.duplicated([*dict.fromkeys(known), *names])
    return runs[~(again & draws_nothing(runs))]


def draws_nothing(runs: pd.DataFrame) -> pd.Series:
    """Returns of which runs all seeds are known to be the same trial."""
    if "drawn" not in runs:
        return pd.Series(False, runs.index)
    return runs["drawn"] == NOTHING_DRAWN


def _mean_repetitions(
    runs: pd.DataFrame, keys: list[str], names: list[str]
) -> pd.DataFrame:
    if "repetition" not in runs or "repetition" in keys:
        return runs
    about = [*keys, *(key for key in _RUN if key in runs and key not in keys)]
    if not runs.duplicated(about).any():
        return runs
    # Single runs of a seed do not tell why they are several.
    if runs.duplicated([*about, "repetition"]).any():
        return runs
    values = runs[names].where(np.isfinite(runs[names]))
    parts = values.groupby(
        [runs[key] for key in about], sort=False, dropna=False
    )
    return parts.mean().reset_index()


def drop_duplicate_runs(
    trials: Iterable[TrialResult],
) -> tuple[list[TrialResult], list[tuple[TrialResult, TrialResult]]]:
    """Leaves out duplicate runs, which would count twice in statistics.

    A run is a duplicate of another if the hashes of what was run, planner,
    setting and seed are the same, and all metrics are equal. Without such a
    hash nobody can tell.

    Returns:
        The runs that are left, and pairs of a duplicate and the run that it
        is a duplicate of.
    """
    kept: list[TrialResult] = []
    dropped: list[tuple[TrialResult, TrialResult]] = []
    seen: dict[Any, TrialResult] = {}
    for trial in trials:
        known = trial.provenance.keys() & {"scenario_sha256", "source_sha256"}
        key = _identity(trial) if known else object()
        first = seen.setdefault(key, trial)
        if first is trial:
            kept.append(trial)
        else:
            dropped.append((trial, first))
    return kept, dropped


def _identity(trial: TrialResult) -> tuple[Any, ...]:
    values = {
        name: None if math.isnan(value) else value
        for name, value in trial.metrics.items()
    }
    return (
        trial.scenario_name,
        trial.setting,
        trial.end_reason,
        *(trial.provenance.get(key) for key in _SAME),
        frozenset(values.items()),
    )
