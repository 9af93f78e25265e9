"""The commands `hunav evaluate` and `hunav metrics`."""

import argparse
from pathlib import Path

from hunav_drake.commands.errors import (
    DONE,
    check_out,
    input_errors,
    output_errors,
)
from hunav_drake.commands.options import add_format_option, add_import_option


def add_evaluate_options(evaluate: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav evaluate`."""
    evaluate.description = (
        "Computes the metrics of a recording. The file is a .npz of a trial, a"
        " .csv with the columns time, agent, x, y (and optionally yaw, vx, vy,"
        " omega, radius, behavior, group_id, behavior_status; the robot is the"
        ' agent "robot"), or a .json with the messages of HuNavSim at each'
        " step."
    )
    evaluate.set_defaults(function=_evaluate)
    evaluate.add_argument("file", type=Path, help="the recording")
    evaluate.add_argument(
        "--metrics",
        nargs="+",
        metavar="NAME",
        default=["all"],
        help='names, families, "paper" or "all" (see `hunav metrics`)',
    )
    evaluate.add_argument(
        "--goal",
        metavar="X,Y[,YAW]",
        help="the goal, in meters and radians, instead of the recording's;"
        " write --goal=-1,2 if it starts with a minus sign",
    )
    evaluate.add_argument(
        "--goal-tolerance",
        metavar="D[,YAW]",
        help="the largest distance and heading error at which the goal counts"
        " as reached, in meters and radians (default: that of the recording, or"
        " 0.2 and 0.25)",
    )
    evaluate.add_argument(
        "--walls",
        metavar="SCENARIO",
        help='a scenario with the walls of the recording, or "none". A .csv or'
        " .json has no walls; without walls, the metrics that depend on them"
        " have no value",
    )
    evaluate.add_argument(
        "--name", help="the scenario of --walls, if the file holds several"
    )
    evaluate.add_argument(
        "--reference",
        metavar="FILE",
        type=Path,
        help="a recording of the ideal trajectory of the robot; of several"
        " robots, of those with the same names",
    )
    evaluate.add_argument(
        "--people",
        metavar="TOPIC",
        default="",
        help="the topic of people in a bag, if there are several",
    )
    evaluate.add_argument(
        "--robot",
        metavar="TOPIC",
        default="",
        help="the topic of the robot in a bag, if there are several",
    )
    evaluate.add_argument(
        "--situations",
        action="store_true",
        help="also compute the metrics while somebody passes, crosses the path,"
        " ...: see `hunav situations`",
    )
    evaluate.add_argument(
        "--encounters",
        action="store_true",
        help="also compute how long the robot was in each zone around people,"
        " and how often it crossed in front of them",
    )
    evaluate.add_argument(
        "--out", metavar="DIR", type=Path, help="write the run to DIR/runs"
    )
    evaluate.add_argument(
        "--json", action="store_true", help="print the results as JSON"
    )
    add_format_option(evaluate)
    add_import_option(evaluate)


def add_metrics_options(metrics: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav metrics`."""
    metrics.set_defaults(function=_list)
    actions = metrics.add_subparsers(title="commands")
    show = actions.add_parser("show", help="show the definitions of metrics")
    show.set_defaults(function=_show)
    show.add_argument(
        "name", nargs="+", help='names, families, "paper" or "all"'
    )
    for parser in (metrics, show):
        add_import_option(parser)


def _evaluate(options: argparse.Namespace) -> int:
    if options.out is not None:
        check_out(options.out)
    from hunav_drake.commands.evaluate import evaluate_file, lacks_walls
    from hunav_drake.runs.result_files import WriteResult
    from hunav_drake.trial.result import (
        FormatMetricsTable,
        with_encounters,
        with_situations,
    )

    with input_errors(ValueError, ImportError):
        result = evaluate_file(
            options.file,
            metric_names=options.metrics,
            goal=options.goal,
            goal_tolerance=options.goal_tolerance,
            walls=options.walls,
            walls_name=options.name,
            reference=options.reference,
            topics={"people": options.people, "robot": options.robot},
        )
        if options.situations:
            result = with_situations(result)
        if options.encounters:
            result = with_encounters(result, result.recording)
    # Before printing, which the reader of a pipe may end early.
    folder = None
    if options.out is not None:
        with output_errors(options.out):
            folder = WriteResult(result, options.out, format=options.format)
    if options.json:
        from hunav_drake.runs.run_row import make_row, result_to_json

        print(result_to_json(make_row(result)))
        return DONE
    print(FormatMetricsTable(result))
    if options.encounters:
        print(
            "\nEncounters assume straight lines between samples, which are up"
            f" to {result.recording.period:.3g} s\napart."
        )
    if lacks_walls(result):
        print(
            "\nThe walls are unknown, so metrics that depend on them have no"
            " value.\nGive the walls with --walls SCENARIO, or --walls none."
        )
    if folder is not None:
        print(f"\nWrote the run to {folder}")
    return DONE


def _list(options: argparse.Namespace) -> int:
    from hunav_drake.commands.metrics_text import list_metrics

    print(list_metrics())
    return DONE


def _show(options: argparse.Namespace) -> int:
    from hunav_drake.commands.metrics_text import show_metrics

    with input_errors(ValueError):
        print(show_metrics(options.name))
    return DONE
