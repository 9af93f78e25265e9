"""The table of runs: a row per run, with its metrics."""

from array import array
from collections.abc import Iterable, Iterator, Sequence
import copy
import math
from pathlib import Path
import re
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray
import pandas as pd

from hunav_drake.runs.result_files import read_folder, run_order
from hunav_drake.runs.run_row import (
    NO_RESULT,
    MetricFacts,
    RunRow,
    make_row,
    table_facts,
)
from hunav_drake.runs.statistics import RATES, is_rate
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.files import atomic_write
from hunav_drake.trial.result import CSV_NUMBERS, TrialResult

# Columns of text, even if a value looks like a number.
_TEXTS = (
    *("tag", "scenario", "planner", "setting", "drawn", "end_reason"),
    *("end_message", "behavior"),
)

# Missing values in the other columns.
_MISSING = ["", "nan", "NaN", "NA"]

# The group of a number of a run (one of these, or a behavior), and its name.
_Key = tuple[str, str]
_GROUPS = ("metrics", "cost", "extras")
_BEHAVIOR = "behavior "

# A missing seed.
_NO_SEED = -1


def ReadRuns(path: str | Path, *, by_behavior: bool = False) -> pd.DataFrame:
    """Returns the table of all runs in a folder, or of a file.

    Args:
        path: A folder of results of `hunav run --out`, `hunav evaluate --out`,
            `hunav bench`, the editor or `WriteResult`; or a table, such as the
            `runs.csv` in it. No recording is read.
        by_behavior: Returns a row for each behavior of each run, with the
            metrics as if only the people of that behavior existed, and the
            column `behavior`.

    Returns:
        A row per run: tag (the name of its folder; empty in a suite),
        scenario, planner, setting, seed (empty if there is none), repetition,
        drawn (what the seed draws; "nothing" if all seeds give the same trial;
        empty if unknown), end_reason, end_message, end_time in seconds, and a
        column per metric. The metrics of a run without a result are NaN, but
        `completed` is 0. For a folder, `attrs` has the "units", "families" and
        "directions" of the metrics, by name.

    Raises:
        OSError: If it cannot be read, or there are no results.
        ValueError: If a run is damaged, or the file is not a table.
    """
    path = Path(path)
    if path.is_dir():
        table = RunTable(read_folder(path)).sorted()
        return table.frame(by_behavior=by_behavior)
    try:
        columns = pd.read_csv(path, nrows=0, compression=None).columns
        if len(columns) == 1 and re.search("[;\t]", columns[0]):
            raise ValueError("its columns must be separated by commas")
        missing = {c: _MISSING for c in columns if c not in _TEXTS}
        return pd.read_csv(
            path,
            compression=None,
            dtype=dict.fromkeys(_TEXTS, str),
            keep_default_na=False,
            na_values=missing,
        )
    except ValueError as error:
        raise ValueError(
            f"{path}: is not a table of runs: {str(error).strip()}"
        ) from error


def tabulate_runs(
    results: Iterable[TrialResult], *, by_behavior: bool = False
) -> pd.DataFrame:
    """Returns the table of `ReadRuns` for results in memory."""
    return RunTable(map(make_row, results)).frame(by_behavior=by_behavior)


def WriteTables(results: Iterable[TrialResult], folder: Path) -> Path:
    """Writes `runs.csv` and `runs_by_behavior.csv`, for spreadsheets.

    Numbers have twelve digits; NaN is an empty cell.

    Returns:
        The path of `runs.csv`.

    Raises:
        OSError: If a file cannot be written.
    """
    table = RunTable(map(make_row, results))
    for name, by_behavior in (("runs_by_behavior", True), ("runs", False)):
        path = folder / f"{name}.csv"
        with atomic_write(path) as file:
            frame = table.frame(by_behavior=by_behavior)
            text = frame.to_csv(index=False, float_format=CSV_NUMBERS)
            file.write(text.encode())
    return path


class RunTable(Sequence[RunRow]):
    """Runs without recordings, in the order in which they were added.

    A run takes 8 bytes for each of its numbers and about thirty more, a tenth
    of a `RunRow`. Rows are created on access.
    """

    def __init__(self, rows: Iterable[RunRow] = ()) -> None:
        """Adds rows, one by one."""
        # Texts and the names of numbers, which many runs share; and the index
        # of each.
        self._heads: list[tuple[RunRow, tuple[_Key, ...]]] = []
        self._places: dict[Any, int] = {}
        self._shapes: dict[tuple[_Key, ...], tuple[_Key, ...]] = {}
        # Facts about metrics that are not part of this package.
        self.facts: dict[str, MetricFacts] = {}
        self._head = array("l")
        self._seed = array("q")
        self._repetition = array("q")
        self._end_time = array("d")
        # Columns of numbers, which may be shorter; the rest is NaN.
        self._numbers: dict[_Key, array[float]] = {}
        # The indices of the runs in the table; None for all.
        self._chosen: NDArray[np.int64] | None = None
        for row in rows:
            self.append(row)

    def append(self, row: RunRow) -> None:
        """Adds a run."""
        numbers = dict(_numbers(row))
        names = tuple(numbers)
        shape = self._shapes.setdefault(names, names)
        texts = (value for value in row if isinstance(value, str))
        about = row.provenance.items(), row.by_behavior, row.facts
        head = (*texts, id(shape), *map(tuple, about))
        if head not in self._places:
            self._places[head] = len(self._heads)
            shared = row._replace(
                metrics={},
                cost={},
                extras={},
                by_behavior={name: {} for name in row.by_behavior},
                recording=None,
            )
            self._heads.append((shared, shape))
            self.facts |= row.facts
        for key, value in numbers.items():
            column = self._numbers.setdefault(key, array("d"))
            column.extend([math.nan] * (len(self._head) - len(column)))
            column.append(value)
        self._head.append(self._places[head])
        self._seed.append(_NO_SEED if row.seed is None else row.seed)
        self._repetition.append(row.repetition)
        self._end_time.append(row.end_time)

    def __len__(self) -> int:
        return len(self._head if self._chosen is None else self._chosen)

    @overload
    def __getitem__(self, index: int) -> RunRow: ...

    @overload
    def __getitem__(self, index: slice) -> list[RunRow]: ...

    def __getitem__(self, index: int | slice) -> RunRow | list[RunRow]:
        if isinstance(index, slice):
            return [self[i] for i in range(len(self))[index]]
        i = range(len(self))[index]
        i = i if self._chosen is None else int(self._chosen[i])
        shared, shape = self._heads[self._head[i]]
        parts: dict[str, dict[str, float]] = {}
        for group, name in shape:
            value = self._numbers[group, name][i]
            parts.setdefault(group, {})[name] = value
        seed = self._seed[i]
        return shared._replace(
            seed=None if seed == _NO_SEED else seed,
            repetition=self._repetition[i],
            end_time=self._end_time[i],
            metrics=parts.get("metrics", {}),
            cost=parts.get("cost", {}),
            extras=parts.get("extras", {}),
            by_behavior={
                it: parts.get(_BEHAVIOR + it, {}) for it in shared.by_behavior
            },
        )

    def texts(self, name: str) -> list[str]:
        """Returns a text of each run: "cell", "end_reason", ..."""
        texts = [getattr(shared, name) for shared, _ in self._heads]
        return [texts[i] for i in self._of_runs(self._head)]

    @property
    def seeds(self) -> NDArray[np.int64]:
        """The seeds of all runs; -1 for none."""
        return self._of_runs(self._seed)

    @property
    def repetitions(self) -> NDArray[np.int64]:
        """The repetition of each run among those of its seed."""
        return self._of_runs(self._repetition)

    def columns(self, group: str) -> dict[str, Array]:
        """Returns the numbers of a group by name: shape (runs,), NaN for none.

        Args:
            group: "metrics", "cost" or "extras".
        """
        columns: dict[str, Array] = {}
        for its, name in self._keys():
            if its == group:
                numbers = self._numbers[its, name]
                missing = [math.nan] * (len(self._head) - len(numbers))
                columns[name] = self._of_runs([*numbers, *missing])
        return columns

    def sorted(self, order: NDArray[np.int64] | None = None) -> "RunTable":
        """Returns the runs of some indices, in their order.

        Both share their numbers.

        Args:
            order: The indices; by default those of all runs by tag, scenario,
                planner, setting, seed and repetition.
        """
        if order is None:
            names = [run_order(shared)[:-2] for shared, _ in self._heads]
            ranks = {it: i for i, it in enumerate(sorted(set(names)))}
            rank = np.array([ranks[it] for it in names], dtype=np.int64)
            heads = self._of_runs(self._head)
            order = np.lexsort((self.repetitions, self.seeds, rank[heads]))
        made = copy.copy(self)
        made._chosen = order if self._chosen is None else self._chosen[order]
        return made

    def frame(
        self, *, by_behavior: bool = False, extras: bool = False
    ) -> pd.DataFrame:
        """Returns the table in pandas: see `ReadRuns`.

        Args:
            by_behavior: Whether to return a row for each behavior of each run.
            extras: Whether to add the columns of `extra_values`.
        """
        seeds: Any = self.seeds
        if (seeds == _NO_SEED).any():
            seeds = ["" if it == _NO_SEED else int(it) for it in seeds]
        names = ("tag", "scenario", "planner", "setting")
        about = pd.DataFrame(
            {
                **{name: self.texts(name) for name in names},
                "seed": seeds,
                "repetition": self.repetitions,
                "drawn": self.texts("drawn"),
                "end_reason": self.texts("end_reason"),
                "end_message": self.texts("end_message"),
                "end_time": self._of_runs(self._end_time),
            }
        )
        if by_behavior:
            frame = self._by_behavior(about)
        else:
            columns = self._metrics(about)
            columns |= self.columns("extras") if extras else {}
            frame = pd.concat(
                [about, pd.DataFrame(columns, about.index)], axis=1
            )
        frame.attrs |= table_facts(
            (name for group, name in self._keys() if group == "metrics"),
            self.facts,
        )
        return frame

    def _metrics(self, about: pd.DataFrame) -> dict[str, Array]:
        """Returns the metrics; runs without a result are not completed."""
        columns = self.columns("metrics")
        failed = about["end_reason"].isin(NO_RESULT).to_numpy()
        if not failed.any():
            return columns
        # Unless the scenarios do not compute it.
        if not columns:
            columns = {it: np.full(len(failed), np.nan) for it in RATES}
        rates = [*filter(is_rate, columns)]
        if not rates:
            return columns
        table = pd.DataFrame({it: columns[it] for it in rates}, about.index)
        told = table.notna().assign(ran=~failed)
        keys = [about["scenario"], about["setting"]]
        ours, all_ours = (
            told.groupby(by, sort=False).transform("any")
            for by in (keys, keys[:1])
        )
        # If all runs of a setting failed, it has the rates of its scenario; if
        # all runs of that failed, it may have any.
        told = ours.where(ours["ran"], all_ours)
        told[~told["ran"]] = True
        for name in rates:
            missed = failed & told[name].to_numpy()
            columns[name] = np.where(missed, 0.0, columns[name])
        return columns

    def _by_behavior(self, about: pd.DataFrame) -> pd.DataFrame:
        groups = dict.fromkeys(
            group for group, _ in self._keys() if group.startswith(_BEHAVIOR)
        )
        heads = self._of_runs(self._head)
        parts = []
        for group in groups:
            has = [
                any(it == group for it, _ in shape) for _, shape in self._heads
            ]
            places = np.flatnonzero(np.array(has)[heads])
            columns = self.columns(group)
            numbers = {name: it[places] for name, it in columns.items()}
            own = about.iloc[places].assign(
                behavior=group.removeprefix(_BEHAVIOR)
            )
            parts.append(
                pd.concat([own, pd.DataFrame(numbers, own.index)], axis=1)
            )
        if not parts:
            return pd.DataFrame()
        frame = pd.concat(parts).sort_index(kind="stable")
        return frame.reset_index(drop=True)

    def _keys(self) -> list[_Key]:
        """Returns the groups and names of all numbers, in order."""
        heads, first = np.unique(self._of_runs(self._head), return_index=True)
        shapes = (self._heads[i][1] for i in heads[np.argsort(first)])
        return list(dict.fromkeys(key for shape in shapes for key in shape))

    def _of_runs(self, values: Any) -> NDArray[Any]:
        """Returns those of the values of all runs that are in the table."""
        found = np.array(values, dtype=getattr(values, "typecode", None))
        return found if self._chosen is None else found[self._chosen]


def _numbers(row: RunRow) -> Iterator[tuple[_Key, float]]:
    for group in _GROUPS:
        for name, value in getattr(row, group).items():
            yield (group, name), value
    for behavior, values in row.by_behavior.items():
        for name, value in values.items():
            yield (_BEHAVIOR + behavior, name), value
