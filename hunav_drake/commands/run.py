"""The command `hunav run`."""

import argparse
from collections.abc import Callable, Iterator
import contextlib
import dataclasses
import logging
from pathlib import Path
import sys
import time
from typing import TYPE_CHECKING, Any, Literal

from hunav_drake.commands.errors import (
    DONE,
    FAILED,
    check_out,
    input_errors,
    output_errors,
)
from hunav_drake.commands.options import (
    add_format_option,
    add_import_option,
    add_trial_options,
    load_matplotlib,
    load_scenario,
    overlay_names,
    tell_doubts,
    whole_number,
)
from hunav_drake.systems.common.input_error import InputError

if TYPE_CHECKING:
    from pydrake.systems.framework import Context, Diagram

    from hunav_drake.scenario import Scenario
    from hunav_drake.trial.result import TrialResult


def add_run_options(run: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav run`."""
    run.set_defaults(function=_run)
    add_trial_options(run)
    run.add_argument(
        "--planner",
        metavar="NAME",
        help="the robot's planner, with its own parameters, instead of the"
        " scenario's: its name, or your class as module:Class",
    )
    run.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        help="write metrics, recording, report and replay of this run to a new"
        " folder in DIR/runs; see `hunav report`",
    )
    run.add_argument(
        "--label",
        metavar="NAME",
        help="a name for the settings of this run; statistics separate runs of"
        " a planner by it (default: the changes of --set)",
    )
    run.add_argument(
        "--relative",
        action="store_true",
        help="also compare with the same trial without the people, and without"
        " the robot: metrics of the family relative, and what the robot costs"
        " each person",
    )
    add_format_option(run)
    run.add_argument("--no-replay", action="store_true", help="write no replay")
    run.add_argument(
        "--meshcat",
        action="store_true",
        help="show the trial in a browser, in real time; wait for the browser"
        " first, and for Enter at the end",
    )
    run.add_argument(
        "--foxglove",
        nargs="?",
        type=whole_number(0, "65536"),
        const=8765,
        metavar="PORT",
        help="show the trial in Foxglove, in real time: it connects to PORT of"
        " this machine (default: 8765; 0: a free one)",
    )
    run.add_argument(
        "--no-wait",
        action="store_true",
        help="with --meshcat, --foxglove: do not wait, as when the input is not"
        " a terminal",
    )
    run.add_argument(
        "--overlays",
        type=overlay_names,
        metavar="NAMES",
        help="the overlays to show, separated by commas, or all, or none"
        " (default: those of the scenario)",
    )
    amount = run.add_mutually_exclusive_group()
    amount.add_argument(
        "--all",
        action="store_true",
        help="print all metrics, not only the headline ones",
    )
    amount.add_argument(
        "--json", action="store_true", help="print the results as JSON"
    )
    amount.add_argument(
        "--quiet", action="store_true", help="show no progress bar and no table"
    )
    add_import_option(run)


def _run(options: argparse.Namespace) -> int:
    more = []
    if options.seed is not None:
        more.append(f"simulation.seed={options.seed}")
    if options.overlays is not None:
        more.append(f"scene.overlays=[{', '.join(options.overlays)}]")
    scenario = load_scenario(
        options.scenario, options, more, planner=options.planner
    )
    _warn_of_ways(scenario, options.scenario)
    if not options.quiet or options.seed is not None:
        tell_doubts(scenario)
    if options.out is not None:
        check_out(options.out)
    if options.relative:
        from hunav_drake.runs.cells import why_not_alone

        if why := why_not_alone(scenario):
            raise InputError(f"--relative: {why}")
    if options.meshcat and options.foxglove is not None:
        raise InputError("--foxglove does not go with --meshcat: choose one")
    from hunav_drake.runs.compiling_ahead import compiling_ahead
    from hunav_drake.scenario import ScenarioError
    from hunav_drake.scenario.fleet import robots_of
    from hunav_drake.trial.compiling import told_compile_time
    from hunav_drake.trial.diagram import MakeTrialDiagram
    from hunav_drake.trial.simulation import RunTrial

    replay = options.out is not None and not options.no_replay
    meshcat = None
    if options.meshcat or replay:
        from hunav_drake.scenario import draw_people
        from hunav_drake.views.replay import SetView, StartMeshcatLocal

        # Meshcat logs its address, which matters only with --meshcat.
        logging.getLogger("drake").setLevel(logging.WARNING)
        meshcat = StartMeshcatLocal()
        people = draw_people(scenario)
        SetView(meshcat, scenario.world, people, robots_of(scenario))
    with contextlib.ExitStack() as stack, input_errors(ScenarioError):
        compiled = stack.enter_context(
            told_compile_time(lambda: compiling_ahead(scenario))
        )
        diagram = MakeTrialDiagram(scenario, meshcat, drawn=False)
        before = compiled.seconds
        started = time.perf_counter()
        progress = None
        if not (options.quiet or options.json):
            bar = _progress_bar(scenario.simulation.duration)
            progress = stack.enter_context(bar)
        on_error: Literal["end", "raise"] = "end"
        if getattr(options, "debug", False):
            on_error = "raise"
        if options.meshcat:
            result = _show(
                *(scenario, options, diagram, meshcat, progress, on_error)
            )
        else:
            foxglove = _foxglove(options, diagram, stack)
            result = RunTrial(
                scenario,
                diagram=diagram,
                meshcat=meshcat,
                realtime_rate=1.0 if foxglove else 0.0,
                progress=progress,
                watch=foxglove,
                on_planner_error=on_error,
            )
        elapsed = time.perf_counter() - started
        elapsed -= compiled.seconds - before

    costs: list[str] = []
    if options.relative and result.end_reason != "planner_failed":
        result, costs = _relative(result, scenario)
    result = with_setting(result, options)
    # Before printing, which the reader of a pipe may end early.
    written = []
    if options.out is not None:
        written = keep_run(
            result, scenario, options, meshcat if replay else None
        )
    failed = result.end_reason == "planner_failed"
    if failed:
        print(f"hunav: {result.end_message}", file=sys.stderr)
    _print(result, options, elapsed)
    for line in [*costs, *written]:
        print(line, file=sys.stderr if options.json else sys.stdout)
    if options.meshcat and _somebody_waits(options):
        # Or Ctrl-C, or Ctrl-D: all files are written.
        with contextlib.suppress(KeyboardInterrupt, EOFError):
            input("Press Enter to close the view. ")
    aims = any(it.goal is not None for it in robots_of(scenario).values())
    completed = result.end_reason == "goal" or not aims
    return DONE if completed and not failed else FAILED


def _foxglove(
    options: argparse.Namespace, diagram: Any, stack: contextlib.ExitStack
) -> "Callable[[Context], bool] | None":
    """Returns what publishes the steps of a trial to Foxglove, if wished."""
    if options.foxglove is None:
        return None
    from hunav_drake.hunavsim.ros2.live import FoxgloveTopics

    with input_errors(ImportError, ValueError):
        topics = FoxgloveTopics(diagram, options.foxglove)
    stack.callback(topics.Close)
    print(f"Open the connection {topics.address} in Foxglove", flush=True)
    if _somebody_waits(options):
        input("Press Enter when it is open. ")
    return topics.Publish


def _relative(
    result: "TrialResult", scenario: "Scenario"
) -> tuple["TrialResult", list[str]]:
    """Returns a result with the relative metrics, and the costs in words."""
    from hunav_drake.trial.branches.relative import CompareAlone, with_relative
    from hunav_drake.trial.diagram import MakeTrialDiagram

    with input_errors(ValueError):
        # (Without a scene in a browser.)
        diagram = MakeTrialDiagram(scenario, drawn=False)
        found = CompareAlone(scenario, diagram, diagram.CreateDefaultContext())
    return with_relative(result, found), found.texts()


def _warn_of_ways(scenario: "Scenario", source: str) -> None:
    """Warns, before the trial, of goals that cannot be reached."""
    from hunav_drake.scenario.building import Places
    from hunav_drake.scenario.reachability import check_ways

    for found in check_ways(scenario):
        fault = dataclasses.replace(
            Places().fault(found, scenario), source=source
        )
        print(f"hunav: warning: {fault}", file=sys.stderr)


def _somebody_waits(options: argparse.Namespace) -> bool:
    return sys.stdin.isatty() and not options.no_wait


def _print(
    result: "TrialResult", options: argparse.Namespace, elapsed: float
) -> None:
    """Prints the result of a trial, but not that a planner failed."""
    from hunav_drake.runs.run_row import make_row, result_to_json
    from hunav_drake.trial.metric_facts import headline_of
    from hunav_drake.trial.result import FormatMetricsTable, how_it_ended

    if options.json:
        print(result_to_json(make_row(result)))
        return
    if result.end_reason == "planner_failed":
        return
    if options.quiet:
        print(how_it_ended(result))
        return
    print(FormatMetricsTable(result, headline_only=not options.all))
    left = len(result.tables.values) - len(headline_of(result.tables))
    if left and not options.all:
        print(f"\n{left} more metrics with --all")
    rate = result.end_time / elapsed
    print(f"\nSimulated in {elapsed:.2f} s, {rate:.0f} times real time")


def _show(
    scenario: "Scenario",
    options: argparse.Namespace,
    diagram: "Diagram",
    meshcat: Any,
    progress: Callable[[float], None] | None,
    on_error: Literal["end", "raise"],
) -> "TrialResult":
    """Runs a trial in a browser, and again whenever the user restarts it."""
    from hunav_drake.trial.simulation import RunTrial
    from hunav_drake.views.live import (
        LiveControls,
        RestartRequest,
        WaitForBrowser,
    )

    controls = LiveControls(meshcat, scenario, diagram)
    print(f"Watch the trial at {meshcat.web_url()}", flush=True)
    if _somebody_waits(options):
        WaitForBrowser(meshcat)
    while True:
        controls.Restart()
        try:
            return RunTrial(
                scenario,
                diagram=diagram,
                meshcat=meshcat,
                progress=progress,
                watch=controls.Watch,
                on_planner_error=on_error,
            )
        except RestartRequest:
            continue


def with_setting(
    result: "TrialResult", options: argparse.Namespace
) -> "TrialResult":
    """Returns a result with the name of its settings."""
    from hunav_drake.runs.settings import setting_text

    label = getattr(options, "label", None)
    setting = setting_text(options.overrides) if label is None else label
    return dataclasses.replace(result, setting=setting)


def keep_run(
    result: "TrialResult",
    scenario: "Scenario",
    options: argparse.Namespace,
    meshcat: Any = None,
) -> list[str]:
    """Writes the files of a run, with Meshcat's replay; returns messages."""
    if getattr(options, "alone", False):
        load_matplotlib()
    from hunav_drake.report.writing import WriteReport
    from hunav_drake.runs.result_files import WriteResult
    from hunav_drake.scenario import SaveScenario

    def add_pages(folder: Path) -> None:
        SaveScenario(scenario, folder / "scenario.yaml")
        replay = None
        if meshcat is not None:
            from hunav_drake.report.plots.situations import marks_of
            from hunav_drake.views.events import events_of
            from hunav_drake.views.replay import SaveReplay

            replay = folder / "replay.html"
            run = result.recording
            marks = [marks_of(run, it.robot_name) for it in run.robots]
            SaveReplay(
                meshcat,
                replay,
                marks=marks if run.num_humans else [],
                events=events_of(run),
            )
        WriteReport(result, folder / "report.html", replay=replay)

    with output_errors(options.out):
        folder = WriteResult(
            result, options.out, format=options.format, add=add_pages
        )
    lines = [
        f"Wrote the run to {folder}",
        f"Report, for a browser: {folder / 'report.html'}",
    ]
    if meshcat is not None:
        lines.append(f"Replay, for a browser: {folder / 'replay.html'}")
    return lines


@contextlib.contextmanager
def _progress_bar(duration: float) -> Iterator[Callable[[float], None]]:
    """Shows the simulated time of a trial, if the output is a terminal."""
    from tqdm import tqdm

    form = "{l_bar}{bar}| {n:.1f}/{total:.1f} s"
    with tqdm(total=duration, bar_format=form, disable=None, leave=False) as it:
        yield lambda seconds: it.update(seconds - it.n)
