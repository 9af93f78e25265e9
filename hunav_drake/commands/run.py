"""The command `hunav run`."""

import argparse
from collections.abc import Callable, Iterator
import contextlib
import dataclasses
import logging
from pathlib import Path
import sys
import time
from typing import TYPE_CHECKING, Any

from hunav_drake.commands.errors import (
    DONE,
    FAILED,
    InputError,
    check_out,
    input_errors,
)
from hunav_drake.commands.options import (
    add_format_option,
    add_import_option,
    add_scenario_options,
    load_scenario,
)

if TYPE_CHECKING:
    from hunav_drake.results.trial_result import TrialResult


def add_run_command(commands: Any) -> None:
    """Adds the command `hunav run`."""
    run = commands.add_parser("run", help="run a trial and print its metrics")
    run.set_defaults(function=_run)
    run.add_argument(
        "scenario", help="a shipped scenario (see `hunav list`) or a file"
    )
    add_scenario_options(run)
    run.add_argument(
        "--seed", type=_seed, help="the seed, instead of the scenario's"
    )
    run.add_argument(
        "--planner",
        metavar="NAME",
        help="the planner of the robot, instead of the scenario's: its name, or"
        " a class of your own as module:Class",
    )
    run.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        help="write metrics, recording, report and replay to a folder of this"
        " run in DIR/runs; see `hunav report`",
    )
    run.add_argument(
        "--label",
        metavar="NAME",
        help="a name for the settings of this run, which keeps it apart from"
        " other runs of the planner in statistics; by default the values of"
        " --set",
    )
    add_format_option(run)
    run.add_argument("--no-replay", action="store_true", help="write no replay")
    run.add_argument(
        "--meshcat",
        action="store_true",
        help="show the trial in a browser, in real time",
    )
    run.add_argument(
        "--quiet", action="store_true", help="show no progress bar and no table"
    )
    run.add_argument(
        "--debug",
        action="store_true",
        help="show where in the code a broken planner fails",
    )
    add_import_option(run)


def _seed(text: str) -> int:
    if not text.isdecimal() or int(text) >= 2**63:
        raise argparse.ArgumentTypeError(
            f"must be a whole number in [0, 2^63), got {text!r}"
        )
    return int(text)


def _run(options: argparse.Namespace) -> int:
    more = [f"planner.name={options.planner}"] if options.planner else []
    scenario = load_scenario(options.scenario, options, more)
    if options.out is not None:
        check_out(options.out)
    from hunav_drake.results.trial_result import FormatMetricsTable
    from hunav_drake.scenario import ScenarioError
    from hunav_drake.simulation import RunTrial

    replay = options.out is not None and not options.no_replay
    meshcat = None
    if options.meshcat or replay:
        from hunav_drake.replay import SetView, StartMeshcatLocal
        from hunav_drake.scenario import draw_people

        # Meshcat logs its address, which matters only with --meshcat.
        logging.getLogger("drake").setLevel(logging.WARNING)
        meshcat = StartMeshcatLocal()
        people = draw_people(scenario)
        SetView(meshcat, scenario.world, people, scenario.robot)
    if options.meshcat and meshcat is not None:
        print(f"Watch the trial at {meshcat.web_url()}", flush=True)

    started = time.perf_counter()
    with contextlib.ExitStack() as stack, input_errors(ScenarioError):
        progress = None
        if not options.quiet:
            bar = _progress_bar(scenario.simulation.duration)
            progress = stack.enter_context(bar)
        result = RunTrial(
            scenario,
            options.seed,
            meshcat=meshcat,
            realtime_rate=1.0 if options.meshcat else 0.0,
            progress=progress,
            on_planner_error="raise" if options.debug else "end",
        )
    elapsed = time.perf_counter() - started

    failed = result.end_reason == "planner_failed"
    if failed:
        print(f"hunav: {result.end_message}", file=sys.stderr)
    else:
        text = FormatMetricsTable(result)
        print(text.splitlines()[1] if options.quiet else text)
    if not (options.quiet or failed):
        rate = result.end_time / elapsed
        print(f"\nTook {elapsed:.2f} s, {rate:.0f} times real time")
    if options.out is not None:
        _keep(result, options, meshcat if replay else None)
    if options.meshcat and sys.stdin.isatty():
        input("Press Enter to close the view. ")
    completed = result.end_reason == "goal" or scenario.robot.goal is None
    return DONE if completed and not failed else FAILED


def _keep(
    result: "TrialResult", options: argparse.Namespace, meshcat: Any
) -> None:
    """Writes the files of a run; Meshcat holds the recorded replay."""
    from hunav_drake.report.writing import WriteReport
    from hunav_drake.results.files import WriteResult
    from hunav_drake.results.settings import setting_text

    label = options.label
    setting = setting_text(options.overrides) if label is None else label
    result = dataclasses.replace(result, setting=setting)

    def add_pages(folder: Path) -> None:
        replay = None
        if meshcat is not None:
            from hunav_drake.replay import SaveReplay

            replay = folder / "replay.html"
            SaveReplay(meshcat, replay)
        WriteReport(result, folder / "report.html", replay=replay)

    try:
        folder = WriteResult(
            result, options.out, format=options.format, add=add_pages
        )
    except (OSError, ValueError) as error:
        raise InputError(f"--out {options.out}: {error}") from error
    print(f"Wrote the run to {folder}")
    print(f"Report, for a browser: {folder / 'report.html'}")
    if meshcat is not None:
        print(f"Replay, for a browser: {folder / 'replay.html'}")


@contextlib.contextmanager
def _progress_bar(duration: float) -> Iterator[Callable[[float], None]]:
    """Shows the simulated seconds of a trial, if the output is a terminal."""
    from tqdm import tqdm

    form = "{l_bar}{bar}| {n:.1f}/{total:.1f} s"
    with tqdm(total=duration, bar_format=form, disable=None, leave=False) as it:
        yield lambda seconds: it.update(seconds - it.n)
