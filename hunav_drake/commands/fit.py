"""The command `hunav fit`."""

import argparse
from pathlib import Path

from hunav_drake.commands.errors import (
    DONE,
    check_once,
    check_output,
    input_errors,
)


def add_fit_options(fit: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav fit`."""
    fit.description = (
        "Fits weights of the social force model to recorded people, and tells"
        " how sure they are. All files are fitted together."
    )
    fit.set_defaults(function=_fit)
    fit.add_argument(
        "files",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="recorded people (see `hunav tracks`)",
    )
    fit.add_argument(
        "--free",
        default="social_factor",
        metavar="NAMES",
        help="the weights to fit, separated by commas (default: social_factor)",
    )
    fit.add_argument(
        "--goal",
        choices=("true", "ahead"),
        default="true",
        help="what the model is told of each person: the true end point and"
        " mean speed, or straight on (default: true)",
    )
    fit.add_argument(
        "--profile",
        choices=("default", "hunavsim", "hunav_drake_0.1"),
        default="default",
        help="the profile of the crowd, from whose weights the fit starts",
    )
    fit.add_argument(
        "--walls",
        metavar="SCENARIO",
        help="a scenario with the walls of the recordings (default: none)",
    )
    fit.add_argument(
        "--name", help="the scenario of --walls, if the file holds several"
    )
    fit.add_argument(
        "--holdout",
        nargs="+",
        type=Path,
        default=[],
        metavar="FILE",
        help="other recordings, to compare the weights before and after",
    )
    fit.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="write all weights as YAML, as `forces` of a person has them",
    )
    fit.add_argument(
        "--force", action="store_true", help="overwrite an existing file"
    )


def _fit(options: argparse.Namespace) -> int:
    from hunav_drake.scenario import LoadScenario, ScenarioError
    from hunav_drake.systems.common.files import atomic_write
    from hunav_drake.systems.crowd import CrowdConfig
    from hunav_drake.validation.fitting import FitForces, fit_text, forces_yaml
    from hunav_drake.validation.recorded import (
        CrowdPrediction,
        judge_recorded,
        read_windows,
        recorded_overlap,
    )
    from hunav_drake.validation.recorded_tables import format_scores

    if options.output is not None:
        check_output(options.output, options.force)
    config = CrowdConfig(profile=options.profile)
    with input_errors(ValueError, ScenarioError):
        check_once([*options.files, *options.holdout])
        obstacles = None
        if options.walls is not None:
            scenario = LoadScenario(options.walls, scenario_name=options.name)
            obstacles = scenario.world.obstacles()
        windows = [w for file in options.files for w in read_windows(file)]
        others = {str(it): read_windows(it) for it in options.holdout}
        fit = FitForces(
            windows,
            [name.strip() for name in options.free.split(",")],
            config=config,
            goal=options.goal,
            obstacles=obstacles,
        )
    if options.output is not None:
        place = options.output
        with input_errors(place=place), atomic_write(place) as file:
            file.write(forces_yaml(fit.forces).encode())
    print(fit_text(fit))
    models = {
        "before": CrowdPrediction(config, obstacles=obstacles),
        "fitted": CrowdPrediction(config, fit.values, obstacles),
    }
    for name, held in others.items():
        scores = judge_recorded(name, held, models, [options.goal])
        print(f"\n{format_scores(scores, {name: recorded_overlap(held)})}")
    if options.output is not None:
        print(f"Wrote {options.output}")
    return DONE
