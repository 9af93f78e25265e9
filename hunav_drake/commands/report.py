"""The command `hunav report`."""

import argparse
from pathlib import Path
import sys
from typing import TYPE_CHECKING, Any

from hunav_drake.commands.errors import DONE, InputError
from hunav_drake.commands.options import add_import_option

if TYPE_CHECKING:
    from hunav_drake.results.trial_result import TrialResult


# How many of the runs that are left out are listed in the terminal.
_MOST_LINES = 5


def add_report_command(commands: Any) -> None:
    """Adds the command `hunav report`."""
    report = commands.add_parser(
        "report",
        help="write a report on all runs of a folder",
        description="Writes a report on all runs of a folder as a web page,"
        " which links to the report and the replay of each run.",
    )
    report.set_defaults(function=_report)
    report.add_argument(
        "directory", type=Path, help="a folder written by `hunav run --out`"
    )
    report.add_argument(
        "-o",
        "--output",
        type=Path,
        help="the file to write; by default report.html in the folder",
    )
    report.add_argument("--title", help="the heading of the report")
    add_import_option(report)


def _report(options: argparse.Namespace) -> int:
    from hunav_drake.report.writing import WriteReport

    directory: Path = options.directory
    results, left_out = _load(directory)
    for tag, reason in list(left_out.items())[:_MOST_LINES]:
        print(f"hunav: left out the run {tag}: {reason}", file=sys.stderr)
    if len(left_out) > _MOST_LINES:
        more = len(left_out) - _MOST_LINES
        print(f"hunav: ... and {more} more: see the report", file=sys.stderr)
    if not results:
        raise InputError(f"{directory}: there is no run to report on")
    try:
        path = WriteReport(
            results,
            options.output or directory / "report.html",
            title=options.title,
            pages=directory,
            left_out=left_out,
        )
    except OSError as error:
        raise InputError(f"{error.filename}: {error.strerror}") from error
    runs = "1 run" if len(results) == 1 else f"{len(results)} runs"
    print(f"Wrote the report on {runs} to {path}")
    return DONE


def _load(directory: Path) -> tuple[list["TrialResult"], dict[str, str]]:
    """Returns the results of a folder, and why any cannot be read, by tag."""
    from hunav_drake.results.files import ListTags, LoadResult

    results, left_out = [], {}
    try:
        tags = ListTags(directory)
    except FileNotFoundError as error:
        raise InputError(
            f"{error.filename}: No such file. `hunav run SCENARIO --out"
            f" {directory}` writes it, with the results of a run."
        ) from error
    except OSError as error:
        raise InputError(f"{error.filename}: {error.strerror}") from error
    except ValueError as error:
        raise InputError(str(error)) from error
    for tag in tags:
        try:
            results.append(LoadResult(directory, tag))
        except OSError as error:
            left_out[tag] = f"{error.filename}: {error.strerror}"
        except ValueError as error:
            left_out[tag] = str(error)
    return results, left_out
