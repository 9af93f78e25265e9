"""The command `hunav`.

Everything heavy is imported where it is used, so that the command answers at
once.
"""

import argparse
from collections.abc import Sequence
import contextlib
import io
import logging
import os
from pathlib import Path
import sys
import time
from typing import TYPE_CHECKING, Any

from hunav_drake.cli_metrics import add_format_option, add_metric_commands
from hunav_drake.cli_report import add_report_command
from hunav_drake.command_errors import (
    BAD_INPUT,
    DONE,
    FAILED,
    INTERRUPTED,
    check_out,
)
from hunav_drake.command_errors import InputError as _InputError
from hunav_drake.user_code import import_user_code

if TYPE_CHECKING:
    from hunav_drake.results import TrialResult
    from hunav_drake.scenario import Scenario


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command, and returns its exit code.

    0 when done, 1 when a trial did not end at its goal, 2 for bad input.
    """
    # A name in another script does not end a run whose output is ASCII.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    options = _make_parser().parse_args(arguments)
    try:
        import_user_code(getattr(options, "imports", ()))
        code: int = options.function(options)
        sys.stdout.flush()
    except KeyboardInterrupt:
        print("hunav: interrupted", file=sys.stderr)
        return INTERRUPTED
    except _InputError as error:
        print(f"hunav: {error}", file=sys.stderr)
        return BAD_INPUT
    except BrokenPipeError:
        # Whoever read the output, as in `hunav list | head`, has had enough.
        sys.stderr.close()
        return DONE
    except OSError as error:
        # What is still to be written would fail again when Python ends.
        if isinstance(sys.stdout, io.TextIOWrapper):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        print(f"hunav: {error}", file=sys.stderr)
        return BAD_INPUT
    return code


def _make_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="hunav",
        description="Simulates people around robots, and measures how socially"
        " the robots navigate.",
    )
    commands = parser.add_subparsers(title="commands", required=True)

    run = commands.add_parser("run", help="run a trial and print its metrics")
    run.set_defaults(function=_run)
    run.add_argument(
        "scenario", help="a shipped scenario (see `hunav list`), or a file"
    )
    _add_scenario_options(run)
    run.add_argument("--seed", type=_seed, help="instead of the scenario's")
    run.add_argument("--planner", metavar="NAME", help="what drives the robot")
    run.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        help="write tables, the recording, a report and a replay there; see"
        " `hunav report`",
    )
    add_format_option(run)
    run.add_argument(
        "--no-replay", action="store_true", help="leave out the replay"
    )
    run.add_argument(
        "--meshcat",
        action="store_true",
        help="show the trial in a browser, in real time",
    )
    run.add_argument(
        "--quiet", action="store_true", help="no progress bar, no table"
    )

    add_metric_commands(commands)
    add_report_command(commands)

    listing = commands.add_parser("list", help="list the shipped scenarios")
    listing.set_defaults(function=_list)

    check = commands.add_parser("check", help="check scenario files")
    check.set_defaults(function=_check)
    check.add_argument("scenario", nargs="+")
    _add_scenario_options(check)

    importing = commands.add_parser(
        "import", help="make a scenario of HuNavSim's agents.yaml"
    )
    importing.set_defaults(function=_import)
    importing.add_argument("agents", type=Path)
    importing.add_argument(
        "--metrics", type=Path, help="HuNavSim's metrics.yaml"
    )
    importing.add_argument(
        "-o", "--output", type=Path, help="the file to write, else it is shown"
    )
    importing.add_argument(
        "--force", action="store_true", help="write over an existing file"
    )

    _add_tree_commands(
        commands.add_parser("tree", help="look at behavior trees")
    )

    doctor = commands.add_parser(
        "doctor", help="show the versions in use, and do a short run"
    )
    doctor.set_defaults(function=_doctor)
    for name in ("run", "check", "evaluate", "metrics", "report"):
        _add_import_option(commands.choices[name])
    return parser


def _add_tree_commands(parser: argparse.ArgumentParser) -> None:
    commands = parser.add_subparsers(title="commands", required=True)
    file_help = "a tree file, or the name of a behavior"

    show = commands.add_parser("show", help="show a tree and its memory")
    show.set_defaults(function=_tree_show)
    show.add_argument("file", help=file_help)

    check = commands.add_parser("check", help="check tree files")
    check.set_defaults(function=_tree_check)
    check.add_argument("file", nargs="+", help=file_help)

    convert = commands.add_parser(
        "convert", help="write a tree in format 4 of BehaviorTree.CPP"
    )
    convert.set_defaults(function=_tree_convert)
    convert.add_argument("file", help=file_help)
    convert.add_argument(
        "-o", "--output", type=Path, help="the file to write, else it is shown"
    )
    convert.add_argument(
        "--force", action="store_true", help="write over an existing file"
    )
    for command in (show, check, convert):
        _add_import_option(command)


def _add_import_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--import",
        dest="imports",
        action="append",
        default=[],
        metavar="MODULE",
        help="first import a module or file.py that registers your own tree"
        " nodes, motion models, planners or metrics",
    )


def _add_scenario_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--name", help="the scenario in a file that holds several"
    )
    parser.add_argument(
        "--set",
        dest="overrides",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="change the scenario: robot.radius=0.3, humans[0].behavior=...",
    )


def _seed(text: str) -> int:
    if not text.isdecimal() or int(text) >= 2**63:
        raise argparse.ArgumentTypeError(
            f"must be a whole number in [0, 2^63), got {text!r}"
        )
    return int(text)


def _load(scenario: str, options: Any, more: Sequence[str] = ()) -> "Scenario":
    from hunav_drake.scenario import LoadScenario, ScenarioError

    try:
        return LoadScenario(
            filename=scenario,
            scenario_name=options.name,
            overrides=[*options.overrides, *more],
        )
    except ScenarioError as error:
        raise _InputError(str(error)) from error


def _run(options: argparse.Namespace) -> int:
    more = [f"planner.name={options.planner}"] if options.planner else []
    scenario = _load(options.scenario, options, more)
    if options.out is not None:
        check_out(options.out)
    from hunav_drake.results import FormatMetricsTable
    from hunav_drake.scenario import ScenarioError
    from hunav_drake.simulation import RunTrial

    replay = options.out is not None and not options.no_replay
    meshcat = None
    if options.meshcat or replay:
        from hunav_drake.replay import SetView, StartMeshcatLocal

        # Meshcat tells its address; only who wants to watch cares.
        logging.getLogger("drake").setLevel(logging.WARNING)
        meshcat = StartMeshcatLocal()
        SetView(meshcat, scenario.world, scenario.humans, scenario.robot)
    if options.meshcat and meshcat is not None:
        print(f"Watch the trial at {meshcat.web_url()}", flush=True)

    started = time.perf_counter()
    with contextlib.ExitStack() as stack:
        progress = None
        if not options.quiet:
            progress = stack.enter_context(
                _ProgressBar(scenario.simulation.duration)
            ).show
        try:
            result = RunTrial(
                scenario,
                options.seed,
                meshcat=meshcat,
                realtime_rate=1.0 if options.meshcat else 0.0,
                progress=progress,
            )
        except ScenarioError as error:
            raise _InputError(str(error)) from error
    elapsed = time.perf_counter() - started

    text = FormatMetricsTable(result)
    print(text.splitlines()[1] if options.quiet else text)
    if not options.quiet:
        rate = result.end_time / elapsed
        print(f"\nTook {elapsed:.2f} s, {rate:.0f} times real time")
    if options.out is not None:
        _keep(result, options, meshcat if replay else None)
    if options.meshcat and sys.stdin.isatty():
        input("Press Enter to close the view. ")
    completed = result.end_reason == "goal" or scenario.robot.goal is None
    return DONE if completed else FAILED


def _keep(
    result: "TrialResult", options: argparse.Namespace, meshcat: Any
) -> None:
    """Writes the files of a run; its replay is what Meshcat has recorded."""
    from hunav_drake.report import WriteReport
    from hunav_drake.result_files import GetTag, WriteResult

    replay = None
    try:
        written = WriteResult(result, options.out, format=options.format)
        tag = GetTag(written)
        if meshcat is not None:
            from hunav_drake.replay import SaveReplay

            replay = options.out / f"replay_{tag}.html"
            SaveReplay(meshcat, replay)
        report = WriteReport(
            result, options.out / f"report_{tag}.html", replay=replay
        )
    except (OSError, ValueError) as error:
        raise _InputError(f"--out {options.out}: {error}") from error
    print(f"Wrote {len(written)} files to {options.out}")
    print(f"Report, for a browser: {report}")
    if replay is not None:
        print(f"Replay, for a browser: {replay}")


class _ProgressBar:
    """Shows simulated seconds while a trial runs, if someone looks."""

    def __init__(self, duration: float) -> None:
        from tqdm import tqdm

        self._bar = tqdm(
            total=duration,
            bar_format="{l_bar}{bar}| {n:.1f}/{total:.1f} s",
            disable=None,
            leave=False,
        )

    def __enter__(self) -> "_ProgressBar":
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()

    def show(self, seconds: float) -> None:
        self._bar.update(seconds - self._bar.n)


def _list(options: argparse.Namespace) -> int:
    from hunav_drake.scenario import ListScenarios

    scenarios = ListScenarios()
    width = max(map(len, scenarios))
    for name, description in scenarios.items():
        print(f"{name:{width}}  {description}")
    return DONE


def _check(options: argparse.Namespace) -> int:
    code = DONE
    for name in options.scenario:
        try:
            scenario = _load(name, options)
        except _InputError as error:
            print(error, file=sys.stderr)
            code = BAD_INPUT
        else:
            people = len(scenario.humans)
            print(
                f"{name}: ok ({people} {'person' if people == 1 else 'people'},"
                f" {len(scenario.world.walls)} walls,"
                f" planner {scenario.planner.name})"
            )
    return code


def _import(options: argparse.Namespace) -> int:
    from hunav_drake.hunav_yaml import ImportAgents
    from hunav_drake.scenario import SaveScenario, ScenarioError

    output: Path | None = options.output
    if output is not None and output.exists() and not options.force:
        raise _InputError(f"{output} exists already; --force writes over it")
    try:
        scenario = ImportAgents(
            options.agents, metrics_filename=options.metrics
        )
        text = SaveScenario(scenario, output)
    except ScenarioError as error:
        raise _InputError(str(error)) from error
    except OSError as error:
        raise _InputError(f"{output}: {error.strerror}") from error
    if output is None:
        print(text, end="")
    else:
        print(f"Wrote {len(scenario.humans)} people to {output}")
    return DONE


def _tree_show(options: argparse.Namespace) -> int:
    from hunav_drake import tree_commands
    from hunav_drake.systems.behavior import BehaviorTreeError

    try:
        return tree_commands.show(options.file)
    except BehaviorTreeError as error:
        raise _InputError(str(error)) from error


def _tree_check(options: argparse.Namespace) -> int:
    from hunav_drake import tree_commands

    return tree_commands.check(options.file)


def _tree_convert(options: argparse.Namespace) -> int:
    from hunav_drake import tree_commands
    from hunav_drake.systems.behavior import BehaviorTreeError

    output: Path | None = options.output
    try:
        return tree_commands.convert(options.file, output, force=options.force)
    except BehaviorTreeError as error:
        raise _InputError(str(error)) from error
    except FileExistsError as error:
        raise _InputError(
            f"{output} exists already; --force writes over it"
        ) from error
    except OSError as error:
        raise _InputError(f"{output}: {error.strerror}") from error


def _doctor(options: argparse.Namespace) -> int:
    from hunav_drake.provenance import MakeProvenance
    from hunav_drake.scenario import LoadScenario, SaveScenario
    from hunav_drake.simulation import RunTrial

    scenario = LoadScenario(
        filename="passing", overrides=["simulation.duration=2.0"]
    )
    provenance = MakeProvenance(
        SaveScenario(scenario), seed=0, planner=scenario.planner.name
    )
    for key, value in provenance.items():
        print(f"{key:18} {value}")
    started = time.perf_counter()
    first = RunTrial(scenario)
    elapsed = time.perf_counter() - started
    repeats = first.recording == RunTrial(scenario).recording
    print(f"{'short run':18} ok, {elapsed:.2f} s for {first.end_time:g} s")
    print(f"{'repeats':18} {'ok, bit for bit' if repeats else 'NO'}")
    return DONE if repeats else FAILED


if __name__ == "__main__":
    sys.exit(main())
