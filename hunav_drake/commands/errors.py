"""Exit codes and input errors of the commands of `hunav`."""

import argparse
from pathlib import Path
import re
import sys

# The exit codes.
DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

_UNKNOWN_PART = re.compile("there is no (planner|motion model|node|metric) ")


class InputError(Exception):
    """The input of the user cannot be used; the text says why."""


def print_import_hint(error: Exception, options: argparse.Namespace) -> None:
    """Prints how to import user code, if an error is about an unknown part."""
    imports = getattr(options, "imports", ())
    if not imports and _UNKNOWN_PART.search(str(error)):
        print(
            "hunav: import a part of your own with --import FILE",
            file=sys.stderr,
        )


def check_new(path: Path, *, force: bool) -> None:
    """Checks that a file may be written.

    Raises:
        InputError: If the file exists, unless ``force``.
    """
    if path.exists() and not force:
        raise InputError(f"{path} already exists; overwrite it with --force")


def check_out(directory: Path) -> None:
    """Checks, before a run, that its results can be written.

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
