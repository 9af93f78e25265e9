"""Where the runs are in a folder of results: `runs/<tag>/`.

A run is written into a hidden folder beside, which takes its name when it is
complete. So a folder in `runs/` whose name does not begin with a dot is a
whole run, whoever else writes at the time, and whenever a writer is killed;
what that one leaves is never read, and can be deleted.
"""

from collections.abc import Callable
import errno
import os
from pathlib import Path
import re
import secrets
import shutil
from typing import NamedTuple

RUNS = "runs"

# What a rename says where a file, or a folder with files, is in its way.
_TAKEN = (errno.EEXIST, errno.ENOTEMPTY, errno.ENOTDIR)


class RunFiles(NamedTuple):
    """The files that a run is read from."""

    summary: Path
    recording: Path


def find_runs(directory: str | Path) -> dict[str, RunFiles]:
    """Returns the runs in a folder of results, by their tags.

    The order is that of the tags, with numbers in them by their size. Nothing
    is read, so a run may turn out to be damaged. Versions before runs had
    folders wrote `result_<tag>.json` and `recording_<tag>.npz`: these are
    found, too.

    Args:
        directory: The folder of results; it need not exist.

    Raises:
        OSError: If the folder cannot be read.
    """
    directory = Path(directory)
    found = {
        tag: RunFiles(path, directory / f"recording_{tag}.npz")
        for path in directory.glob("result_*.json")
        if (tag := path.stem.removeprefix("result_"))
    }
    if (directory / RUNS).is_dir():
        for path in (directory / RUNS).iterdir():
            if path.is_dir() and not path.name.startswith("."):
                found[path.name] = RunFiles(
                    path / "result.json", path / "recording.npz"
                )
    return {tag: found[tag] for tag in sorted(found, key=_natural)}


def find_pages(directory: str | Path, tag: str) -> dict[str, Path]:
    """Returns the pages of a run that there are, "report" and "replay"."""
    directory = Path(directory)
    return {
        kind: path
        for kind in ("report", "replay")
        for path in (
            directory / f"{kind}_{tag}.html",
            directory / RUNS / tag / f"{kind}.html",
        )
        if tag and path.exists()
    }


def write_run_folder(path: Path, write: Callable[[Path], None]) -> bool:
    """Writes a folder that takes its name only when it is complete.

    Args:
        path: The name to be, in a folder that exists.
        write: Writes the files into the folder that it is given.

    Returns:
        Whether it was done: not if there is a folder of that name by now.

    Raises:
        OSError: If something cannot be written; nothing is left then.
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


def _natural(tag: str) -> list[tuple[int, str]]:
    """Returns a key that sorts "run_2" before "run_10"."""
    return [
        (int(part), "") if part.isdecimal() else (-1, part)
        for part in re.split(r"(\d+)", tag)
    ]
