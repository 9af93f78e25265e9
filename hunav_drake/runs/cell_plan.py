"""The plan of a cell: which runs are finished, and which are to come."""

from array import array
from collections.abc import Sequence
import math
from typing import Any

import numpy as np
import pandas as pd

from hunav_drake.runs.cells import Cell
from hunav_drake.runs.code_hash import CodeHashes
from hunav_drake.runs.intervals import mean_interval, wilson_interval
from hunav_drake.runs.run_row import NO_RESULT, RunRow
from hunav_drake.runs.statistics import is_rate
from hunav_drake.runs.suite import Suite
from hunav_drake.runs.tasks import Task
from hunav_drake.trial.provenance import NOTHING_DRAWN

# The number of runs in a task. A worker builds a diagram only for a new cell,
# and an interrupt loses at most these runs.
_BATCH = 5


class CellPlan:
    """The finished, running and remaining runs of a cell.

    If seeds draw nothing, there is one run; for a user's planner there are its
    repetitions, which show whether it is deterministic.

    A plan takes a few bytes for each run: suites may have millions.
    """

    def __init__(
        self,
        cell: Cell,
        suite: Suite,
        code: CodeHashes,
        imports: tuple[str, ...] = (),
    ) -> None:
        """Constructs the plan of a cell without finished runs."""
        self.cell = cell
        self._code = code
        self._imports = imports
        self._repetitions = 1 if cell.once else suite.repetitions
        seeds: Any = suite.seeds_of.get(cell.scenario, suite.seeds)
        if cell.drawn == NOTHING_DRAWN:
            # All seeds give the same trial.
            seeds = suite.seed_list(cell.scenario)[:1]
        self._seeds: Sequence[int] = (
            range(seeds) if isinstance(seeds, int) else list(seeds)
        )
        self._places = (
            {}
            if isinstance(self._seeds, range)
            else {seed: i for i, seed in enumerate(self._seeds)}
        )
        self._count = len(self._seeds) * self._repetitions
        self._until = suite.until
        self._is_done = bytearray(self._count)
        self._is_given = bytearray(self._count)
        # Of the metric of `until`.
        self._values = array("d", [math.nan] * self._count * bool(suite.until))
        self._next = 0
        # The number of runs that is enough, as far as is known.
        self._goal = self._count
        if suite.until:
            least = suite.until.least * self._repetitions
            self._goal = min(least, self._count)

    @property
    def kind(self) -> tuple[str, str]:
        """A key of cells that need the same kernels."""
        return self.cell.planner, self.cell.scenario

    @property
    def total(self) -> int:
        """The number of runs, as far as is known."""
        return self._goal

    @property
    def done(self) -> int:
        """The number of finished runs among them."""
        return self._is_done.count(1, 0, self._goal)

    @property
    def is_done(self) -> bool:
        """Whether all runs are finished."""
        return self.done == self.total

    def take(self, row: RunRow) -> bool:
        """Adds a finished run; returns whether it is new."""
        index = self._index(row.seed, row.repetition)
        if index is None or self._is_done[index]:
            return False
        self._is_done[index] = self._is_given[index] = 1
        if self._until:
            name = self._until.metric
            # A run without a result is not completed.
            is_missed = is_rate(name) and row.end_reason in NO_RESULT
            value = 0.0 if is_missed else row.metrics.get(name, math.nan)
            self._values[index] = value
            self._raise_goal()
        return True

    def counts(self, seed: int, repetition: int) -> bool:
        """Returns whether the suite asks for a run."""
        index = self._index(seed, repetition)
        return index is not None and index < self._goal

    def next_task(self) -> Task | None:
        """Returns the next task, if there is one."""
        runs: list[tuple[int, int]] = []
        while len(runs) < _BATCH:
            index = self._is_given.find(0, self._next, self._goal)
            if index < 0:
                break
            self._is_given[index] = 1
            self._next = index
            seed, repetition = divmod(index, self._repetitions)
            runs.append((self._seeds[seed], repetition))
        if not runs:
            return None
        return Task(
            cell=self.cell,
            code=self._code,
            runs=tuple(runs),
            keep=self._seeds[0],
            imports=self._imports,
        )

    def _index(self, seed: int | None, repetition: int) -> int | None:
        if seed is None or not 0 <= repetition < self._repetitions:
            return None
        if isinstance(self._seeds, range):
            place = seed if seed in self._seeds else None
        else:
            place = self._places.get(seed)
        return None if place is None else place * self._repetitions + repetition

    def _raise_goal(self) -> None:
        """Raises the number of runs until the mean is known well enough.

        It tests the first n seeds, and adds one batch to n each time, so the
        order in which runs end does not matter.
        """
        while self._goal < self._count:
            if self.done < self._goal or self._is_known():
                return
            more = _BATCH * self._repetitions
            self._goal = min(self._goal + more, self._count)

    def _is_known(self) -> bool:
        assert self._until is not None
        # Repetitions of a seed are not independent: their mean is one value.
        values = np.array(self._values[: self._goal])
        values[~np.isfinite(values)] = math.nan
        table = pd.DataFrame(values.reshape(-1, self._repetitions))
        means = table.mean(axis=1).dropna().to_numpy()
        n = len(means)
        if n < self._until.least:
            return False
        # As in tables.
        if is_rate(self._until.metric):
            low, high = wilson_interval(float(means.sum()), n)
        else:
            low, high = mean_interval(means)
        return (high - low) / 2 <= self._until.half_width
