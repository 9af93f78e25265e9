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

RUNS = "runs"

# What a rename says where a file, or a folder with files, is in its way.
_TAKEN = (errno.EEXIST, errno.ENOTEMPTY, errno.ENOTDIR)


def find_runs(directory: str | Path) -> dict[str, Path]:
    """Returns the folders of the runs in a folder of results, by their tags.

    The order is that of the tags, with numbers in them by their size. Nothing
    is read, so a run may turn out to be damaged. The folder need not exist.
    """
    runs = Path(directory) / RUNS
    found = {
        path.name: path
        for path in (runs.iterdir() if runs.is_dir() else ())
        if path.is_dir() and not path.name.startswith(".")
    }
    return {tag: found[tag] for tag in sorted(found, key=_natural)}


def find_pages(directory: str | Path, tag: str) -> dict[str, Path]:
    """Returns the pages of a run that there are, "report" and "replay"."""
    folder = Path(directory) / RUNS / tag
    return {
        kind: folder / f"{kind}.html"
        for kind in ("report", "replay")
        if tag and (folder / f"{kind}.html").exists()
    }


def write_run_folder(path: Path, write: Callable[[Path], None]) -> bool:
    """Writes a folder that takes its name only when it is complete.

    The parent exists; `write` is given the folder to write into. If that raises
    an OSError, nothing is left.

    Returns:
        Whether it was done: not if there is a folder of that name by now.
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
