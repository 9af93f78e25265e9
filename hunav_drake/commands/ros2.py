"""The commands `hunav export` and `hunav bridge`."""

import argparse
from pathlib import Path
import sys

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
    load_scenario,
    tell_doubts,
    whole_number,
)
from hunav_drake.systems.common.input_error import InputError

_NOT_AGAIN = (
    "hunav: warning: the run cannot be repeated ({}), so the bag has what the"
    " recording has: no scans, plans and costmaps"
)


def add_export_options(export: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav export`."""
    export.description = (
        "Writes a run to a bag of ROS 2, for RViz and Foxglove. The trial of a"
        " run's folder is run again, for scans, plans and costmaps."
    )
    export.set_defaults(function=_export)
    export.add_argument(
        "run",
        type=Path,
        help="the folder of a run (see `hunav run --out`), or a recording",
    )
    storage = export.add_mutually_exclusive_group()
    storage.add_argument(
        "--mcap",
        dest="suffix",
        action="store_const",
        const=".mcap",
        default=".mcap",
        help="write an MCAP file (the default)",
    )
    storage.add_argument(
        "--db3",
        dest="suffix",
        action="store_const",
        const=".db3",
        help="write an SQLite file, for distributions before iron",
    )
    export.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FOLDER",
        help="the folder of the bag to write (default: bag, beside the"
        " recording)",
    )
    add_import_option(export)


def add_bridge_options(bridge: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav bridge`."""
    bridge.description = (
        "Runs a trial whose robots are driven by another program, such as Nav2,"
        " over ROS 2's topics. It needs no ROS."
    )
    bridge.set_defaults(function=_bridge)
    add_trial_options(bridge)
    bridge.add_argument(
        "--real-time",
        action="store_true",
        help="run in real time with the last command that has come, instead of"
        " waiting for one in each cycle",
    )
    bridge.add_argument(
        "--stamped",
        action="store_true",
        help="take commands of type TwistStamped instead of Twist",
    )
    bridge.add_argument(
        "--time-limit",
        type=float,
        metavar="S",
        help="the longest wait for a command, in seconds (default: 10)",
    )
    bridge.add_argument(
        "--domain",
        type=whole_number(0, "233"),
        help="the DDS domain (default: that of ROS_DOMAIN_ID, or 0)",
    )
    bridge.add_argument(
        "--network",
        default="lo",
        metavar="NAME",
        help="the network interface (default: lo, this machine alone)",
    )
    bridge.add_argument(
        "--out", metavar="DIR", type=Path, help="write the run to DIR/runs"
    )
    add_format_option(bridge)
    add_import_option(bridge)


def _export(options: argparse.Namespace) -> int:
    from hunav_drake.hunavsim.ros2.write_bag import WriteBag
    from hunav_drake.runs.recording_files import ReadRecording
    from hunav_drake.scenario import LoadScenario, ScenarioError
    from hunav_drake.scenario.fleet import robot_parts
    from hunav_drake.systems.planning.ros2.bridge import BridgePlanner
    from hunav_drake.views.recorded_trial import (
        RECORDING,
        SCENARIO,
        recording_file,
    )

    if not options.run.exists():
        raise InputError(
            f"{options.run}: there is no such file or folder; `hunav run"
            " SCENARIO --out DIR` writes one"
        )
    with input_errors(ValueError, ImportError):
        file = options.run
        if file.is_dir():
            file = recording_file(file)
        recording = ReadRecording(file)
    folder = options.output or file.parent / "bag"
    if folder.exists():
        raise InputError(
            f"{folder} exists; choose another folder with --output"
        )
    target = folder / f"{folder.name}{options.suffix}"
    scenario_file = file.with_name(SCENARIO)
    again = None
    if file.name == RECORDING and scenario_file.exists():
        with input_errors(ScenarioError):
            again = LoadScenario(filename=str(scenario_file))
        planners = [it.scenario.planner for it in robot_parts(again)]
        if any(isinstance(it, BridgePlanner) for it in planners):
            # Another program drove it, and would be asked again.
            print(_NOT_AGAIN.format("another program drove"), file=sys.stderr)
            again = None
    with input_errors(ImportError, ScenarioError), output_errors(folder):
        try:
            WriteBag(recording, target, scenario=again)
        except ValueError as error:
            if again is None or "another trial" not in str(error):
                raise InputError(str(error)) from error
            why = "was the program, the machine or a file changed?"
            print(_NOT_AGAIN.format(why), file=sys.stderr)
            WriteBag(recording, target)
    print(f"Wrote the bag {folder}")
    return DONE


def _bridge(options: argparse.Namespace) -> int:
    more = []
    if options.seed is not None:
        more.append(f"simulation.seed={options.seed}")
    scenario = load_scenario(options.scenario, options, more)
    tell_doubts(scenario)
    if options.out is not None:
        check_out(options.out)
    from hunav_drake.commands.run import keep_run, with_setting
    from hunav_drake.hunavsim.ros2.live import RunBridge, with_bridge
    from hunav_drake.scenario import ScenarioError
    from hunav_drake.systems.planning.ros2.bridge import BridgePlanner
    from hunav_drake.trial.result import FormatMetricsTable

    settings = {
        "lockstep": not options.real_time,
        "command_type": "TwistStamped" if options.stamped else "Twist",
        "domain": options.domain,
        "network": options.network,
    }
    if options.time_limit is not None:
        if options.real_time:
            raise InputError(
                "--time-limit does not go with --real-time, which waits for no"
                " command: choose one"
            )
        settings["time_limit"] = options.time_limit
    with input_errors(ValueError, ScenarioError, ImportError):
        planner = BridgePlanner(**settings)
        scenario = with_bridge(scenario, planner)
        result = RunBridge(
            scenario,
            planner,
            tell=lambda line: print(f"hunav: {line}", file=sys.stderr),
        )
    result = with_setting(result, options)
    # Before printing, which the reader of a pipe may end early.
    written = [] if options.out is None else keep_run(result, scenario, options)
    failed = result.end_reason == "planner_failed"
    if failed:
        print(f"hunav: {result.end_message}", file=sys.stderr)
    else:
        print(FormatMetricsTable(result, headline_only=True))
    for line in written:
        print(line)
    return DONE if result.end_reason == "goal" else FAILED
