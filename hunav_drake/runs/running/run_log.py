"""The log of a suite: one line per run, written as it ends.

Only the driver writes to it, whole lines at its end, so that whatever stops
it, what was written stays; a last line that was cut off is taken away.
"""

from collections.abc import Iterable, Iterator
import fcntl
import os
from pathlib import Path
import shutil
from typing import BinaryIO, Self

from hunav_drake.runs.running.cell import Cell
from hunav_drake.runs.running.recordings import FOLDER, REPLAYS
from hunav_drake.runs.running.run_row import (
    LOST,
    RunRow,
    row_from_json,
    row_to_json,
)

NAME = "runs.jsonl"

_CHUNK = 1 << 20


class RunLog:
    """The runs of a folder; it is locked while it is open."""

    def __init__(self, folder: Path, *, fresh: bool = False) -> None:
        """Opens the log of a folder, and makes one if there is none.

        Args:
            folder: Where it is.
            fresh: Begins a new one; what was there is `runs_old.jsonl`, and
                recordings and replays are in `recordings_old`, `replays_old`.

        Raises:
            OSError: If it cannot be written.
            BlockingIOError: If somebody else has it open.
            ValueError: If a line, but for the last, is damaged.
        """
        folder.mkdir(parents=True, exist_ok=True)
        self.path = folder / NAME
        self._file: BinaryIO = self.path.open("a+b")
        try:
            self._lock()
            if fresh:
                self._begin_anew()
            self._cut()
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def append(self, rows: Iterable[RunRow]) -> None:
        """Writes rows to the disk."""
        lines = [row_to_json(row) + "\n" for row in rows]
        if lines:
            self._file.write("".join(lines).encode())
            self._file.flush()
            os.fsync(self._file.fileno())

    def read(self, cells: Iterable[Cell], code_sha256: str) -> Iterator[RunRow]:
        """Yields the runs of these cells by this code, one by one.

        Those whose workers have died come last, but for those that were done
        afterwards.

        Raises:
            ValueError: If a line is damaged, or a cell has runs of another
                scenario, version or code.
        """
        hashes = {cell.name: cell.sha256 for cell in cells}
        others: dict[str, int] = {}
        lost: dict[tuple[str, int, int], RunRow] = {}
        for row in read_rows(self.path):
            made = hashes.get(row.cell), code_sha256
            if made == (row.sha256, row.code_sha256):
                key = row.cell, row.seed, row.repetition
                if row.end_reason == LOST:
                    lost[key] = row
                    continue
                lost.pop(key, None)
                yield row
            elif row.cell in hashes:
                others[row.cell] = others.get(row.cell, 0) + 1
        if others:
            told = ", ".join(f"{n} of {cell}" for cell, n in others.items())
            raise ValueError(
                f"{self.path}: holds runs of other scenarios, behavior trees,"
                f" code or versions ({told}), or their maps, models or other"
                " files have changed: choose another folder, or --fresh, which"
                " keeps them as runs_old.jsonl"
            )
        yield from lost.values()

    def _begin_anew(self) -> None:
        """Sets aside what is there: replays of old runs are of other runs."""
        folder = self.path.parent
        if self.path.stat().st_size:
            self._file.close()
            self.path.replace(folder / "runs_old.jsonl")
            self._file = self.path.open("a+b")
            self._lock()
        for name in (FOLDER, REPLAYS):
            if (folder / name).is_dir():
                shutil.rmtree(folder / f"{name}_old", ignore_errors=True)
                (folder / name).rename(folder / f"{name}_old")

    def _lock(self) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise BlockingIOError(
                error.errno,
                "is in use by another run of a suite; wait for it, or choose"
                " another folder",
                str(self.path),
            ) from error

    def _cut(self) -> None:
        """Takes a last line away that was not written to its end."""
        size = self._file.seek(0, os.SEEK_END)
        end = size
        while end > 0:
            start = max(0, end - _CHUNK)
            self._file.seek(start)
            found = self._file.read(end - start).rfind(b"\n")
            if found >= 0:
                end = start + found + 1
                break
            end = start
        if end < size:
            self._file.truncate(end)


def read_rows(path: Path) -> Iterator[RunRow]:
    """Yields the rows of a log, in the order in which the runs ended.

    Raises:
        OSError: If it cannot be read.
        ValueError: If a line is damaged; a last one without an end is left
            out.
    """
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            if not line.endswith(b"\n"):
                return
            try:
                yield row_from_json(line)
            except ValueError as error:
                raise ValueError(
                    f"{path}:{number}: is damaged: {error}; take the line out,"
                    " and its run is done again"
                ) from error
