"""The log of a folder: `runs.jsonl`, one line per run, written when it ends.

Complete lines are appended, by one process at a time. So a crash loses no
line that was written; an incomplete last line is removed.
"""

from collections.abc import Iterable, Iterator
import fcntl
import itertools
import os
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Self

from hunav_drake.runs.run_folders import RECORDINGS, REPLAYS
from hunav_drake.runs.run_row import LOST, RunRow, row_from_json, row_to_json

if TYPE_CHECKING:
    from hunav_drake.runs.cells import Cell

NAME = "runs.jsonl"

_CHUNK = 1 << 20


def append_rows(folder: Path, rows: Iterable[RunRow]) -> None:
    """Appends rows to the log of a folder, and syncs them to disk.

    Raises:
        OSError: If it cannot be written.
    """
    lines = "".join(row_to_json(row) + "\n" for row in rows)
    path = folder / NAME
    if lines:
        try:
            with path.open("a+b") as file:
                fcntl.flock(file, fcntl.LOCK_EX)
                _cut(file)
                file.write(lines.encode())
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            # The error of a full disk has no file.
            raise OSError(error.errno, error.strerror, str(path)) from error


def read_rows(path: Path) -> Iterator[RunRow]:
    """Yields the rows of a log, in the order in which the runs ended.

    Runs whose worker died come last, unless they were repeated with success.
    An incomplete last line is skipped.

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
                    f"{path}:{number}: is damaged: is not a run: {error};"
                    " delete the line, and its run is repeated"
                ) from error
            if row.end_reason == LOST:
                lost[row.key] = row
            else:
                lost.pop(row.key, None)
                yield row
    yield from lost.values()


class RunLog:
    """The log of a suite in a folder, which it locks for other suites."""

    def __init__(self, folder: Path, *, fresh: bool = False) -> None:
        """Opens or creates the log of a folder.

        Args:
            folder: The folder, which is created if necessary.
            fresh: Starts a new log; the old one becomes `runs_old.jsonl`, and
                recordings and replays go to `recordings_old`, `replays_old`;
                to `runs_old_2.jsonl` and so on if there are such.

        Raises:
            OSError: If it cannot be written.
            BlockingIOError: If another suite uses it.
        """
        folder.mkdir(parents=True, exist_ok=True)
        self.path = folder / NAME
        # The lock is on the folder: single runs may still append to the log.
        self._lock = os.open(folder, os.O_RDONLY)
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if fresh:
                self._begin_anew()
            if not self.path.is_file():
                self.path.touch()
        except BlockingIOError as error:
            os.close(self._lock)
            raise BlockingIOError(
                error.errno,
                "is in use by another suite; wait until it ends, or choose"
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
        """Yields the runs of some cells: see `read_rows`.

        Raises:
            ValueError: If a line is damaged, or a cell has runs of another
                scenario, version or code.
        """
        hashes = {cell.name: cell.sha256 for cell in cells}
        others: dict[str, int] = {}
        for row in read_rows(self.path):
            # A run with its own folder does not belong to a suite.
            if row.tag or row.cell not in hashes:
                continue
            if (row.sha256, row.code_sha256) == (hashes[row.cell], code_sha256):
                yield row
            else:
                others[row.cell] = others.get(row.cell, 0) + 1
        if others:
            counts = ", ".join(f"{n} of {cell}" for cell, n in others.items())
            raise ValueError(
                f"{self.path}: holds runs of other scenarios, behavior trees,"
                f" code or versions ({counts}), or their maps, models or other"
                " files have changed: choose another folder, or --fresh, which"
                " keeps them as runs_old.jsonl"
            )

    def _begin_anew(self) -> None:
        """Renames the old files; old replays do not show the new runs.

        Those that are old already stay: the ones between may be few.
        """
        names = (self.path.name, RECORDINGS, REPLAYS)
        paths = [self.path.with_name(name) for name in names]
        if self.path.is_file() and not self.path.stat().st_size:
            self.path.unlink()
        for i in itertools.count(1):
            end = "_old" if i == 1 else f"_old_{i}"
            old = [it.with_stem(it.stem + end) for it in paths]
            if not any(it.exists() for it in old):
                break
        for path, new in zip(paths, old, strict=True):
            if path.exists():
                path.rename(new)


def _cut(file: BinaryIO) -> None:
    """Removes an incomplete last line."""
    end = size = file.seek(0, os.SEEK_END)
    # The last byte is usually a line end.
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
