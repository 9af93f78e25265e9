"""The command `hunav report`."""

import argparse
from pathlib import Path
import sys

from hunav_drake.commands.errors import DONE, check_output, input_errors
from hunav_drake.commands.options import add_import_option
from hunav_drake.systems.common.input_error import InputError

# The maximum number of omitted runs that are listed in the terminal.
_MOST_LINES = 5


def add_report_options(report: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav report`."""
    report.description = (
        "Writes a page on all runs of a folder, with links to the report and"
        " the replay of each run, and tables of their metrics, runs.csv and"
        " runs_by_behavior.csv."
    )
    report.set_defaults(function=_report)
    report.add_argument(
        "directory",
        type=Path,
        help="a folder that `hunav run --out` or `hunav bench` has written",
    )
    report.add_argument(
        "-o",
        "--output",
        type=Path,
        help="the page to write (default: report.html in the folder)",
    )
    report.add_argument("--title", help="the heading of the report")
    add_import_option(report)


def _report(options: argparse.Namespace) -> int:
    from hunav_drake.runs.result_files import LoadResults
    from hunav_drake.runs.run_folders import RECORDINGS

    directory: Path = options.directory
    if options.output is not None:
        check_output(options.output)
    page: Path = options.output or directory / "report.html"
    if any((directory / it).exists() for it in ("suite.json", RECORDINGS)):
        return _report_suite(directory, page, options.title)
    left_out: dict[str, str] = {}
    with input_errors():
        results = LoadResults(directory, damaged=left_out)
    for tag, reason in list(left_out.items())[:_MOST_LINES]:
        print(f"hunav: left out the run {tag}: {reason}", file=sys.stderr)
    if len(left_out) > _MOST_LINES:
        more = len(left_out) - _MOST_LINES
        print(f"hunav: ... and {more} more: see the report", file=sys.stderr)
    if not results:
        raise InputError(f"{directory}: there is no run to report on")
    # Imported only now, because they take long to load.
    from hunav_drake.report.writing import WriteReport
    from hunav_drake.runs.run_table import WriteTables

    with input_errors():
        path = WriteReport(
            results,
            page,
            title=options.title,
            pages=directory,
            left_out=left_out,
        )
        table = WriteTables(results, path.parent)
    runs = "1 run" if len(results) == 1 else f"{len(results)} runs"
    print(f"Wrote the report on {runs} to {path}")
    print(f"Wrote their metrics to {table}")
    return DONE


def _report_suite(directory: Path, page: Path, title: str | None) -> int:
    """Writes the page of a suite again, from its tables."""
    from hunav_drake.report.runs_page import WriteRunsPage
    from hunav_drake.report.suite_files import read_suite

    with input_errors():
        many = read_suite(directory)
        WriteRunsPage(many, page, title or f"Benchmark {directory.name}")
    print(f"Wrote the report on {len(many.runs)} runs to {page}")
    return DONE
