"""Means over the runs of a suite, and their bootstrap samples."""

from collections.abc import Hashable, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from hunav_drake.runs.independent_runs import draws_nothing, once_per_seed
from hunav_drake.runs.run_row import NO_RESULT
from hunav_drake.runs.statistics import (
    OF_ALL_RUNS,
    arrivals,
    is_rate,
    where_all_arrive,
)
from hunav_drake.runs.suite_result import SuiteResult
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.evaluation.metric import base_name

_RESAMPLES = 1000

# The maximum number of values that are drawn at once, to save memory.
_AT_ONCE = 1_000_000

# The origin of a mean: planner and scenario, and perhaps a behavior.
Place = tuple[str, ...]


class Sample(NamedTuple):
    """Means of some places, and of samples of their seeds.

    Attributes:
        means: By name: the mean over all seeds, then those of samples, shape
            (1 + samples,).
        counts: The number of seeds of each mean.
        note: Which seeds these are, if not all; or empty.
        is_sure: Whether samples show the uncertainty of the means; they do not
            for one seed that draws something.
    """

    means: dict[str, Array]
    counts: dict[str, int]
    note: str
    is_sure: bool


class Means:
    """Means over the seeds of a setting; repetitions of a seed count once.

    The bootstrap (Efron 1979) draws samples of seeds, so the runs of all
    planners with one seed are drawn together. Planners and scenarios without
    runs raise a KeyError.
    """

    def __init__(
        self, result: SuiteResult, setting: str, seed: int = 0
    ) -> None:
        """Sorts the runs of a setting by planner, scenario and behavior.

        Args:
            result: The result of a suite.
            setting: The setting.
            seed: The seed of the draws.
        """
        self.planners = list(dict.fromkeys(c.planner for c in result.cells))
        keys = ["planner", "scenario"]
        self._runs = _parts(result.runs(extras=True), setting, keys)
        by_behavior = result.runs(by_behavior=True)
        parts = self._runs | _parts(by_behavior, setting, [*keys, "behavior"])
        self._tables = {key: _by_seed(part) for key, part in parts.items()}
        self._seed = seed
        # Scenarios with the same seeds are drawn together.
        self._kinds: dict[str, Hashable] = {
            scenario: tuple(sorted(result.suite.seed_list(scenario)))
            for scenario in {cell.scenario for cell in result.cells}
        }
        self._seeds: dict[Hashable, pd.Index] = {}
        for (_, scenario, *_), table in self._tables.items():
            kind = self._kinds[scenario]
            known = self._seeds.get(kind, table.index)
            self._seeds[kind] = known.union(table.index)

    def sample(self, places: Mapping[str, Place], metric: str) -> Sample:
        """Returns the means of a metric in some places, by their names.

        They are over the seeds in which all places have a value, and in which
        all arrive, unless the metric includes runs that do not arrive.

        Raises:
            KeyError: If a place has no value, or there is no such seed.
        """
        columns = {
            name: self._column(place, metric) for name, place in places.items()
        }
        for name, column in columns.items():
            if not np.isfinite(column).any():
                raise KeyError(f"{metric} of {name}")
        means: dict[str, Array] = {}
        counts: dict[str, int] = {}
        notes = []
        for number, kind in enumerate(self._seeds):
            alike = [k for k, it in places.items() if self._kind(it) == kind]
            if not alike:
                continue
            values = np.stack([columns[name] for name in alike])
            known = np.isfinite(values)
            whole = known.all(axis=0)
            rule = "all have a value"
            if base_name(metric) not in OF_ALL_RUNS:
                arrive = where_all_arrive(
                    self._arrivals(places[name], metric) for name in alike
                )
                if arrive is not None:
                    whole &= arrive
                    rule = "all arrive"
            n, most = int(whole.sum()), int(known.any(axis=0).sum())
            if n < most:
                notes.append(f"on the {n} of {most} seeds in which {rule}")
            if not n:
                raise KeyError(f"{metric} in seeds in which {rule}")
            drawn = self._draw(values[:, whole], number)
            means |= dict(zip(alike, drawn, strict=True))
            counts |= dict.fromkeys(alike, n)
        return Sample(
            {name: means[name] for name in places},
            {name: counts[name] for name in places},
            ", ".join(dict.fromkeys(notes)),
            all(
                counts[name] > 1 or self._is_fixed(place)
                for name, place in places.items()
            ),
        )

    def _draw(self, values: Array, number: int) -> Array:
        """Returns the means of rows, then of samples of their columns."""
        n = values.shape[1]
        random = np.random.default_rng([self._seed, number])
        means = [values.mean(axis=1, keepdims=True)]
        # A few samples at a time, to save memory.
        size = max(1, min(_RESAMPLES, _AT_ONCE // n))
        for start in range(0, _RESAMPLES, size):
            count = min(size, _RESAMPLES - start)
            draws = random.integers(n, size=(count, n))
            means.append(np.stack([it[draws].mean(axis=1) for it in values]))
        return np.concatenate(means, axis=1)

    def behaviors(self, scenario: str) -> list[str]:
        """Returns the behaviors of people in a scenario."""
        found = dict.fromkeys(
            key[2]
            for key in self._tables
            if len(key) == 3 and key[1] == scenario
        )
        if not found:
            raise KeyError(scenario)
        return list(found)

    def runs(self, metric: str) -> dict[tuple[str, str], Array]:
        """Returns the values of all runs, by planner and scenario.

        Runs without a result only count for rates of arrival.
        """
        found: dict[tuple[str, str], Array] = {}
        for key, part in self._runs.items():
            failed = part.end_reason.isin(NO_RESULT)
            counted = part if is_rate(metric) else part[~failed]
            if len(counted):
                found[key] = counted[metric].to_numpy(float)
        return found

    def _kind(self, place: Place) -> Hashable:
        """Returns a key of places whose seeds are drawn together."""
        return self._kinds[place[1]]

    def _column(self, place: Place, metric: str) -> Array:
        """Returns the values by seed, shape (seeds,), NaN for none."""
        return self._at_seeds(place, self._tables[place][metric])

    def _arrivals(self, place: Place, metric: str) -> Array:
        """Returns the rates of arrival by seed: see `arrivals`."""
        table = self._tables[place[:2]]
        rates = pd.Series(arrivals(table, metric), table.index)
        return self._at_seeds(place[:2], rates)

    def _at_seeds(self, place: Place, column: pd.Series) -> Array:
        # A run of which nothing is drawn represents every seed.
        fill = "nearest" if self._is_fixed(place) else None
        seeds = self._seeds[self._kind(place)]
        values: Array = column.reindex(seeds, method=fill).to_numpy(float)
        return np.where(np.isfinite(values), values, np.nan)

    def _is_fixed(self, place: Place) -> bool:
        """Returns whether a place has one run that represents all seeds."""
        table = self._tables[place]
        return len(table) == 1 and bool(draws_nothing(table).all())


def _by_seed(runs: pd.DataFrame) -> pd.DataFrame:
    """Returns a row per seed: the means over its repetitions."""
    numbers = runs.select_dtypes("number").columns.drop("seed")
    return once_per_seed(runs, ["seed"], list(numbers)).set_index("seed")


def _parts(
    runs: pd.DataFrame, setting: str, by: list[str]
) -> dict[Any, pd.DataFrame]:
    if runs.empty:
        return {}
    return dict(iter(runs[runs.setting == setting].groupby(by, sort=False)))
