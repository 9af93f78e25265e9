"""The command `hunav report`."""

import argparse
from pathlib import Path
from typing import Any

from hunav_drake.command_errors import DONE, InputError


def add_report_command(commands: Any) -> None:
    """Adds the command to those of `hunav`."""
    report = commands.add_parser(
        "report", help="make a report on all runs of a folder"
    )
    report.set_defaults(function=_report)
    report.add_argument(
        "directory", type=Path, help="what `hunav run --out` has written to"
    )
    report.add_argument(
        "-o",
        "--output",
        type=Path,
        help="the file to write; report.html in the folder by default",
    )
    report.add_argument("--title", help="the heading of the report")


def _report(options: argparse.Namespace) -> int:
    from hunav_drake.report import LoadResults, WriteReport

    directory: Path = options.directory
    try:
        results = LoadResults(directory)
    except OSError as error:
        raise InputError(f"{error.filename}: {error.strerror}") from error
    except ValueError as error:
        raise InputError(str(error)) from error
    replay = directory / "replay.html"
    # A folder keeps the replay of its last run only.
    shows = len(results) == 1 and replay.exists()
    try:
        path = WriteReport(
            results,
            options.output or directory / "report.html",
            replay=replay if shows else None,
            title=options.title,
        )
    except OSError as error:
        raise InputError(f"{error.filename}: {error.strerror}") from error
    except ValueError as error:
        raise InputError(f"{directory}: {error}") from error
    runs = "1 run" if len(results) == 1 else f"{len(results)} runs"
    print(f"Wrote the report on {runs} to {path}")
    return DONE
