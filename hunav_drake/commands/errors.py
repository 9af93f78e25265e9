"""Exit codes and input errors of the commands of `hunav`."""

import argparse
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
import re
import sys

from hunav_drake.systems.common.input_error import InputError

# The exit codes.
DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

_UNKNOWN_PART = re.compile("there is no (planner|motion model|node|metric) ")


def print_import_hint(error: Exception, options: argparse.Namespace) -> None:
    """Prints how to import user code, if an error is about an unknown part."""
    imports = getattr(options, "imports", ())
    if not imports and _UNKNOWN_PART.search(str(error)):
        print(
            "hunav: import your own parts with --import FILE", file=sys.stderr
        )


def os_error_text(error: OSError, place: str | Path = "") -> str:
    """Returns an OSError as text, with its place, by default its file."""
    place = place or error.filename or ""
    fault = error.strerror or str(error)
    return f"{place}: {fault}" if place else fault


@contextmanager
def input_errors(
    *kinds: type[Exception], place: str | Path = ""
) -> Iterator[None]:
    """Turns OSError and errors of these kinds into InputError.

    The message of an OSError names `place`, by default the error's file.
    """
    try:
        yield
    except OSError as error:
        raise InputError(os_error_text(error, place)) from error
    except kinds as error:
        raise InputError(str(error)) from error


def check_each(
    names: Iterable[str],
    options: argparse.Namespace,
    describe: Callable[[str], str],
) -> int:
    """Prints the content or the faults of each file; returns the exit code."""
    code = DONE
    for name in names:
        try:
            print(f"{name}: ok ({describe(name)})")
        except InputError as error:
            print(error, file=sys.stderr)
            print_import_hint(error, options)
            code = BAD_INPUT
    return code


def write_output(text: str, options: argparse.Namespace, done: str) -> int:
    """Writes a text to the file of `--output`, or prints it.

    Raises:
        InputError: If the file exists, unless by `--force`, or cannot be
            written.
    """
    from hunav_drake.systems.common.files import atomic_write

    output: Path | None = options.output
    if output is None:
        print(text, end="")
        return DONE
    check_output(output, options.force)
    with input_errors(place=output), atomic_write(output) as file:
        file.write(text.encode())
    print(done)
    return DONE


@contextmanager
def output_errors(out: Path) -> Iterator[None]:
    """Turns errors of writing results to `--out` into InputError."""
    try:
        yield
    except OSError as error:
        raise InputError(os_error_text(error, f"--out {out}")) from error
    except ValueError as error:
        raise InputError(f"--out {out}: {error}") from error


def check_output(path: Path, force: bool = True) -> None:
    """Checks that a file does not exist, unless forced, and its folder does."""
    if path.exists() and not force:
        raise InputError(f"{path} already exists; overwrite it with --force")
    if not path.resolve().parent.is_dir():
        raise InputError(
            f"{path}: there is no folder {path.parent}; make it first"
        )


def check_once(files: Iterable[Path]) -> None:
    """Checks that no recording is named twice, as it would count twice."""
    seen = set()
    for file in files:
        if file.resolve() in seen:
            raise InputError(f"{file}: is named twice; leave one out")
        seen.add(file.resolve())


def check_page(path: Path, option: str) -> None:
    """Checks that a file can be written, and makes its folder."""
    if path.is_dir():
        raise InputError(
            f"{option} {path}: is a folder; name a file, such as"
            f" {path / 'results.md'}"
        )
    check_out(path.parent, "", option)


def check_out(folder: Path, inner: str = "runs", option: str = "--out") -> None:
    """Checks that results can be written to a folder."""
    import tempfile

    try:
        (folder / inner).mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder / inner):
            pass
    except OSError as error:
        raise InputError(
            f"{option} {folder}: cannot write there: {error.strerror}. Name a"
            " folder that you may write to."
        ) from error
