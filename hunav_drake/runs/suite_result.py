"""What a suite has given: tables of runs, and their statistics."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from hunav_drake.runs.outcomes import count_outcomes
from hunav_drake.runs.running.cell import Cell
from hunav_drake.runs.running.run_row import FAILED, NO_RESULT, RunRow
from hunav_drake.runs.running.run_table import (
    COST,
    EXTRAS,
    METRICS as METRIC_GROUP,
    RunTable,
    behavior_group,
)
from hunav_drake.runs.statistics import RATES, summarize
from hunav_drake.runs.suite import Suite
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.trial.metric_facts import FACTS, facts_of
from hunav_drake.trial.provenance import NOTHING_DRAWN

KEYS = ("scenario", "planner", "setting")


class SuiteResult:
    """The runs of a suite that have ended, in the order of the suite.

    Attributes:
        suite: What was run.
        cells: Its cells.
        rows: A row per run; they are made as they are asked for.
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
        table = rows if isinstance(rows, RunTable) else RunTable(rows)
        self.rows = table.sorted(self._order(table))

    @property
    def code_sha256(self) -> str:
        """The hash of the code that has run it; empty if nothing was run."""
        return self.rows[0].code_sha256 if len(self.rows) else ""

    @property
    def failures(self) -> list[RunRow]:
        """The runs that gave no result."""
        reasons = self.rows.texts("end_reason")
        return [self.rows[i] for i, it in enumerate(reasons) if it in FAILED]

    def runs(
        self, *, by_behavior: bool = False, extras: bool = False
    ) -> pd.DataFrame:
        """Returns a row per run.

        Args:
            by_behavior: Returns one for each behavior instead, with the
                metrics as if only the people of that behavior were there.
            extras: Whether there are also the columns of `extra_values`.

        Returns:
            The columns scenario, planner, setting, seed, repetition, drawn
            (what the seed draws: see `ReadRuns`), end_reason, end_message,
            end_time in seconds, with `by_behavior` also behavior, and one per
            metric. Of a run without a result they are NaN, but it is not
            completed. What is known of the metrics is in `attrs`.
        """
        about = self._about()
        if by_behavior:
            frame = self._by_behavior(about)
        else:
            columns = self._metrics()
            if extras:
                columns |= self.rows.columns(EXTRAS)
            frame = about.assign(**columns)
        frame.attrs |= {key: {} for key in FACTS.values()}
        names = [name for name in frame.columns if name in METRICS]
        frame.attrs |= facts_of(names)
        return frame

    def costs(self) -> pd.DataFrame:
        """Returns what each run cost: columns in seconds.

        "wall" and "cpu" are of the whole run, "cycle_median" and "cycle_p95"
        of the cycles of its planner.
        """
        about = self._about()
        return about[[*KEYS, "seed", "end_time"]].assign(
            **self.rows.columns(COST)
        )

    def outcomes(self) -> pd.DataFrame:
        """Returns why the runs of each cell ended: `count_outcomes`."""
        return count_outcomes(self._about(), KEYS)

    def same_seeds(self) -> list[str]:
        """Returns of which cells all seeds are one trial, and what to do.

        Scenarios and settings that say the same are one line.
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
            f" trial, so there is one (n = 1, no interval); for others, {how}"
            for how, names in places.items()
        ]

    def summary(self) -> pd.DataFrame:
        """Returns the statistics of each metric in each cell: `summarize`.

        It is empty if no run has given a result.
        """
        runs = self.runs()
        names = [name for name in runs.columns if name in METRICS]
        if runs.empty or not names:
            return pd.DataFrame()
        return summarize(runs, KEYS, metrics=names)

    def _metrics(self) -> dict[str, Any]:
        """Returns the metrics of all runs: who gives no result has failed."""
        columns = self.rows.columns(METRIC_GROUP)
        reasons = np.array(self.rows.texts("end_reason"), dtype=object)
        failed = np.isin(reasons.astype(str), NO_RESULT)
        for name in RATES:
            # Whoever asks for other metrics has none of it.
            if failed.any() and (name in columns or not columns):
                told = columns.get(name, np.full(len(failed), np.nan))
                columns[name] = np.where(failed, 0.0, told)
        return columns

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

    def _about(self) -> pd.DataFrame:
        cells = {cell.name: cell for cell in self.cells}
        of_run = [cells[name] for name in self.rows.texts("cell")]
        about = {key: [getattr(cell, key) for cell in of_run] for key in KEYS}
        return pd.DataFrame(
            {
                **about,
                "seed": self.rows.seeds,
                "repetition": self.rows.repetitions,
                "drawn": [cell.drawn for cell in of_run],
                "end_reason": self.rows.texts("end_reason"),
                "end_message": self.rows.texts("end_message"),
                "end_time": self.rows.end_times,
            }
        )

    def _by_behavior(self, about: pd.DataFrame) -> pd.DataFrame:
        parts = []
        for behavior in self.rows.behaviors():
            group = behavior_group(behavior)
            places, ranks = self.rows.places(group)
            columns = self.rows.columns(group)
            parts.append(
                about.iloc[places].assign(
                    behavior=behavior,
                    **{key: it[places] for key, it in columns.items()},
                    _place=places,
                    _rank=ranks,
                )
            )
        if not parts:
            return pd.DataFrame()
        frame = pd.concat(parts).sort_values(["_place", "_rank"])
        return frame.drop(columns=["_place", "_rank"]).reset_index(drop=True)
