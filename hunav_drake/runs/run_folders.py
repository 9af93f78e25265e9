"""The layout of a folder of results.

The files of a single run are in `runs/<tag>/`. A suite keeps a recording of
each cell in `recordings/`, and a replay in `replays/`.

A single run is written to a hidden folder, which is renamed when it is
complete. So each folder in `runs/` whose name does not start with a dot is a
complete run, even if several processes write or one is killed; hidden folders
are never read, and can be deleted.
"""

from collections.abc import Callable
import errno
import os
from pathlib import Path
import re
import secrets
import shutil

from hunav_drake.runs.run_row import RunRow
from hunav_drake.systems.common.files import file_name_part

RUNS = "runs"
RECORDINGS = "recordings"
REPLAYS = "replays"

# The maximum length of a file name that is made of other names.
_LONGEST = 160

# Errors of a rename if the new name is taken.
_TAKEN = (errno.EEXIST, errno.ENOTEMPTY, errno.ENOTDIR)


def find_runs(directory: str | Path) -> dict[str, Path]:
    """Returns the folders of the runs in a folder of results, by their tags.

    They are sorted by tag, with numbers in tags by value. No file is read. The
    folder need not exist.
    """
    runs = Path(directory) / RUNS
    found = {
        path.name: path
        for path in (runs.iterdir() if runs.is_dir() else ())
        if path.is_dir() and not path.name.startswith(".")
    }
    return {tag: found[tag] for tag in sorted(found, key=natural_key)}


def find_pages(directory: str | Path, tag: str) -> dict[str, Path]:
    """Returns the existing pages of a run, "report" and "replay"."""
    folder = Path(directory) / RUNS / tag
    return {
        kind: folder / f"{kind}.html"
        for kind in ("report", "replay")
        if tag and (folder / f"{kind}.html").exists()
    }


def write_run_folder(path: Path, write: Callable[[Path], None]) -> bool:
    """Writes a folder under a hidden name, and renames it when complete.

    Args:
        path: The folder; its parent exists.
        write: Writes the files to the folder that it gets. If it raises an
            OSError, nothing is left.

    Returns:
        False if the name is taken by now.
    """
    draft = path.with_name(f".{path.name}.{secrets.token_hex(8)}.tmp")
    try:
        draft.mkdir()
        write(draft)
        os.rename(draft, path)
    except OSError as error:
        if str(error.filename2) == str(path) and error.errno in _TAKEN:
            return False
        raise
    finally:
        shutil.rmtree(draft, ignore_errors=True)
    return True


def recording_path(folder: Path, cell: str, seed: int) -> Path:
    """Returns the path of the recording of a run of a suite."""
    name = file_name_part(cell)[:_LONGEST].lstrip(".-")
    return folder / RECORDINGS / f"{name}_{seed}.npz"


def replay_path(folder: Path, cell: str, seed: int) -> Path:
    """Returns the path of the replay of a run of a suite."""
    return folder / REPLAYS / f"{recording_path(folder, cell, seed).stem}.html"


def find_recording(folder: Path, row: RunRow) -> Path | None:
    """Returns the path of the recording of a run; None if there is none."""
    if row.tag:
        return folder / RUNS / row.tag / "recording.npz"
    if row.seed is None or row.repetition:
        return None
    path = recording_path(folder, row.cell, row.seed)
    return path if path.is_file() else None


def natural_key(tag: str) -> tuple[tuple[int, str], ...]:
    """Returns a key that sorts "run_2" before "run_10"."""
    return tuple(
        (int(part), "") if part.isdecimal() else (-1, part)
        for part in re.split(r"(\d+)", tag)
    )
