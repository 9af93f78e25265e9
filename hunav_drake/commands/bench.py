"""The command `hunav bench`."""

import argparse
from collections.abc import Callable, Iterator
import contextlib
import dataclasses
import math
from pathlib import Path
import sys
from typing import TYPE_CHECKING, Any

from hunav_drake.commands.errors import DONE, FAILED, check_page, input_errors
from hunav_drake.commands.options import (
    add_executor_options,
    add_import_option,
    progress_bar,
    run_executor,
    whole_number,
)
from hunav_drake.systems.common.input_error import InputError
from hunav_drake.systems.common.suggest import counted

if TYPE_CHECKING:
    from hunav_drake.runs.comparison.relations import Judgement
    from hunav_drake.runs.run_row import RunRow
    from hunav_drake.runs.suite import Suite
    from hunav_drake.runs.suite_result import SuiteResult


def add_bench_options(bench: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav bench`."""
    bench.description = (
        "Runs all trials of a suite in worker processes, and prints its tables."
        " Finished runs are not repeated, so an interrupted suite continues"
        " where it stopped."
    )
    bench.set_defaults(function=_bench)
    bench.add_argument(
        "suite",
        nargs="?",
        help="a shipped suite (paper, ...) or a file (default: list the shipped"
        " suites)",
    )
    bench.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        default=Path("out"),
        help="write the results to a folder in DIR with the name of the suite"
        " (default: out)",
    )
    bench.add_argument(
        "--seeds",
        type=whole_number(1),
        help="the number of seeds, instead of the suite's",
    )
    bench.add_argument(
        "--planner",
        nargs="+",
        default=[],
        metavar="NAME",
        help="the planners, instead of the suite's",
    )
    bench.add_argument(
        "--set",
        dest="overrides",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="change a value of all scenarios: robot.type=pmb2",
    )
    bench.add_argument(
        "--beside",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="run all trials a second time with this change, and print the"
        " tables of both: robot.type=pmb2",
    )
    bench.add_argument(
        "--relative",
        action="store_true",
        help="also tell what each planner costs people: their delays, contacts"
        " charged to the robot, and the worst encounters; each run takes 5 to"
        " 10 times as long",
    )
    bench.add_argument(
        "--worlds",
        metavar="DIR",
        help="the folder of the worlds of barn: world_0.world, ...",
    )
    bench.add_argument(
        "--until",
        metavar="METRIC=WIDTH",
        type=_until,
        help="stop a cell once the 95 %% confidence interval of a metric's mean"
        " is within +- WIDTH",
    )
    bench.add_argument(
        "--show",
        metavar="METRIC",
        default="time_to_reach_goal",
        help="the metric whose mean the progress bar shows",
    )
    add_executor_options(bench)
    bench.add_argument(
        "--fresh",
        action="store_true",
        help="run all trials again; the old log is kept as runs_old.jsonl",
    )
    bench.add_argument(
        "--replays",
        action="store_true",
        help="also write a replay of the first seed of each cell; each takes a"
        " few seconds and a few MB",
    )
    bench.add_argument(
        "--markdown",
        type=Path,
        metavar="FILE",
        help="also write the main metrics as a page of Markdown",
    )
    bench.add_argument(
        "--json", action="store_true", help="print JSON, not tables"
    )
    bench.add_argument(
        "--quiet", action="store_true", help="show no progress bar"
    )
    add_import_option(bench)


def _until(text: str) -> tuple[str, float]:
    metric, _, width = text.rpartition("=")
    try:
        value = float(width)
    except ValueError:
        value = math.nan
    if not metric or not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(
            "must be a metric and a positive number, as in"
            f" min_dist_to_people=0.05, got {text!r}"
        )
    return metric, value


def _bench(options: argparse.Namespace) -> int:
    from hunav_drake.report.suite_files import WriteSuite
    from hunav_drake.runs import ListSuites, RunSuite
    from hunav_drake.runs.comparison.relations import judge
    from hunav_drake.runs.tasks import UnfitWorkerError
    from hunav_drake.scenario import ScenarioError
    from hunav_drake.systems.evaluation.metrics import select_metrics

    if options.suite is None:
        suites = ListSuites()
        width = max(map(len, suites))
        for name, description in suites.items():
            print(f"{name:{width}}  {description}")
        return DONE
    with input_errors(ScenarioError, ValueError, UnfitWorkerError):
        select_metrics([options.show])
        if options.markdown:
            check_page(options.markdown, "--markdown")
        suite = _suite(options)
        out = options.out / suite.name
        path = Path(options.suite)
        with contextlib.ExitStack() as stack:
            executor, workers = stack.enter_context(run_executor(options))
            result = RunSuite(
                suite,
                out=out,
                workers=workers,
                executor=executor,
                folder=path.parent if path.is_file() else None,
                imports=tuple(getattr(options, "imports", ())),
                fresh=options.fresh,
                progress=stack.enter_context(_progress(options)),
            )
        if options.replays:
            _write_replays(result, out, options)
        judgements = judge(result)
        # Before printing, which the reader of a pipe may end early.
        with input_errors(place=out):
            report = WriteSuite(result, out, judgements)
        if options.markdown:
            _write_markdown(result, options)
    _print(result, judgements, options)
    print(f"Tables, CSV and LaTeX: {out}", file=sys.stderr)
    print(f"Report, for a browser: {report}", file=sys.stderr)
    return FAILED if result.failures else DONE


def _suite(options: argparse.Namespace) -> "Suite":
    from hunav_drake.runs import LoadSuite
    from hunav_drake.runs.suite import Until, planner_overrides

    suite = LoadSuite(filename=options.suite)
    changes: dict[str, Any] = {}
    if options.worlds:
        # A path on the command line starts from the current folder.
        worlds: Any = {"folder": str(Path(options.worlds).resolve())}
        changes["scenarios"] = [
            dataclasses.replace(it, **worlds)
            if not isinstance(it, str) and hasattr(it, "folder")
            else it
            for it in suite.scenarios
        ]
        if changes["scenarios"] == suite.scenarios:
            raise InputError(
                f"--worlds is for suites with worlds of barn; {suite.name} has"
                " none"
            )
    if options.seeds:
        changes["seeds"] = options.seeds
        changes["seeds_of"] = {}
    if options.planner:
        # A planner of the suite keeps its parameters.
        known = {planner_overrides(it)[0]: it for it in suite.planners}
        changes["planners"] = [known.get(it, it) for it in options.planner]
    overrides = [*options.overrides]
    if options.relative:
        changes["relative"] = True
        overrides.insert(0, "evaluator.encounters=true")
    if overrides:
        changes["overrides"] = [*suite.overrides, *overrides]
    if options.beside:
        old = dict(suite.settings) or {"": []}
        text = ", ".join(options.beside)
        changes["settings"] = old | {
            f"{name}, {text}".removeprefix(", "): [*own, *options.beside]
            for name, own in old.items()
        }
    if options.until:
        metric, width = options.until
        until = Until(metric=metric, half_width=width)
        if suite.until:  # It keeps its least number of seeds.
            until = dataclasses.replace(until, least=suite.until.least)
        changes["until"] = until
        given = dataclasses.replace(suite, **changes)
        most = max(len(given.seed_list(it)) for it in [*given.seeds_of, ""])
        if most <= until.least:
            raise InputError(
                f"--until {metric}={width:g}: has an effect from"
                f" {until.least + 1} seeds on, and there are {most}; give more,"
                " as with --seeds 100, or leave it out"
            )
    return dataclasses.replace(suite, **changes)


def _write_replays(
    result: "SuiteResult", out: Path, options: argparse.Namespace
) -> None:
    from hunav_drake.views.suite_replays import WriteReplays

    with (
        progress_bar("replays", options.quiet) as (_, show),
        input_errors(RuntimeError),
    ):
        WriteReplays(
            result,
            out,
            workers=options.workers,
            imports=tuple(getattr(options, "imports", ())),
            progress=show,
        )


def _write_markdown(result: "SuiteResult", options: argparse.Namespace) -> None:
    import shlex

    from hunav_drake.runs.comparison.markdown import to_markdown
    from hunav_drake.systems.common.files import atomic_write

    words = [*("hunav", "bench", options.suite)]
    if options.worlds:
        words += ["--worlds", "FOLDER"]
    if options.seeds:
        words += ["--seeds", str(options.seeds)]
    if options.planner:
        words += ["--planner", *options.planner]
    if options.relative:
        words += ["--relative"]
    for change in options.overrides:
        words += ["--set", change]
    for change in options.beside:
        words += ["--beside", change]
    if options.until:
        metric, width = options.until
        words += ["--until", f"{metric}={width}"]
    for name in getattr(options, "imports", ()):
        words += ["--import", name]
    words += ["--markdown", str(options.markdown)]
    page = to_markdown(result, shlex.join(words))
    with (
        input_errors(place=options.markdown),
        atomic_write(options.markdown) as file,
    ):
        file.write(page.encode())


def _print(
    result: "SuiteResult",
    judgements: "list[Judgement]",
    options: argparse.Namespace,
) -> None:
    from hunav_drake.runs.comparison.relations import tally
    from hunav_drake.runs.comparison.tables import (
        NOTE,
        behavior_tables,
        scenario_tables,
        to_text,
    )
    from hunav_drake.runs.suite_tables import suite_json

    if options.json:
        print(suite_json(result, judgements))
        return
    tables = (*scenario_tables(result), *behavior_tables(result))
    for table in tables:
        print(to_text(table), end="\n\n")
    if tables:
        print(NOTE, end="\n\n")
    for it in judgements:
        print(f"{it.verdict:10}  {it.number:2}  {it.scenarios}: {it.text}")
        if it.verdict != "holds":
            print(f"                {it.numbers}")
    if (strong := tally(judgements)).tested:
        held, surely = strong.shares
        print(
            f"\nOf the strong relations {100 * held:.0f} % hold for the means,"
            f" {100 * surely:.0f} % also in nine of ten resamples."
        )
    _print_outcomes(result)
    for row in result.failures[:20]:
        print(f"{row.cell}, seed {row.seed}: {row.end_message}")
    if len(result.failures) > 20:
        print(f"... and {len(result.failures) - 20} more failures")


def _print_outcomes(result: "SuiteResult") -> None:
    """Prints why runs ended, and where all seeds give the same trial."""
    from hunav_drake.runs.outcomes import outcome_text, why_not_goal
    from hunav_drake.runs.suite_result import KEYS

    outcomes = result.outcomes()
    print(f"{counted(len(result.rows), 'run')} ended: {outcome_text(outcomes)}")
    for place, own in outcomes.groupby(list(KEYS), sort=False):
        if why := why_not_goal(own):
            cell = "/".join(filter(None, place))
            print(f"{cell}: {outcome_text(own)}")
            for line in why:
                print(f"    {line}")
    for line in result.same_seeds():
        print(line)


@contextlib.contextmanager
def _progress(
    options: argparse.Namespace,
) -> Iterator["Callable[[RunRow, int, int], None]"]:
    """Yields a function that shows the finished runs in a progress bar."""
    from hunav_drake.runs.run_row import FAILED

    amount, count, failures = 0.0, 0, 0
    with progress_bar("runs", options.quiet) as (bar, show_count):

        def show(row: "RunRow", done: int, total: int) -> None:
            nonlocal amount, count, failures
            failures += row.end_reason in FAILED
            value = row.metrics.get(options.show, math.nan)
            if math.isfinite(value):
                amount += value
                count += 1
            texts = {"failures": str(failures)}
            if count:
                texts[options.show] = f"{amount / count:.3g}"
            bar.set_postfix(texts, refresh=False)
            show_count(done, total)

        yield show
