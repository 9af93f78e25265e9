"""A table of text with a row per run, which many processes may add to."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
import csv
import fcntl
import io
import math
import os
from pathlib import Path
from typing import Any

from hunav_drake.systems.files import atomic_write


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

    The table is written anew and takes its place in one piece, so a reader
    sees it with the row or without. A column that the table has not is added
    to it, empty in the rows before; one that the row has not stays empty in
    it. The caller holds the lock of the folder.

    Args:
        path: The table; it need not exist.
        row: The values by column. NaN is written as nothing.
        delimiter: What stands between two cells.

    Raises:
        OSError: If the table cannot be read or written.
        ValueError: If the file is not such a table.
    """
    columns, rows = _read(path, delimiter) if path.exists() else ([], [])
    columns += [name for name in row if name not in columns]
    text = io.StringIO(newline="")
    writer = csv.DictWriter(
        text, columns, restval="", delimiter=delimiter, lineterminator="\n"
    )
    writer.writeheader()
    writer.writerows(rows)
    writer.writerow({name: _cell(value) for name, value in row.items()})
    with atomic_write(path) as file:
        file.write(text.getvalue().encode())


def _read(path: Path, delimiter: str) -> tuple[list[str], list[dict[str, str]]]:
    try:
        with path.open(newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file, delimiter=delimiter, strict=True)
            rows = list(reader)
    except (csv.Error, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: is not a table of runs: {error}") from error
    columns = list(reader.fieldnames or [])
    for number, row in enumerate(rows, 1):
        # The reader marks what is too much and what is too little by None.
        if None in row or None in row.values():
            raise ValueError(
                f"{path}: is not a table of runs: row {number} does not have"
                f" the {len(columns)} cells of the header"
            )
    return columns, rows


def _cell(value: Any) -> Any:
    return "" if isinstance(value, float) and math.isnan(value) else value
