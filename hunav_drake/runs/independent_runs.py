"""Which runs of a table are independent, and so count."""

import numpy as np
from numpy.typing import NDArray
import pandas as pd

from hunav_drake.trial.provenance import NOTHING_DRAWN

# The columns that distinguish independent runs, if a table has them.
_RUN = ("scenario", "planner", "setting", "seed", "drawn", "behavior")


def first_equal(runs: pd.DataFrame, columns: list[str]) -> NDArray[np.int64]:
    """Returns the row of the first run with equal columns, for each run.

    A run whose result is not its own row is a duplicate. NaN equals NaN.
    """
    kinds = runs.groupby(columns, sort=False, dropna=False).ngroup().to_numpy()
    _, first = np.unique(kinds, return_index=True)
    rows: NDArray[np.int64] = first[kinds]
    return rows


def once_per_seed(
    runs: pd.DataFrame, keys: list[str], names: list[str]
) -> pd.DataFrame:
    """Returns a table with one row for runs that are not independent.

    These are the repetitions of a run, and equal runs of which nothing is
    drawn.

    Args:
        runs: A row per run.
        keys: More columns that distinguish independent runs.
        names: The columns of numbers; repetitions are replaced by their means.
    """
    runs = _mean_repetitions(runs, keys, names)
    known = [key for key in (*keys, *_RUN) if key in runs and key != "seed"]
    first = first_equal(runs, [*dict.fromkeys(known), *names])
    is_first = first == np.arange(len(runs))
    return runs[is_first | ~draws_nothing(runs)]


def over_all_seeds(
    runs: pd.DataFrame, others: pd.DataFrame, keys: list[str]
) -> pd.DataFrame:
    """Returns runs, with copies of those of which nothing is drawn.

    Such a run represents each seed of the runs that it is compared with.

    Args:
        runs: A row per run, from `once_per_seed`.
        others: The runs that they are compared with.
        keys: The columns that are equal in compared runs.
    """
    kind = [key for key in keys if key != "seed"]
    # Merging needs a column. (Copies of wide tables are in one piece.)
    runs, others = (it.copy().assign(_any=0) for it in (runs, others))
    single = draws_nothing(runs) & ~runs.duplicated([*kind, "_any"], keep=False)
    if "seed" in keys and single.any():
        seeds = others[[*kind, "_any", "seed"]].drop_duplicates()
        copies = runs[single].drop(columns="seed").merge(seeds)
        runs = pd.concat([runs[~single], copies])
    return runs.drop(columns="_any")


def comparable(runs: pd.DataFrame, on: str) -> pd.DataFrame:
    """Returns the runs that have a seed, which no other run of theirs has.

    Several runs of a seed are ambiguous, but for repetitions in a suite.

    Args:
        runs: A row per run, in one scenario.
        on: The column that distinguishes what is compared.
    """
    keys = [on, "seed", *(["repetition"] * ("repetition" in runs))]
    seeded = runs[(runs["seed"] != "") & runs["seed"].notna()]
    return seeded[~seeded.duplicated(keys, keep=False)]


def draws_nothing(runs: pd.DataFrame) -> pd.Series:
    """Returns whether seeds draw nothing, as far as is known, for each run."""
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
    # Without distinct repetitions, the runs differ in something unknown.
    if runs.duplicated([*about, "repetition"]).any():
        return runs
    values = runs[names].where(np.isfinite(runs[names]))
    parts = values.groupby(
        [runs[key] for key in about], sort=False, dropna=False
    )
    return parts.mean().reset_index()
