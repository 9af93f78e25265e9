"""The result of a suite: tables of runs, and their statistics."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from hunav_drake.runs.cells import Cell
from hunav_drake.runs.outcomes import count_outcomes
from hunav_drake.runs.run_row import FAILED, RunRow
from hunav_drake.runs.run_table import RunTable
from hunav_drake.runs.statistics import summarize
from hunav_drake.runs.suite import Suite
from hunav_drake.trial.provenance import NOTHING_DRAWN

KEYS = ("scenario", "planner", "setting")


class SuiteResult:
    """The finished runs of a suite, in the order of the suite.

    Attributes:
        suite: The suite.
        cells: Its cells.
        rows: A row per run; rows are created on access.
        folder: The folder of the results, if there is one.
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
        table = rows if isinstance(rows, RunTable) else RunTable(rows)
        self.rows = table.sorted(self._order(table))

    def __repr__(self) -> str:
        return (
            f"<SuiteResult of {self.suite.name}, {len(self.rows)} runs in"
            f" {len(self.cells)} cells>"
        )

    @property
    def code_sha256(self) -> str:
        """The hash of the code that ran it; empty if there are no runs."""
        return self.rows[0].code_sha256 if len(self.rows) else ""

    @property
    def failures(self) -> list[RunRow]:
        """The failed runs."""
        reasons = self.rows.texts("end_reason")
        return [self.rows[i] for i, it in enumerate(reasons) if it in FAILED]

    def runs(
        self, *, by_behavior: bool = False, extras: bool = False
    ) -> pd.DataFrame:
        """Returns the table of `ReadRuns`, in the order of the suite.

        Args:
            by_behavior: Whether to return a row for each behavior of each run,
                with the metrics as if only the people of that behavior existed.
            extras: Whether to add the columns of `extra_values`.
        """
        return self.rows.frame(by_behavior=by_behavior, extras=extras)

    def costs(self) -> pd.DataFrame:
        """Returns the computing time of each run, in seconds.

        The columns "wall" and "cpu" are for the whole run, "cycle_median" and
        "cycle_p95" for the cycles of its planner.
        """
        runs = self.runs()
        return runs[[*KEYS, "seed", "end_time"]].assign(
            **self.rows.columns("cost")
        )

    def outcomes(self) -> pd.DataFrame:
        """Returns why the runs of each cell ended: `count_outcomes`."""
        return count_outcomes(self.runs(), KEYS)

    def same_seeds(self) -> list[str]:
        """Returns notes on cells in which all seeds give the same trial.

        Scenarios and settings with the same note share a line.
        """
        places: dict[str, dict[str, None]] = {}
        for cell in self.cells:
            if cell.drawn == NOTHING_DRAWN:
                place = cell.scenario + f" ({cell.setting})" * bool(
                    cell.setting
                )
                places.setdefault(cell.how_to_draw, {})[place] = None
        return [
            f"{', '.join(names)}: nothing is drawn, all seeds give the same"
            " trial, so only one is run (n = 1, no interval); for different"
            f" trials, {how}"
            for how, names in places.items()
        ]

    def summary(self) -> pd.DataFrame:
        """Returns the statistics of each metric in each cell: `summarize`.

        It is empty if no run has a result.
        """
        runs = self.runs()
        names = [it for it in runs.attrs["units"] if it in runs.columns]
        if runs.empty or not names:
            return pd.DataFrame()
        return summarize(runs, KEYS, metrics=names)

    def _order(self, table: RunTable) -> Any:
        """Returns the indices of the runs of the suite, in its order."""
        places = {cell.name: i for i, cell in enumerate(self.cells)}
        cells = np.array([places.get(it, -1) for it in table.texts("cell")])
        seeds = np.full(len(cells), -1)
        for scenario in {cell.scenario for cell in self.cells}:
            own = [
                place
                for place, cell in enumerate(self.cells)
                if cell.scenario == scenario
            ]
            mine = np.flatnonzero(np.isin(cells, own))
            chosen = np.array(self.suite.seed_list(scenario))
            by_value = np.argsort(chosen, kind="stable")
            drawn = table.seeds[mine]
            found = np.searchsorted(chosen, drawn, sorter=by_value)
            index = by_value[np.minimum(found, len(chosen) - 1)]
            seeds[mine] = np.where(chosen[index] == drawn, index, -1)
        known = (cells >= 0) & (seeds >= 0)
        known &= table.repetitions < self.suite.repetitions
        order = np.lexsort((table.repetitions, seeds, cells))
        return order[known[order]]
