"""Settings: names that distinguish runs of one planner in one scenario."""

from collections.abc import Iterable
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd
else:
    import lazy_loader

    pd = lazy_loader.load("pandas")

# Changes of a scenario that have their own columns in the table of runs.
_TOLD = ("planner.type", "planner.name", "simulation.seed")

# The columns of texts that identify runs. `pandas.read_csv` reads their empty
# cells as NaN.
_NAMES = ("scenario", "planner", "setting", "drawn", "behavior")

# The path before a key of a scenario, as in "planner.speed=0.3". A type keeps
# it: "robot.type=pmb2".
_WAY = re.compile(
    r"[^\s;=,]*\.(?!type=)(?=[A-Za-z_][\w-]*(\[\d+\])*(\.type)?=)"
)


def setting_text(changes: Iterable[str]) -> str:
    """Returns changes such as "planner.cruise_speed=0.3" as one text.

    Their order does not matter; the last change of a key counts. Changes of
    planner and seed are left out.
    """
    values = {}
    for change in changes:
        key, _, value = change.partition("=")
        values[key.strip()] = " ".join(value.split())
    told = sorted(key for key in values if key not in _TOLD)
    return "; ".join(f"{key}={values[key]}" for key in told)


def short_settings(settings: Iterable[str]) -> dict[str, str]:
    """Returns settings without the paths of their keys, by the settings.

    If two of them would become equal, all stay as they are.
    """
    short = {text: _WAY.sub("", text) for text in settings}
    if len(set(short.values())) < len(short):
        return {text: text for text in short}
    return short


def has_settings(runs: "pd.DataFrame") -> bool:
    """Returns whether a run of a table has a setting."""
    return "setting" in runs and bool((_texts(runs, "setting") != "").any())


def with_names(runs: "pd.DataFrame") -> "pd.DataFrame":
    """Returns a table whose missing names of planners, settings ... are empty.

    Args:
        runs: A row per run, as of `ReadRuns` or of `pandas.read_csv`. It is
            not changed.
    """
    gaps = [name for name in _NAMES if name in runs and runs[name].hasnans]
    # (pandas warns where columns are added to many that come from a file.)
    return runs.copy().assign(**{name: _texts(runs, name) for name in gaps})


def _texts(runs: "pd.DataFrame", name: str) -> "pd.Series":
    """Returns a column as texts; whole numbers have no decimals."""
    column = runs[name]
    if pd.api.types.is_float_dtype(column):
        # Whole numbers beside an empty cell, such as labels.
        column = column.map("{:g}".format, na_action="ignore")
    return column.astype(object).where(column.notna(), "").astype(str)


def contenders(runs: "pd.DataFrame") -> "pd.Series":
    """Returns the contender of each run, such as "pursuit, cruise_speed=0.3".

    Runs have the same name exactly if planner and setting are the same.

    Args:
        runs: A row per run, with the column `planner`; `setting` counts as
            empty where it is missing.
    """
    planners = _texts(runs, "planner")
    if not has_settings(runs):
        return planners
    pairs = list(zip(planners, _texts(runs, "setting"), strict=True))
    short = short_settings(dict.fromkeys(setting for _, setting in pairs))
    names: dict[tuple[str, str], str] = {}
    for planner, setting in pairs:
        if (planner, setting) not in names:
            name = ", ".join(t for t in (planner, short[setting]) if t)
            while name in names.values():
                name += "'"
            names[planner, setting] = name
    return pd.Series([names[pair] for pair in pairs], index=runs.index)
