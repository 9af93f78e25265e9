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


def over_all_seeds(
    runs: pd.DataFrame, others: pd.DataFrame, keys: list[str]
) -> pd.DataFrame:
    """Returns runs in which those of which nothing is drawn come in all seeds.

    These are the seeds of other runs; a single run stands for each of them.

    Args:
        runs: A row per run, as `once_per_seed` gives them.
        others: Those that they are compared with.
        keys: The columns in which runs that belong together are equal.
    """
    kind = [key for key in keys if key != "seed"]
    # Merging needs a column.
    runs, others = (it.assign(_any=0) for it in (runs, others))
    single = draws_nothing(runs) & ~runs.duplicated([*kind, "_any"], keep=False)
    if "seed" in keys and single.any():
        seeds = others[[*kind, "_any", "seed"]].drop_duplicates()
        copies = runs[single].drop(columns="seed").merge(seeds)
        runs = pd.concat([runs[~single], copies])
    return runs.drop(columns="_any")


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
