"""Duplicate runs: the same trial, run again with the same outcome."""

from collections.abc import Iterable
import math
from typing import Any

from hunav_drake.trial.result import TrialResult

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
