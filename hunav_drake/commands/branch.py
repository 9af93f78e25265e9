"""The commands `hunav branch` and `hunav who`."""

import argparse
from collections.abc import Sequence
import contextlib
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hunav_drake.commands.errors import (
    DONE,
    check_out,
    input_errors,
    output_errors,
)
from hunav_drake.commands.options import (
    add_import_option,
    add_trial_options,
    load_scenario,
    whole_number,
)
from hunav_drake.systems.common.input_error import InputError

if TYPE_CHECKING:
    from hunav_drake.scenario import Scenario
    from hunav_drake.trial.branches.run import Branches


def add_branch_options(branch: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav branch`."""
    branch.description = (
        "Runs a trial to an instant, and goes on from there in several ways:"
        " with other planners, without the robot, without a person, ... Tells"
        " what each means for people, compared with a reference."
    )
    branch.set_defaults(function=_branch)
    _add_instant(branch)
    for name, value, text in (
        ("planner", "NAME", "with this planner"),
        ("without", "PERSON", "in which this person is gone"),
        ("with", "KEY=VALUE", "with another setting: crowd.robot_gap=0.2"),
    ):
        branch.add_argument(
            f"--{name}",
            action="append",
            default=[],
            metavar=value,
            help=f"a branch {text}; may be repeated",
        )
    branch.add_argument(
        "--robot",
        action="append",
        default=[],
        choices=("gone", "stands"),
        help="a branch in which the robot is gone, or stands",
    )
    branch.add_argument(
        "--of",
        metavar="ROBOT",
        default="",
        help="which of several robots (default: the first)",
    )
    branch.add_argument(
        "--reference",
        metavar="BRANCH",
        default="robot gone",
        help="the branch with which people are compared, by its name in the"
        " table (default: robot gone)",
    )
    branch.add_argument(
        "--growth",
        action="store_true",
        help="tell, too, how small differences grow: with the robot 1 um aside",
    )


def add_who_options(who: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav who`."""
    who.description = (
        "Tells by how much each person, and the robot, delays each person: by"
        " leaving one out at a time, or by Shapley values, which add up."
    )
    who.set_defaults(function=_who)
    _add_instant(who)
    who.add_argument(
        "--shapley",
        type=whole_number(1),
        metavar="N",
        help="Shapley values: exact up to 6 people, with more by N orders in"
        " which they come to be there",
    )


def _add_instant(parser: argparse.ArgumentParser) -> None:
    add_trial_options(parser)
    instant = parser.add_mutually_exclusive_group()
    instant.add_argument(
        "--at",
        type=_seconds,
        metavar="T",
        help="the instant, in seconds (default: the start)",
    )
    instant.add_argument(
        "--from",
        dest="file",
        type=Path,
        metavar="FILE",
        help="the instant, as a Context that SaveContext() has written",
    )
    parser.add_argument(
        "--until",
        type=_seconds,
        metavar="T",
        help="the end, in seconds (default: simulation.duration)",
    )
    parser.add_argument(
        "--goal",
        type=whole_number(0),
        default=0,
        metavar="K",
        help="the goal at which people arrive: 0 for the one they walk to at"
        " the instant (the default), 1 for the next, ...",
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        help="write the tables, and of branches their recordings and a report,"
        " to this folder",
    )
    add_import_option(parser)


def _seconds(text: str) -> float:
    with contextlib.suppress(ValueError):
        if 0 <= float(text) < math.inf:
            return float(text)
    raise argparse.ArgumentTypeError(
        f"must be a time in seconds, not negative, got {text!r}"
    )


def _branch(options: argparse.Namespace) -> int:
    from hunav_drake.trial.branches.kinds import (
        Branch,
        RobotGone,
        RobotStands,
        WithoutPerson,
        WithPlanner,
        WithSettings,
    )
    from hunav_drake.trial.branches.run import RunBranches

    of = options.of
    robots: dict[str, Branch] = {
        "gone": RobotGone(of),
        "stands": RobotStands(of),
    }
    branches: dict[str, Branch] = {
        **{it: WithPlanner(it, robot=of) for it in options.planner},
        **{f"robot {it}": robots[it] for it in options.robot},
        **{f"without {it}": WithoutPerson(it) for it in options.without},
        **{it: WithSettings((it,)) for it in getattr(options, "with")},
    }
    if not branches:
        branches["robot stands"] = robots["stands"]
    if options.reference == "robot gone":
        branches.setdefault("robot gone", robots["gone"])
    with contextlib.ExitStack() as stack:
        scenario, diagram, context = _fork(options, stack, options.planner)
        stack.enter_context(input_errors(ValueError))
        made = RunBranches(
            scenario,
            diagram,
            context,
            until=_until(options, scenario),
            branches=branches,
            reference=options.reference,
            goal=options.goal,
            growth=options.growth and (of or True),
        )
    written = []
    if options.out is not None:
        written = _keep(made, scenario, options.out)
    _print(made)
    for line in written:
        print(line)
    return DONE


def _who(options: argparse.Namespace) -> int:
    from hunav_drake.trial.branches.who import MOST_EXACT, WhoDelayedWhom

    with contextlib.ExitStack() as stack:
        scenario, diagram, context = _fork(options, stack)
        if not diagram.humans:
            raise InputError("the scenario has no people who could be delayed")
        few = len(diagram.humans) <= MOST_EXACT
        stack.enter_context(input_errors(ValueError))
        table = WhoDelayedWhom(
            scenario,
            diagram,
            context,
            until=_until(options, scenario),
            method="shapley" if options.shapley else "leave_one_out",
            permutations=None if few else options.shapley,
            goal=options.goal,
        )
    how = "Without one at a time: effects overlap, so columns do not add up."
    if options.shapley:
        how = "Shapley values: a column adds up to what all delay a person."
    print("By how much the person of a column arrives later because of whom")
    print(f"the row names, in seconds.\n\n{_text(table)}\n\n{how}")
    if table.isna().all().any():
        print(
            "No value: the person has no such goal (--goal), or does not arrive"
            " there by then (--until)."
        )
    if options.out is not None:
        path = options.out / "who.csv"
        with output_errors(options.out):
            table.to_csv(path, float_format="%.12g")
        print(f"Wrote the table to {path}")
    return DONE


def _fork(
    options: argparse.Namespace,
    stack: contextlib.ExitStack,
    planners: Sequence[str] = (),
) -> Any:
    """Returns the scenario, its diagram and the Context at the instant.

    The stack enters a context that tells about compilation, also that for
    other planners.
    """
    more = []
    if options.seed is not None:
        if options.file is not None:
            raise InputError(
                "--seed does not go with --from: a saved Context has the seed"
                " of its trial; leave --seed out"
            )
        more.append(f"simulation.seed={options.seed}")
    scenario = load_scenario(options.scenario, options, more)
    if options.out is not None:
        check_out(options.out, "")
    from hunav_drake.runs.compiling_ahead import compiling_ahead
    from hunav_drake.scenario import ScenarioError
    from hunav_drake.scenario.checks import check_begins_alone
    from hunav_drake.trial.compiling import told_compile_time
    from hunav_drake.trial.context_file import LoadContext
    from hunav_drake.trial.diagram import MakeTrialDiagram
    from hunav_drake.trial.simulation import MakeTrialSimulator

    stack.enter_context(
        told_compile_time(lambda: compiling_ahead(scenario, planners))
    )
    with input_errors(ScenarioError):
        # (A saved Context has the trigger.)
        if options.file is None:
            check_begins_alone(scenario)
        diagram = MakeTrialDiagram(scenario, drawn=False)
    if options.file is not None:
        with input_errors(ValueError):
            return scenario, diagram, LoadContext(diagram, options.file)
    instant = options.at or 0.0
    step = scenario.simulation.time_step
    if abs(instant / step - round(instant / step)) > 1e-6:
        raise InputError(
            f"--at must be a multiple of simulation.time_step, {step:g} s, got"
            f" {instant:g}"
        )
    simulator = MakeTrialSimulator(diagram)
    if instant:
        simulator.AdvanceTo(instant)
    context = simulator.get_context()
    if context.get_time() < instant:
        raise InputError(
            f"--at {instant:g}: the trial ends before, at"
            f" {context.get_time():g} s"
        )
    return scenario, diagram, context


def _until(options: argparse.Namespace, scenario: "Scenario") -> float:
    until = options.until
    return scenario.simulation.duration if until is None else float(until)


def _keep(made: "Branches", scenario: "Scenario", out: Path) -> list[str]:
    """Writes the files of branches; returns messages."""
    from hunav_drake.report.branches_page import WriteBranchesPage
    from hunav_drake.runs.result_files import WriteResult

    with output_errors(out):
        made.people.to_csv(
            out / "branches.csv", index=False, float_format="%.12g"
        )
        for name, future in made.futures.items():
            if future.result is not None:
                WriteResult(future.result, out, label=name)
        page = WriteBranchesPage(
            made, out / "branches.html", scenario.name or "trial"
        )
    return [
        f"Wrote the table to {out / 'branches.csv'}",
        f"Report, for a browser: {page}",
    ]


def _print(made: "Branches") -> None:
    from hunav_drake.trial.branches.run import growth_text
    from hunav_drake.trial.result import how_it_ended

    times = made.people[made.people["quantity"] == "time"]
    late = times.pivot(index="branch", columns="person", values="difference")
    late = late.reindex([*made.futures], columns=[*made.human_names])
    print(f"From {made.start:g} s until {made.until:g} s\n")
    if made.human_names:
        print(
            "Extra time of each person until the arrival, compared with"
            f" {made.reference!r}, s\n\n{_text(late)}\n\nSums over people"
            f"\n\n{_text(made.totals)}\n"
        )
    print("The robot")
    for name, future in made.futures.items():
        if future.robots:
            print(f"  {name}: {how_it_ended(made[name])}")
    if told := growth_text(made.growth):
        print(f"\n{told}")


def _text(table: Any) -> str:
    """Returns a table for the terminal."""
    # (Adding 0 takes away the sign of what rounds to 0.)
    rounded = table.round(3) + 0.0
    rounded.index.name = rounded.columns.name = None
    text: str = rounded.to_string(
        na_rep="-",
        float_format="{:.3f}".format,
        formatters={"people": "{:.0f}".format},
    )
    return text
