"""The commands `hunav falsify` and `hunav risk`."""

import argparse
from collections.abc import Iterator
import contextlib
import dataclasses
import json
import math
from pathlib import Path
import sys
from typing import TYPE_CHECKING

from hunav_drake.commands.errors import DONE, input_errors
from hunav_drake.commands.options import (
    add_executor_options,
    add_import_option,
    add_scenario_options,
    load_scenario,
    progress_bar,
    run_executor,
    whole_number,
)
from hunav_drake.systems.common.input_error import InputError

if TYPE_CHECKING:
    from hunav_drake.runs.failures.found import Failures
    from hunav_drake.runs.failures.scene_runs import RunOptions
    from hunav_drake.scenario import Scenario


def add_falsify_options(falsify: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav falsify`."""
    falsify.description = (
        "Searches a space of scenes for those in which a planner fails, and"
        " makes them minimal. Finished runs are not repeated, so an interrupted"
        " search continues where it stopped."
    )
    falsify.set_defaults(function=_falsify)
    falsify.add_argument(
        "space", type=Path, help="a file that tells what may differ"
    )
    falsify.add_argument(
        "--method",
        choices=("cma", "random"),
        default="cma",
        help="cma descends on the robustness, random draws (default: cma)",
    )
    falsify.add_argument(
        "--polish",
        metavar="N",
        type=whole_number(0),
        default=0,
        help="then try N more scenes, down the gradient from the worst one"
        " (default: 0)",
    )
    falsify.add_argument(
        "--seed",
        type=whole_number(0),
        default=0,
        help="the seed of the search (default: 0)",
    )
    falsify.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        default=Path("failures"),
        help="the folder for scenes, tables and runs (default: failures)",
    )
    falsify.add_argument(
        "--replays", action="store_true", help="also write a replay of each"
    )
    _add_common(falsify, 300, "the number of scenes to try")


def add_risk_options(risk: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav risk`."""
    risk.description = (
        "Estimates how likely a trial fails, by plain Monte Carlo over seeds,"
        " with an exact interval. The seeds must draw something: see"
        " crowd.decisions. With --splitting, it searches for rare failures"
        " instead, by forking the trials that come near to one."
    )
    risk.set_defaults(function=_risk)
    risk.add_argument("scenario", help="a shipped scenario or a file")
    add_scenario_options(risk)
    risk.add_argument(
        "--robustness",
        metavar="NAME",
        default="collision",
        help="the kind of failure (default: collision)",
    )
    risk.add_argument(
        "--half-width",
        type=float,
        metavar="PART",
        help="stop once half of the interval is less than this part of the"
        " estimate (default: 0.5)",
    )
    risk.add_argument(
        "--confidence",
        type=float,
        help="the confidence of the interval (default: 0.95)",
    )
    risk.add_argument(
        "--splitting",
        metavar="N",
        type=whole_number(2),
        help="split N paths at people's decisions; 400 are usual",
    )
    risk.add_argument(
        "--repeats",
        type=whole_number(1),
        help="the number of independent estimates by splitting (default: 10)",
    )
    risk.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        help="keep finished runs in a folder, to continue from there; of"
        " --splitting also the failures found",
    )
    _add_common(risk, None, "the largest number of runs")


def _add_common(
    parser: argparse.ArgumentParser, budget: int | None, meaning: str
) -> None:
    parser.add_argument(
        "--planner",
        metavar="NAME",
        help="the planner (default: that of the scenario)",
    )
    parser.add_argument(
        "--budget",
        type=whole_number(1),
        default=budget,
        help=f"{meaning} (default: {budget or '1000; splitting 20000'})",
    )
    add_executor_options(parser)
    parser.add_argument(
        "--fresh",
        action="store_true",
        help="run all again; the old log is kept as runs_old.jsonl",
    )
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument(
        "--quiet", action="store_true", help="show no progress bar"
    )
    add_import_option(parser)


@contextlib.contextmanager
def _run_options(options: argparse.Namespace) -> Iterator["RunOptions"]:
    """Yields where trials are run; errors of the input are told."""
    from hunav_drake.runs.tasks import UnfitWorkerError
    from hunav_drake.scenario import ScenarioError

    kinds = (ScenarioError, ValueError, ImportError, UnfitWorkerError)
    with (
        input_errors(*kinds),
        run_executor(options) as (executor, workers),
        progress_bar("runs", options.quiet) as (_, show),
    ):
        yield {
            "out": options.out,
            "workers": workers or 0,
            "executor": executor,
            "imports": tuple(getattr(options, "imports", ())),
            "fresh": options.fresh,
            "progress": show,
        }


def _falsify(options: argparse.Namespace) -> int:
    from hunav_drake.runs.failures.search import Falsify
    from hunav_drake.views.suite_replays import WriteReplay

    with _run_options(options) as given:
        failures = Falsify(
            options.space,
            options.planner,
            method=options.method,
            seed=options.seed,
            budget=options.budget,
            polish=options.polish,
            **given,
        )
    if options.replays:
        for i, cell in enumerate(failures.cells()):
            WriteReplay(cell, options.out / f"{i + 1:03d}.html")
    _print_failures(failures, options)
    return DONE


def _print_failures(failures: "Failures", options: argparse.Namespace) -> None:
    table = failures.table
    if options.json:
        about = {
            "robustness": failures.robustness,
            "runs": len(failures.runs),
            "refused": failures.refused,
            "failures": failures.num_failures,
            "first": failures.first_failure,
            "scenes": json.loads(table.to_json(orient="records")),
        }
        print(json.dumps(about, indent=2))
        return
    first = failures.first_failure
    at = "" if first is None else f", the first at run {first + 1}"
    print(
        f"{failures.robustness}: {failures.num_failures} of"
        f" {len(failures.runs)} scenes failed{at};"
        f" {failures.refused} were no valid scenes"
    )
    if failures.refused == len(failures.runs):
        print(
            f"No scene was valid, the first because: {failures.fault}. Change"
            " the ranges, or require.start_gap."
        )
    elif failures.scenes:
        print(table.to_string(index=False, float_format="{:.3g}".format))
    else:
        least = min(it.robustness for _, it in failures.runs)
        print(f"The nearest had the robustness {least:.3g}.")
    print(f"Scenes, Contexts and tables: {options.out}", file=sys.stderr)


def _risk(options: argparse.Namespace) -> int:
    from hunav_drake.runs.failures.risk import EstimateFailureProbability
    from hunav_drake.scenario.overrides import seed_change

    scenario = load_scenario(options.scenario, options, planner=options.planner)
    if options.fresh and options.out is None:
        raise InputError("--fresh: is for --out; without it, no runs are kept")
    if change := seed_change(options.overrides):
        raise InputError(
            f"--set {change}: would have no effect: the seeds are 0, 1, ..., up"
            " to --budget; leave it out"
        )
    if options.splitting:
        return _splitting(scenario, options)
    if options.repeats is not None:
        raise InputError("--repeats: is for --splitting")
    limits = {
        "relative_half_width": options.half_width,
        "confidence": options.confidence,
        "budget": options.budget,
    }
    with _run_options(options) as given:
        found = EstimateFailureProbability(
            scenario,
            options.robustness,
            **{key: it for key, it in limits.items() if it is not None},
            **given,
        )
    if options.json:
        about = dataclasses.asdict(found)
        del about["failings"]
        about["probability"] = found.probability
        print(json.dumps(about, indent=2))
        return DONE
    print(found)
    if found.different < found.runs:
        print(
            f"Only {found.different} of {found.runs} runs differ: the interval"
            " is too narrow; let the seeds draw more"
        )
    if not found.precise:
        print("The budget ended before the interval was as narrow as asked.")
    return DONE


def _splitting(scenario: "Scenario", options: argparse.Namespace) -> int:
    from hunav_drake.runs.failures.splitting import SplitFailureProbability

    for name in ("half_width", "confidence"):
        if getattr(options, name) is not None:
            raise InputError(
                f"--{name.replace('_', '-')}: is for plain Monte Carlo, without"
                " --splitting"
            )
    limits = {"repeats": options.repeats, "budget": options.budget}
    with _run_options(options) as given:
        found = SplitFailureProbability(
            scenario,
            options.robustness,
            particles=options.splitting,
            **{key: it for key, it in limits.items() if it is not None},
            **given,
        )
    if options.json:
        names = ("robustness", "particles", "estimates", "runs", "complete")
        about = {name: getattr(found, name) for name in names}
        numbers = {"probability": found.probability, "error": found.error}
        about |= {
            name: None if math.isnan(it) else it for name, it in numbers.items()
        }
        print(json.dumps(about, indent=2))
        return DONE
    print(found)
    if found.probability > 0:
        print(
            "This is a search: check it by plain Monte Carlo (without"
            " --splitting) before you report it."
        )
    elif found.failures.num_failures:
        print("Failures were found only in a repeat that was not finished.")
    else:
        print("No failure was found, which does not tell how rare it is.")
    if not found.complete:
        print("The budget ended before all repeats were finished.")
    if found.failures.scenes:
        print(
            found.failures.table.to_string(
                index=False, float_format="{:.3g}".format
            )
        )
    return DONE
