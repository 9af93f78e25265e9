"""What all commands of `hunav` share: exit codes, and bad input."""

import argparse
from pathlib import Path
import re
import sys

# The exit codes.
DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

_UNKNOWN_PART = re.compile("there is no (planner|motion model|node|metric) ")


class InputError(Exception):
    """Something that the caller gave cannot be used; the text says what."""


def print_import_hint(error: Exception, options: argparse.Namespace) -> None:
    """Tells how unknown parts are made known, if an error is about one."""
    imports = getattr(options, "imports", ())
    if not imports and _UNKNOWN_PART.search(str(error)):
        print(
            "hunav: parts of your own are made known by --import FILE",
            file=sys.stderr,
        )


def check_new(path: Path, *, force: bool) -> None:
    """Finds out whether a file may be written.

    Raises:
        InputError: If there is one already, and not ``force``.
    """
    if path.exists() and not force:
        raise InputError(f"{path} exists already; --force writes over it")


def check_out(directory: Path) -> None:
    """Finds out before the work whether its results can be kept.

    Raises:
        InputError: If nothing can be written to the folder.
    """
    import tempfile

    from hunav_drake.results.run_folders import RUNS

    try:
        (directory / RUNS).mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=directory / RUNS):
            pass
    except OSError as error:
        raise InputError(
            f"--out {directory}: cannot write there: {error.strerror}. Name a"
            " folder that you may write to."
        ) from error
