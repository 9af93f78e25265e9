"""What is left to do in a cell."""

from collections.abc import Iterable
import math

import numpy as np

from hunav_drake.benchmark.running.cell import Cell
from hunav_drake.benchmark.running.run_row import RunRow
from hunav_drake.benchmark.running.worker import Task
from hunav_drake.benchmark.suite import Suite

# So many runs go to a worker at once: it makes the diagram of a cell only when
# it is given another cell, and who stops the suite loses no more than these.
_BATCH = 5


class CellPlan:
    """Which runs of a cell are done, under way, and to come."""

    def __init__(
        self, cell: Cell, suite: Suite, done: Iterable[RunRow]
    ) -> None:
        """Makes the plan of a cell, of which some rows may be there."""
        self.cell = cell
        self._runs = [
            (seed, repetition)
            for seed in suite.seed_list(cell.scenario)
            for repetition in range(suite.repetitions)
        ]
        self._until = suite.until
        self._keep = self._runs[0][0]
        self._values: dict[tuple[int, int], float] = {}
        self._given: set[tuple[int, int]] = set()
        self._goal = len(self._runs)
        for row in done:
            if row.sha256 == cell.sha256:
                self.take(row)
        self._given |= set(self._values)
        self._goal = self._find_goal()

    @property
    def kind(self) -> tuple[str, str]:
        """What tells cells apart that need other kernels."""
        return self.cell.planner, self.cell.scenario

    @property
    def total(self) -> int:
        """How many runs it has, as far as is known."""
        return len(self._runs[: self._goal])

    @property
    def done(self) -> int:
        """How many of them have ended."""
        return sum(run in self._values for run in self._runs[: self._goal])

    @property
    def is_done(self) -> bool:
        """Whether nothing is left to do."""
        return self.done == self.total

    def take(self, row: RunRow) -> None:
        """Takes note of a run that has ended."""
        name = self._until.metric if self._until else ""
        value = row.metrics.get(name, math.nan)
        self._values[row.seed, row.repetition] = value
        self._goal = self._find_goal()

    def next_task(self) -> Task | None:
        """Returns the next runs to give out, if there are any."""
        left = [r for r in self._runs[: self._goal] if r not in self._given]
        if not left:
            return None
        runs = tuple(left[:_BATCH])
        self._given |= set(runs)
        return Task(
            cell=self.cell.name,
            sha256=self.cell.sha256,
            text=self.cell.text,
            runs=runs,
            keep=self._keep,
        )

    def _find_goal(self) -> int:
        """Returns how many runs are enough, as far as is known.

        It looks at the first n runs, for n one batch larger each time, so that
        it does not matter which ended first.
        """
        if self._until is None:
            return len(self._runs)
        size = self._until.least
        while size < len(self._runs):
            first = self._runs[:size]
            if not all(run in self._values for run in first):
                return size
            if self._is_known([self._values[run] for run in first]):
                return size
            size += _BATCH
        return len(self._runs)

    def _is_known(self, values: list[float]) -> bool:
        from scipy.stats import t

        assert self._until is not None
        finite = np.array([v for v in values if math.isfinite(v)])
        n = len(finite)
        if n < self._until.least:
            return False
        reach = float(t.ppf(0.975, n - 1)) * float(finite.std(ddof=1))
        return reach / math.sqrt(n) <= self._until.half_width
