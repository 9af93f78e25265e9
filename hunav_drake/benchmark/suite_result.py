"""What a suite has given: tables of runs, and their statistics."""

from collections.abc import Iterable, Sequence
import math
from pathlib import Path

import pandas as pd

from hunav_drake.benchmark.running.cell import Cell
from hunav_drake.benchmark.running.run_row import FAILED, RunRow
from hunav_drake.benchmark.suite import Suite
from hunav_drake.results.metric_facts import FACTS, facts_of
from hunav_drake.results.statistics import summarize
from hunav_drake.systems.evaluation.metrics import METRICS

KEYS = ("scenario", "planner", "setting")


class SuiteResult:
    """The runs of a suite that have ended, in the order of the suite.

    Attributes:
        suite: What was run.
        cells: Its cells.
        rows: A row per run.
        folder: Where it is kept, if anywhere.
    """

    def __init__(
        self,
        suite: Suite,
        cells: Sequence[Cell],
        rows: Iterable[RunRow],
        folder: Path | None = None,
    ) -> None:
        """Sorts the rows: by cell, seed and repetition."""
        self.suite = suite
        self.cells = list(cells)
        self.folder = folder
        order = {
            (cell.name, seed): (place, i)
            for place, cell in enumerate(self.cells)
            for i, seed in enumerate(suite.seed_list(cell.scenario))
        }
        self.rows = sorted(
            (row for row in rows if (row.cell, row.seed) in order),
            key=lambda row: (*order[row.cell, row.seed], row.repetition),
        )

    @property
    def failures(self) -> list[RunRow]:
        """The runs that gave no result."""
        return [row for row in self.rows if row.end_reason in FAILED]

    def runs(self, *, by_behavior: bool = False) -> pd.DataFrame:
        """Returns a row per run.

        Args:
            by_behavior: Returns one for each behavior instead, with the
                metrics as if only the people of that behavior were there.

        Returns:
            The columns scenario, planner, setting, seed, repetition,
            end_reason, end_message, end_time in seconds, with `by_behavior`
            also behavior, and one per metric. What is known of the metrics is
            in `attrs`.
        """
        cells = {cell.name: cell for cell in self.cells}
        table = []
        for row in self.rows:
            cell = cells[row.cell]
            about = {
                "scenario": cell.scenario,
                "planner": cell.planner,
                "setting": cell.setting,
                "seed": row.seed,
                "repetition": row.repetition,
                "end_reason": row.end_reason,
                "end_message": row.end_message,
                "end_time": row.end_time,
            }
            if not by_behavior:
                table.append(about | row.metrics)
            for behavior, values in row.by_behavior.items():
                if by_behavior:
                    table.append(about | {"behavior": behavior} | values)
        frame = pd.DataFrame(table)
        frame.attrs |= {key: {} for key in FACTS.values()}
        names = [name for name in frame.columns if name in METRICS]
        frame.attrs |= facts_of(names)
        return frame

    def costs(self) -> pd.DataFrame:
        """Returns what each run cost: columns in seconds.

        "wall" and "cpu" are of the whole run, "cycle_median" and "cycle_p95"
        of the cycles of its planner.
        """
        cells = {cell.name: cell for cell in self.cells}
        return pd.DataFrame(
            [
                {key: getattr(cells[row.cell], key) for key in KEYS}
                | {"seed": row.seed, "end_time": row.end_time}
                | row.cost
                for row in self.rows
            ]
        )

    def summary(self) -> pd.DataFrame:
        """Returns the statistics of each metric in each cell: `summarize`."""
        runs = self.runs()
        names = [name for name in runs.columns if name in METRICS]
        return summarize(runs, KEYS, metrics=names)

    def mean(self, cell: str, metric: str) -> float:
        """Returns the mean of a metric in a cell, over runs that have it."""
        values = [
            row.metrics.get(metric, math.nan)
            for row in self.rows
            if row.cell == cell
        ]
        finite = [value for value in values if math.isfinite(value)]
        return math.fsum(finite) / len(finite) if finite else math.nan
