"""Many runs in little memory: their numbers stand in arrays."""

from array import array
from collections.abc import Iterable, Sequence
from sys import intern
from typing import Any, NamedTuple, overload

import numpy as np

from hunav_drake.runs.running.run_row import RunRow
from hunav_drake.systems.common.arrays import Array

# What a row has numbers about: "metrics", "cost", "extras", or a behavior.
Group = tuple[str, ...]
METRICS: Group = ("metrics",)
COST: Group = ("cost",)
EXTRAS: Group = ("extras",)

# The names of the numbers of a row, by group.
_Shape = tuple[tuple[Group, tuple[str, ...]], ...]


class _Head(NamedTuple):
    """What rows have in common with many others."""

    cell: str
    sha256: str
    code_sha256: str
    end_reason: str
    end_message: str


class RunTable(Sequence[RunRow]):
    """Runs, in the order in which they came; recordings are left out.

    A run takes 8 bytes for each of its numbers and some thirty more, a tenth of
    a `RunRow`. Rows are made when they are asked for.
    """

    def __init__(self, rows: Iterable[RunRow] = ()) -> None:
        """Takes the rows in, one by one."""
        self._heads: dict[_Head, int] = {}
        self._shapes: dict[_Shape, int] = {}
        self._head_list: list[_Head] = []
        self._shape_list: list[_Shape] = []
        # The numbers of all rows of a shape, row after row.
        self._numbers: list[array[float]] = []
        self._head = array("l")
        self._shape = array("l")
        self._place = array("q")
        self._seed = array("q")
        self._repetition = array("q")
        self._end_time = array("d")
        for row in rows:
            self.append(row)

    def append(self, row: RunRow) -> None:
        """Adds a run."""
        head = _Head(
            *(row.cell, row.sha256, row.code_sha256),
            *(row.end_reason, row.end_message),
        )
        if head not in self._heads:
            head = _Head(*map(intern, head))
            self._heads[head] = len(self._head_list)
            self._head_list.append(head)
        groups = _groups(row)
        shape = tuple((key, tuple(values)) for key, values in groups)
        if shape not in self._shapes:
            self._shapes[shape] = len(self._shape_list)
            self._shape_list.append(shape)
            self._numbers.append(array("d"))
        kind = self._shapes[shape]
        numbers = self._numbers[kind]
        self._head.append(self._heads[head])
        self._shape.append(kind)
        self._place.append(len(numbers))
        self._seed.append(row.seed)
        self._repetition.append(row.repetition)
        self._end_time.append(row.end_time)
        for _, values in groups:
            numbers.extend(values.values())

    def __len__(self) -> int:
        return len(self._seed)

    @overload
    def __getitem__(self, index: int) -> RunRow: ...

    @overload
    def __getitem__(self, index: slice) -> list[RunRow]: ...

    def __getitem__(self, index: int | slice) -> RunRow | list[RunRow]:
        if isinstance(index, slice):
            return [self[i] for i in range(len(self))[index]]
        index = range(len(self))[index]
        head = self._head_list[self._head[index]]
        shape = self._shape_list[self._shape[index]]
        numbers = self._numbers[self._shape[index]]
        place = self._place[index]
        parts = {}
        for group, names in shape:
            part = numbers[place : place + len(names)]
            parts[group] = dict(zip(names, part, strict=True))
            place += len(names)
        return RunRow(
            cell=head.cell,
            sha256=head.sha256,
            code_sha256=head.code_sha256,
            seed=self._seed[index],
            repetition=self._repetition[index],
            end_reason=head.end_reason,
            end_message=head.end_message,
            end_time=self._end_time[index],
            metrics=parts.pop(METRICS),
            cost=parts.pop(COST),
            extras=parts.pop(EXTRAS),
            by_behavior={key[1]: values for key, values in parts.items()},
        )

    def texts(self, name: str) -> list[str]:
        """Returns one of the texts of all runs: "cell", "end_reason", ..."""
        texts = [getattr(head, name) for head in self._head_list]
        return [texts[i] for i in self._head]

    @property
    def seeds(self) -> Array:
        """The seeds of all runs."""
        return np.array(self._seed, dtype=np.int64)

    @property
    def repetitions(self) -> Array:
        """Which of the runs of its seed each is."""
        return np.array(self._repetition, dtype=np.int64)

    @property
    def end_times(self) -> Array:
        """When each run ended, in seconds."""
        return np.array(self._end_time, dtype=float)

    def behaviors(self) -> list[str]:
        """Returns all behaviors, in the order of the runs that have them."""
        groups = (key for k in self._kinds() for key, _ in self._shape_list[k])
        return list(dict.fromkeys(key[1] for key in groups if len(key) == 2))

    def places(self, group: Group) -> tuple[Any, Any]:
        """Returns which runs have numbers of a group.

        Returns:
            The indices of the runs; and, of how many groups a run has, which
            one this is.
        """
        ranks = np.full(len(self._shape_list), -1)
        for kind, shape in enumerate(self._shape_list):
            for rank, (key, names) in enumerate(shape):
                if key == group and names:
                    ranks[kind] = rank
        found = ranks[np.array(self._shape, dtype=np.int64)]
        indices = np.flatnonzero(found >= 0)
        return indices, found[indices]

    def columns(self, group: Group) -> dict[str, Array]:
        """Returns the numbers of a group by name: shape (runs,), or NaN."""
        columns: dict[str, Array] = {}
        kinds = np.array(self._shape, dtype=np.int64)
        for kind in self._kinds():
            shape = self._shape_list[kind]
            rows = np.flatnonzero(kinds == kind)
            first = np.array(self._place, dtype=np.int64)[rows]
            numbers = np.array(self._numbers[kind])
            start = 0
            for key, names in shape:
                for i, name in enumerate(names if key == group else ()):
                    if name not in columns:
                        columns[name] = np.full(len(self), np.nan)
                    columns[name][rows] = numbers[first + start + i]
                start += len(names)
        return columns

    def sorted(self, order: Array) -> "RunTable":
        """Returns the runs of some indices, in their order.

        Both share their numbers.
        """
        made = RunTable()
        made._heads, made._head_list = self._heads, self._head_list
        made._shapes, made._shape_list = self._shapes, self._shape_list
        made._numbers = self._numbers
        for name in _BY_RUN:
            old: array[float] = getattr(self, name)
            values = np.array(old)[order].tolist()
            setattr(made, name, array(old.typecode, values))
        return made

    def _kinds(self) -> list[int]:
        """Returns the shapes in the order of the runs that have them."""
        kinds, first = np.unique(
            np.array(self._shape, dtype=np.int64), return_index=True
        )
        found: list[int] = kinds[np.argsort(first)].tolist()
        return found


# The arrays with one item for each run.
_BY_RUN = ("_head", "_shape", "_place", "_seed", "_repetition", "_end_time")


def behavior_group(behavior: str) -> Group:
    """Returns the group of the metrics of a behavior."""
    return ("behavior", behavior)


def _groups(row: RunRow) -> list[tuple[Group, dict[str, float]]]:
    return [
        (METRICS, row.metrics),
        (COST, row.cost),
        (EXTRAS, row.extras),
        *((behavior_group(k), v) for k, v in row.by_behavior.items()),
    ]
