"""A table of text that many processes may add rows to."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
import csv
import fcntl
import io
import math
import os
from pathlib import Path
from typing import Any

from hunav_drake.systems.common.files import atomic_write


@contextmanager
def locked(directory: Path) -> Iterator[None]:
    """Keeps other processes and threads out of a folder of results.

    It waits until the folder is free. The lock ends with the block, or with
    the process, however that ends.

    Raises:
        OSError: If the folder cannot be opened.
    """
    handle = os.open(directory, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def append_row(
    path: Path, row: Mapping[str, Any], *, delimiter: str = ","
) -> None:
    """Adds a row to a table, or begins the table with it.

    The table takes its place in one piece, so a reader sees it with the row
    or without. A column that the table has not is added to it, empty in the
    rows before; one that the row has not stays empty in it. A row that begins
    with the same cell is replaced: what a killed writer has left. The caller
    holds the lock of the folder.

    Args:
        path: The table; it need not exist.
        row: The values by column; the first one tells it from others. NaN is
            written as nothing.
        delimiter: What stands between two cells.

    Raises:
        OSError: If the table cannot be read or written.
        ValueError: If the file is not such a table.
    """
    text, (columns, rows) = "", read_rows(path, delimiter)
    new = [name for name in row if name not in columns]
    key, value = next(iter(row.items()))
    at = columns.index(key) if key in columns else None
    kept = [r for r in rows if at is None or r[at] != str(value)]
    if columns and not new and len(kept) == len(rows):
        # Most of the time, and much faster than to write every cell again.
        text = path.read_bytes().decode()
        text += "" if text.endswith("\n") else "\n"
        kept = []
    else:
        columns = [*columns, *new]
        text = _line(columns, delimiter)
    filled = [r + [""] * len(new) for r in kept]
    cells = [_cell(row.get(name, "")) for name in columns]
    text += "".join(_line(r, delimiter) for r in [*filled, cells])
    with atomic_write(path) as file:
        file.write(text.encode())


def read_rows(
    path: Path, delimiter: str = ","
) -> tuple[list[str], list[list[str]]]:
    """Returns the columns and the rows of a table; none if there is no file.

    Raises:
        OSError: If the table cannot be read.
        ValueError: If the file is not such a table.
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            reader = csv.reader(file, delimiter=delimiter, strict=True)
            columns, *rows = [row for row in reader if row] or [[]]
    except FileNotFoundError:
        return [], []
    except (csv.Error, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: is not a table of runs: {error}") from error
    for number, row in enumerate(rows, 1):
        if len(row) != len(columns):
            raise ValueError(
                f"{path}: is not a table of runs: row {number} does not have"
                f" the {len(columns)} cells of the header"
            )
    return columns, rows


def _line(cells: list[Any], delimiter: str) -> str:
    text = io.StringIO(newline="")
    csv.writer(text, delimiter=delimiter, lineterminator="\n").writerow(cells)
    return text.getvalue()


def _cell(value: Any) -> Any:
    return "" if isinstance(value, float) and math.isnan(value) else value
