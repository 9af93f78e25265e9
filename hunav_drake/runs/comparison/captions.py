"""Captions: of which runs a table or a figure is."""

import pandas as pd

from hunav_drake.runs.independent_runs import draws_nothing
from hunav_drake.runs.settings import contenders, with_names
from hunav_drake.systems.common.suggest import listed

# More seeds than these are told by their number.
_MOST_SEEDS = 6


def runs_caption(runs: pd.DataFrame, made_by: str = "") -> str:
    """Returns scenarios, planners, seeds and version, without a full stop.

    Args:
        runs: A row per run: see `ReadRuns`.
        made_by: The suite and the versions, as `made_by_text` has them.
    """
    runs = with_names(runs)
    scenarios = [it for it in dict.fromkeys(runs["scenario"]) if it]
    names = [it for it in dict.fromkeys(contenders(runs)) if it]
    parts = [f"scenario{'s' * (len(scenarios) > 1)} {listed(scenarios)}"]
    parts = parts if scenarios else ["trials"]
    if names:
        parts.append(f"planner{'s' * (len(names) > 1)} {listed(names)}")
    text = "; ".join([*parts, *_seeds(runs), *filter(None, [made_by])])
    return text[0].upper() + text[1:]


def made_by_text(suite: str, version: str, program: str) -> str:
    """Returns what made runs: a suite with its version, and the program's.

    Args:
        suite: The name of the suite; empty for single runs.
        version: Its version.
        program: The version of this package; empty if unknown.
    """
    parts = [f"suite {suite}, version {version}"] if suite else []
    parts += [f"hunav_drake {program}"] if program else []
    return "; ".join(parts)


def _seeds(runs: pd.DataFrame) -> list[str]:
    """Returns the seeds of all planners, or how many each has."""
    names = contenders(runs)
    if draws_nothing(runs).all():
        return ["one run each, because all seeds are alike"]
    seeds = runs["seed"].replace("", pd.NA)
    if seeds.isna().any():
        return [f"{len(runs)} run{'s' * (len(runs) > 1)}"]
    counts = seeds.groupby([runs["scenario"], names]).nunique()
    least, most = int(counts.min()), int(counts.max())
    if least < most:
        return [f"{least} to {most} seeds"]
    values = sorted({int(it) for it in seeds})
    told = f"{values[0]} to {values[-1]}"
    if len(values) != values[-1] - values[0] + 1:
        told = listed([str(it) for it in values], _MOST_SEEDS)
    if most == 1 and len(values) == 1:
        return [f"one seed ({values[0]})"]
    if most == 1:
        return ["one seed each"]
    return [f"{most} seeds" + f" ({told})" * (len(values) == most)]
