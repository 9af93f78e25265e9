"""Means over the runs of a suite, and how sure they are."""

from collections.abc import Mapping, Sequence

import numpy as np

from hunav_drake.benchmark.suite_result import SuiteResult
from hunav_drake.systems.common.arrays import Array

_RESAMPLES = 1000


class Means:
    """Means over runs: the first of all runs, the others of samples of them.

    Planners and scenarios that have no runs raise a KeyError.
    """

    def __init__(self, result: SuiteResult, seed: int = 0) -> None:
        """Sorts the runs by planner, scenario and behavior.

        Samples are drawn by the bootstrap (Efron 1979).
        """
        self.planners = list(dict.fromkeys(c.planner for c in result.cells))
        self._rows: dict[tuple[str, str], list[Mapping[str, float]]] = {}
        self._behaviors: dict[
            tuple[str, str, str], list[Mapping[str, float]]
        ] = {}
        cells = {cell.name: cell for cell in result.cells}
        for row in result.rows:
            cell = cells[row.cell]
            if row.metrics:
                key = cell.planner, cell.scenario
                values = row.metrics | row.extras
                self._rows.setdefault(key, []).append(values)
                for behavior, part in row.by_behavior.items():
                    self._behaviors.setdefault((*key, behavior), []).append(
                        part
                    )
        self._seed = seed

    def of(self, planner: str, scenario: str, metric: str) -> Array:
        """Returns the means of a metric in a cell, shape (1 + samples,)."""
        return self._means(self._rows[planner, scenario], metric)

    def of_behavior(
        self, planner: str, scenario: str, behavior: str, metric: str
    ) -> Array:
        """Returns those of a metric for the people of one behavior."""
        rows = self._behaviors[planner, scenario, behavior]
        return self._means(rows, metric)

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
        return {
            key: np.array([row[metric] for row in rows])
            for key, rows in self._rows.items()
        }

    def _means(self, rows: Sequence[Mapping[str, float]], metric: str) -> Array:
        values = np.array([row[metric] for row in rows])
        values = values[np.isfinite(values)]
        if not len(values):
            raise KeyError(metric)
        draws = np.random.default_rng(self._seed).integers(
            len(values), size=(_RESAMPLES, len(values))
        )
        means = values[draws].mean(axis=1)
        return np.concatenate([[values.mean()], means])
