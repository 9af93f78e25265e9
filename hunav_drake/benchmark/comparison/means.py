"""Means over the runs of a suite, and how sure they are."""

from typing import Any

import numpy as np
import pandas as pd

from hunav_drake.benchmark.running.run_row import ERROR
from hunav_drake.benchmark.suite_result import SuiteResult
from hunav_drake.systems.common.arrays import Array

_RESAMPLES = 1000

# So many values are drawn at once.
_AT_ONCE = 1_000_000


class Means:
    """Means over runs: the first of all runs, the others of samples of them.

    Planners and scenarios that have no runs raise a KeyError.
    """

    def __init__(
        self, result: SuiteResult, setting: str | None = None, seed: int = 0
    ) -> None:
        """Sorts the runs of a setting by planner, scenario and behavior.

        Samples are drawn by the bootstrap (Efron 1979).

        Args:
            result: What a suite has given.
            setting: The setting; by default runs of all are taken together.
            seed: The seed of the draws.
        """
        self.planners = list(dict.fromkeys(c.planner for c in result.cells))
        runs = _of_setting(result.runs(extras=True), setting)
        failed = runs.index[runs.end_reason == ERROR]
        self._runs = _parts(runs.drop(failed), ["planner", "scenario"])
        self._behaviors = _parts(
            _of_setting(result.runs(by_behavior=True), setting),
            ["planner", "scenario", "behavior"],
        )
        self._seed = seed

    def of(self, planner: str, scenario: str, metric: str) -> Array:
        """Returns the means of a metric in a cell, shape (1 + samples,)."""
        return self._means(self._runs[planner, scenario], metric)

    def of_behavior(
        self, planner: str, scenario: str, behavior: str, metric: str
    ) -> Array:
        """Returns those of a metric for the people of one behavior."""
        part = self._behaviors[planner, scenario, behavior]
        return self._means(part, metric)

    def behaviors(self, scenario: str) -> list[str]:
        """Returns the behaviors of people in a scenario."""
        found = dict.fromkeys(
            key[2] for key in self._behaviors if key[1] == scenario
        )
        if not found:
            raise KeyError(scenario)
        return list(found)

    def runs(self, metric: str) -> dict[tuple[str, str], Array]:
        """Returns the values of all runs, by planner and scenario."""

        def values(part: pd.DataFrame) -> Array:
            found: Array = part[metric].to_numpy(float)
            return found

        return {key: values(part) for key, part in self._runs.items()}

    def _means(self, part: pd.DataFrame, metric: str) -> Array:
        values = part[metric].to_numpy(float)
        values = values[np.isfinite(values)]
        n = len(values)
        if not n:
            raise KeyError(metric)
        random = np.random.default_rng(self._seed)
        means = [np.array([values.mean()])]
        # A few samples at a time: all of many runs would fill the memory.
        size = max(1, min(_RESAMPLES, _AT_ONCE // n))
        for start in range(0, _RESAMPLES, size):
            count = min(size, _RESAMPLES - start)
            draws = random.integers(n, size=(count, n))
            means.append(values[draws].mean(axis=1))
        return np.concatenate(means)


def _of_setting(runs: pd.DataFrame, setting: str | None) -> pd.DataFrame:
    if setting is None or runs.empty:
        return runs
    return runs[runs.setting == setting]


def _parts(runs: pd.DataFrame, by: list[str]) -> dict[Any, pd.DataFrame]:
    if runs.empty:
        return {}
    return dict(iter(runs.groupby(by, sort=False)))
