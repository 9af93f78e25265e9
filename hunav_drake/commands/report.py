"""The command `hunav report`."""

import argparse
from pathlib import Path
import sys
from typing import TYPE_CHECKING

from hunav_drake.commands.errors import DONE, check_output, input_errors
from hunav_drake.commands.options import add_import_option
from hunav_drake.systems.common.input_error import InputError
from hunav_drake.systems.common.suggest import counted

if TYPE_CHECKING:
    import pandas as pd

# What the columns of a table may be: the keys of `COLUMNS` of
# `hunav_drake.runs.comparison.tables`, which takes long to load.
_COLUMNS = ("estimate", "n", "mean", "interval", "sd", "median", "arrived")

# What folders are, of which there is no report, by a file that they have. The
# first that fits is told.
_BAG = "is a bag; `hunav evaluate {folder} --out DIR` makes a run of it"
_OTHERS = {
    "001.npz": "has the scenes that `hunav falsify` found, in rank.csv;"
    " `hunav run {folder}/001.yaml --out DIR` runs one and writes its report",
    "tried.csv": "has the runs of `hunav falsify`, in tried.csv: none failed",
    "search.json": "has the log of `hunav falsify` or `hunav risk`; the same"
    " command with --out {folder} goes on with it and prints what it found",
    "who.csv": "has who.csv, which `hunav who` wrote; read it with"
    ' pandas.read_csv("{folder}/who.csv", index_col=0)',
    "validation.html": "has what `hunav validate` wrote; open"
    " {folder}/validation.html",
    "metadata.yaml": _BAG,
    "*.mcap": _BAG,
    "result.json": "is a single run; give the folder that has it in runs/:"
    " `hunav report {above}`",
    "*/result.json": "has the runs of a folder; give that one: `hunav report"
    " {parent}`",
    "*.npz": "has recordings; `hunav evaluate FILE --out DIR` makes a run of"
    " one",
    "*.yaml": "has scenarios; `hunav run FILE --out DIR` runs one and writes"
    " its report",
}

# The maximum number of omitted runs that are listed in the terminal.
_MOST_LINES = 5


def add_report_options(report: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav report`."""
    report.description = (
        "Writes a page on all runs of a folder, with links to the report and"
        " the replay of each run, and tables of their metrics, runs.csv and"
        " runs_by_behavior.csv. Figures and tables for papers are written on"
        " demand."
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
    report.add_argument(
        "--figures",
        type=Path,
        metavar="DIR",
        help="also write figures that compare planners, each as PDF, SVG and"
        " PNG, and figures.tex with their captions, to this folder",
    )
    report.add_argument(
        "--latex",
        type=Path,
        metavar="FILE",
        help="also write a table for each scenario for LaTeX, as tables.tex",
    )
    report.add_argument(
        "--metrics",
        nargs="+",
        metavar="NAME",
        help="the metrics of --figures and --latex: columns of runs.csv"
        " (default: those of the headline)",
    )
    report.add_argument(
        "--columns",
        nargs="+",
        metavar="NAME",
        choices=_COLUMNS,
        help=f"the columns of --latex for each planner: {', '.join(_COLUMNS)}"
        " (default: estimate, a mean with half of its interval and n)",
    )
    add_import_option(report)


def _report(options: argparse.Namespace) -> int:
    from hunav_drake.runs.run_folders import RECORDINGS

    directory: Path = options.directory
    _check_pairs(options)
    for path in (options.output, options.latex):
        if path is not None:
            check_output(path)
    page: Path = options.output or directory / "report.html"
    if any((directory / it).exists() for it in ("suite.json", RECORDINGS)):
        lines = _report_suite(directory, page, options)
    else:
        _check_folder(directory)
        lines = _report_runs(directory, page, options)
    for line in lines:
        print(line)
    return DONE


def _report_runs(
    directory: Path, page: Path, options: argparse.Namespace
) -> list[str]:
    """Writes the page of single runs, and their tables; returns messages."""
    from hunav_drake.runs.result_files import LoadResults

    left_out: dict[str, str] = {}
    with input_errors(ValueError):
        results = LoadResults(directory, damaged=left_out)
    for tag, reason in list(left_out.items())[:_MOST_LINES]:
        print(f"hunav: left out the run {tag}: {reason}", file=sys.stderr)
    if len(left_out) > _MOST_LINES:
        more = len(left_out) - _MOST_LINES
        print(f"hunav: ... and {more} more: see the report", file=sys.stderr)
    if not results and not left_out:
        # The runs of a suite whose recordings were not copied.
        return _report_suite(directory, page, options)
    if not results:
        raise InputError(f"{directory}: there is no run to report on")
    # Imported only now, because they take long to load.
    from hunav_drake.report.writing import WriteReport, without_duplicates
    from hunav_drake.runs.comparison.captions import made_by_text
    from hunav_drake.runs.run_table import WriteTables, tabulate_runs

    versions = (str(it.provenance.get("hunav_drake", "")) for it in results)
    made_by = made_by_text(
        "", "", ", ".join(filter(None, dict.fromkeys(versions)))
    )
    distinct, repeats = without_duplicates(results)
    with input_errors(ValueError):
        more_lines = _write_more(tabulate_runs(distinct), made_by, options)
        path = WriteReport(
            results,
            page,
            title=options.title,
            pages=directory,
            left_out=left_out,
        )
        table = WriteTables(results, path.parent)
    runs = counted(len(distinct), "run")
    if repeats:
        runs += f" ({len(repeats)} more are duplicates)"
    return [
        f"Wrote the report on {runs} to {path}",
        f"Wrote their metrics to {table}",
        *more_lines,
    ]


def _report_suite(
    directory: Path, page: Path, options: argparse.Namespace
) -> list[str]:
    """Writes the page of a suite again, from its tables; returns messages."""
    from hunav_drake.report.runs_page import WriteRunsPage
    from hunav_drake.report.suite_files import read_suite
    from hunav_drake.runs.run_folders import RUNS, find_runs

    with input_errors(ValueError):
        many = read_suite(directory)
        apart = find_runs(directory).keys() - {*many.runs.get("tag", ())}
        if apart:
            some = sorted(apart)[:_MOST_LINES]
            more = len(apart) - len(some)
            names = ", ".join(some) + f", and {more} more" * (more > 0)
            print(
                f"hunav: left out runs in {directory / RUNS} that are not of"
                f" the suite: {names}; move them to another folder for a"
                " report on them",
                file=sys.stderr,
            )
        lines = _write_more(many.runs, many.made_by, options)
        title = options.title or f"Benchmark {directory.resolve().name}"
        WriteRunsPage(many, page, title)
    return [
        f"Wrote the report on {counted(len(many.runs), 'run')} to {page}",
        *lines,
    ]


def _write_more(
    runs: "pd.DataFrame", made_by: str, options: argparse.Namespace
) -> list[str]:
    """Writes figures and tables of chosen metrics; returns messages."""
    if options.figures is None and options.latex is None:
        return []
    from hunav_drake.report.comparison_figures import WriteFigures
    from hunav_drake.runs.comparison.latex import PACKAGES, to_latex
    from hunav_drake.runs.comparison.tables import chosen_tables
    from hunav_drake.systems.common.files import atomic_write
    from hunav_drake.systems.common.suggest import suggestion
    from hunav_drake.trial.metric_facts import headline_of

    known = [str(it) for it in runs.attrs["units"] if it in runs]
    for name in options.metrics or ():
        if name not in known:
            raise InputError(
                f"--metrics: the runs have no metric {name!r};"
                f" {suggestion(name, known)}"
            )
    metrics = options.metrics or headline_of(runs)
    lines = []
    if options.latex is not None:
        columns = options.columns or ["estimate"]
        tables = chosen_tables(runs, metrics, columns, made_by)
        text = f"% In the preamble: \\usepackage{{{','.join(PACKAGES)}}}\n\n"
        with atomic_write(options.latex) as file:
            file.write((text + "\n".join(map(to_latex, tables))).encode())
        lines.append(f"Wrote the tables for LaTeX to {options.latex}")
    if options.figures is not None:
        paths = WriteFigures(
            runs, options.figures, metrics=metrics, made_by=made_by
        )
        lines.append(
            f"Wrote {counted(len(paths) - 1, 'file')} of figures to {paths[-1]}"
        )
    return lines


def _check_pairs(options: argparse.Namespace) -> None:
    """Refuses options that would do nothing without another one."""
    if options.metrics and options.latex is None and options.figures is None:
        raise InputError(
            "--metrics chooses those of figures and tables: add --figures DIR"
            " or --latex FILE"
        )
    if options.columns and options.latex is None:
        raise InputError("--columns chooses those of a table: add --latex FILE")


def _check_folder(folder: Path) -> None:
    """Refuses a folder that has no runs, and tells what it has instead."""
    from hunav_drake.runs.run_folders import find_runs

    if folder.is_file():
        raise InputError(
            f"{folder}: is a file, and reports are on folders; `hunav evaluate"
            f" {folder} --out DIR` makes one of a recording"
        )
    if find_runs(folder):
        return
    parent = folder.resolve().parent
    places = {"folder": folder, "parent": parent, "above": parent.parent}
    for pattern, text in _OTHERS.items():
        if any(folder.glob(pattern)):
            raise InputError(f"{folder}: {text.format(**places)}")
