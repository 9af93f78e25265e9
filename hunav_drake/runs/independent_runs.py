"""Which runs of a table are independent, and so count."""

import numpy as np
import pandas as pd

from hunav_drake.trial.provenance import NOTHING_DRAWN

# What tells independent runs apart, where a table has such columns.
_RUN = ("scenario", "planner", "setting", "seed", "drawn", "behavior")


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
    values = runs[names].where(np.isfinite(runs[names]))
    parts = values.groupby(
        [runs[key] for key in about], sort=False, dropna=False
    )
    return parts.mean().reset_index()
