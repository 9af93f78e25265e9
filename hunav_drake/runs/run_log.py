"""The log of a folder: `runs.jsonl`, one line per run, written as it ends.

Whole lines are written at its end, by one process at a time. So whatever stops
one, what was written stays; a last line that was cut off is taken away.
"""

from collections.abc import Iterable, Iterator
import fcntl
import os
from pathlib import Path
import shutil
from typing import TYPE_CHECKING, BinaryIO, Self

from hunav_drake.runs.run_folders import RECORDINGS, REPLAYS
from hunav_drake.runs.run_row import LOST, RunRow, row_from_json, row_to_json

if TYPE_CHECKING:
    from hunav_drake.runs.cells import Cell

NAME = "runs.jsonl"

_CHUNK = 1 << 20


def append_rows(folder: Path, rows: Iterable[RunRow]) -> None:
    """Writes rows to the disk, at the end of the log of a folder.

    Raises:
        OSError: If it cannot be written.
    """
    lines = "".join(row_to_json(row) + "\n" for row in rows)
    if lines:
        with (folder / NAME).open("a+b") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            _cut(file)
            file.write(lines.encode())
            file.flush()
            os.fsync(file.fileno())


def read_rows(path: Path) -> Iterator[RunRow]:
    """Yields the rows of a log, in the order in which the runs ended.

    Those whose workers have died come last, but for those that were done
    afterwards. A last line without an end is left out.

    Raises:
        OSError: If it cannot be read.
        ValueError: If a line is damaged.
    """
    lost: dict[tuple[str, int | None, int], RunRow] = {}
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            if not line.endswith(b"\n"):
                break
            try:
                row = row_from_json(line)
            except ValueError as error:
                raise ValueError(
                    f"{path}:{number}: is damaged: is not a run: {error}; take"
                    " the line out, and its run is done again"
                ) from error
            if row.end_reason == LOST:
                lost[row.key] = row
            else:
                lost.pop(row.key, None)
                yield row
    yield from lost.values()


class RunLog:
    """The runs of a suite in a folder, which no other suite has meanwhile."""

    def __init__(self, folder: Path, *, fresh: bool = False) -> None:
        """Opens the log of a folder, and makes one if there is none.

        Args:
            folder: Where it is.
            fresh: Begins a new one; what was there is `runs_old.jsonl`, and
                recordings and replays are in `recordings_old`, `replays_old`.

        Raises:
            OSError: If it cannot be written.
            BlockingIOError: If somebody else has it open.
        """
        folder.mkdir(parents=True, exist_ok=True)
        self.path = folder / NAME
        # Single runs may be written into the same log meanwhile.
        self._lock = os.open(folder, os.O_RDONLY)
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if fresh:
                self._begin_anew()
            self.path.touch()
        except BlockingIOError as error:
            os.close(self._lock)
            raise BlockingIOError(
                error.errno,
                "is in use by another run of a suite; wait for it, or choose"
                " another folder",
                str(self.path),
            ) from error
        except BaseException:
            os.close(self._lock)
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._lock)

    def append(self, rows: Iterable[RunRow]) -> None:
        """Writes rows to the disk."""
        append_rows(self.path.parent, rows)

    def read(
        self, cells: "Iterable[Cell]", code_sha256: str
    ) -> Iterator[RunRow]:
        """Yields the runs of these cells by this code: see `read_rows`.

        Raises:
            ValueError: If a line is damaged, or a cell has runs of another
                scenario, version or code.
        """
        hashes = {cell.name: cell.sha256 for cell in cells}
        others: dict[str, int] = {}
        for row in read_rows(self.path):
            # What has a folder of its own is of no suite.
            if row.tag or row.cell not in hashes:
                continue
            if (row.sha256, row.code_sha256) == (hashes[row.cell], code_sha256):
                yield row
            else:
                others[row.cell] = others.get(row.cell, 0) + 1
        if others:
            told = ", ".join(f"{n} of {cell}" for cell, n in others.items())
            raise ValueError(
                f"{self.path}: holds runs of other scenarios, behavior trees,"
                f" code or versions ({told}), or their maps, models or other"
                " files have changed: choose another folder, or --fresh, which"
                " keeps them as runs_old.jsonl"
            )

    def _begin_anew(self) -> None:
        """Sets aside what is there: replays of old runs are of other runs."""
        folder = self.path.parent
        if self.path.is_file() and self.path.stat().st_size:
            self.path.replace(folder / "runs_old.jsonl")
        for name in (RECORDINGS, REPLAYS):
            if (folder / name).is_dir():
                shutil.rmtree(folder / f"{name}_old", ignore_errors=True)
                (folder / name).rename(folder / f"{name}_old")


def _cut(file: BinaryIO) -> None:
    """Takes a last line away that was not written to its end."""
    end = size = file.seek(0, os.SEEK_END)
    # Mostly the last byte tells.
    step = 1
    while end > 0:
        start = max(0, end - step)
        file.seek(start)
        found = file.read(end - start).rfind(b"\n")
        if found >= 0:
            end = start + found + 1
            break
        end, step = start, _CHUNK
    if end < size:
        file.truncate(end)
