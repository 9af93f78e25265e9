"""The command `hunav validate`."""

import argparse
from collections.abc import Mapping
from pathlib import Path
import sys
from typing import TYPE_CHECKING

from hunav_drake.commands.errors import (
    DONE,
    check_once,
    check_out,
    check_page,
    input_errors,
)
from hunav_drake.commands.options import (
    add_import_option,
    progress_bar,
    whole_number,
)

if TYPE_CHECKING:
    from hunav_drake.systems.common.arrays import Array
    from hunav_drake.validation.case import Outcome
    from hunav_drake.validation.recorded import Predict, Score


def add_validate_options(validate: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav validate`."""
    validate.description = (
        "Runs the test cases of RiMEA, NIST and ISO 20414, and cases on known"
        " behavior of crowds, with each motion model, and prints expected and"
        " measured values and verdicts. A failed case is a result, not an"
        " error."
    )
    validate.set_defaults(function=_validate)
    validate.add_argument(
        "--model", nargs="+", default=[], help="only these motion models"
    )
    validate.add_argument(
        "--case", nargs="+", default=[], help="only these cases, by name"
    )
    validate.add_argument(
        "--tracks",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="instead of cases, predict these recorded people (see `hunav"
        " tracks`) and compare with constant velocity",
    )
    validate.add_argument(
        "--body-radius",
        type=float,
        metavar="M",
        help="with --tracks, the radius of people in meters (default: 0.2, a"
        " disc as large as an adult from above)",
    )
    validate.add_argument(
        "--list", action="store_true", help="only list the cases"
    )
    validate.add_argument(
        "--quick",
        action="store_true",
        help="fewer people and a shorter time, for a first look",
    )
    validate.add_argument(
        "--seed", type=whole_number(0), default=0, help="the seed (default: 0)"
    )
    validate.add_argument(
        "--workers",
        type=whole_number(1),
        help="the number of processes (default: 1); it does not change the"
        " results",
    )
    validate.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        help="write validation.html, outcomes.csv and numbers.csv to DIR",
    )
    validate.add_argument(
        "--markdown",
        metavar="FILE",
        type=Path,
        help="also write the page as Markdown, with its pictures in the same"
        " folder",
    )
    validate.add_argument(
        "--json", action="store_true", help="print JSON, not a table"
    )
    add_import_option(validate)


def _validate(options: argparse.Namespace) -> int:
    from hunav_drake.validation.case import Setting
    from hunav_drake.validation.cases import CASES
    from hunav_drake.validation.run import (
        run_cases,
        select_cases,
        select_models,
    )
    from hunav_drake.validation.tables import format_table, outcomes_json

    with input_errors(ValueError):
        models = select_models(options.model)
        if options.tracks:
            return _judge(options, models)
        if options.body_radius is not None:
            raise ValueError("--body-radius: needs --tracks; add it")
        cases = select_cases(options.case)
    if options.list:
        width = max(map(len, cases))
        for name in cases:
            print(f"{name:{width}}  {CASES[name].standards}")
        return DONE
    # Before a long run.
    if options.out is not None:
        check_out(options.out, "")
    if options.markdown is not None:
        check_page(options.markdown, "--markdown")
    settings = [Setting(m, options.seed, options.quick) for m in models]
    with progress_bar("cases") as (bar, _):
        bar.total = len(cases) * len(settings)

        def show(outcome: "Outcome") -> None:
            bar.set_description_str(f"{outcome.case}, {outcome.model}")
            bar.update()

        outcomes = run_cases(
            cases,
            settings,
            workers=options.workers or 1,
            imports=tuple(getattr(options, "imports", ())),
            progress=show,
        )
    # Before printing, which the reader of a pipe may end early.
    written = _write(outcomes, options)
    print(outcomes_json(outcomes) if options.json else format_table(outcomes))
    for path in written:
        print(f"Wrote {path}", file=sys.stderr)
    return DONE


def _judge(options: argparse.Namespace, models: list[str]) -> int:
    """Predicts recorded people with motion models, and prints the scores."""
    from hunav_drake.systems.common.files import atomic_write
    from hunav_drake.systems.crowd import CrowdConfig
    from hunav_drake.systems.crowd.motion_model import MOTION_MODELS
    from hunav_drake.validation.recorded import (
        BODY,
        CrowdPrediction,
        constant_velocity,
        judge_recorded,
        read_windows,
        recorded_overlap,
        sample_of,
    )
    from hunav_drake.validation.recorded_plots import draw_samples
    from hunav_drake.validation.recorded_tables import (
        format_scores,
        scores_csv,
        scores_json,
        scores_markdown,
    )

    for name in ("case", "list", "quick", "seed", "workers"):
        if getattr(options, name):
            raise ValueError(f"--{name}: has no effect with --tracks; leave it")
    if options.out is not None:
        check_out(options.out, "")
    if options.markdown is not None:
        check_page(options.markdown, "--markdown")
    radius = BODY if options.body_radius is None else options.body_radius
    predictions: dict[str, Predict] = {"constant_velocity": constant_velocity}
    for model in models:
        config = CrowdConfig(model=MOTION_MODELS.make(model))
        predictions[model] = CrowdPrediction(config, radius=radius)
        if model == "social_force":
            predictions["no social force"] = CrowdPrediction(
                config, {"social_factor": 0.0}, radius=radius
            )
            predictions["hunav_drake_0.1"] = CrowdPrediction(
                CrowdConfig(profile="hunav_drake_0.1"), radius=radius
            )
    scenes: dict[str, list[Array]] = {}
    check_once(options.tracks)
    for file in options.tracks:
        scenes[_scene_name(file, scenes)] = read_windows(file)
    scores: list[Score] = []
    with progress_bar("scenes") as (bar, _):
        bar.total = len(scenes)
        for scene, windows in scenes.items():
            bar.set_description_str(scene)
            scores += judge_recorded(scene, windows, predictions)
            bar.update()
    overlaps = {name: recorded_overlap(it) for name, it in scenes.items()}
    texts = {}
    if options.out is not None:
        texts[options.out / "recorded.csv"] = scores_csv(scores)
    if options.markdown is not None:
        pictures = {}
        for k, (scene, windows) in enumerate(scenes.items(), 1):
            made = {
                score.model: score.sample
                for score in scores
                if score.scene == scene and score.goal == "true"
            }
            pictures[scene] = f"{options.markdown.stem}_{k}.svg"
            texts[options.markdown.with_name(pictures[scene])] = draw_samples(
                sample_of(windows), made
            )
        texts[options.markdown] = scores_markdown(scores, overlaps, pictures)
    for path, text in texts.items():
        with atomic_write(path) as output:
            output.write(text.encode())
    print(
        scores_json(scores) if options.json else format_scores(scores, overlaps)
    )
    for path in texts:
        print(f"Wrote {path}", file=sys.stderr)
    return DONE


def _scene_name(file: Path, taken: Mapping[str, object]) -> str:
    """Returns a name of a recording that no other has."""
    return file.stem if file.stem not in taken else str(file)


def _write(
    outcomes: "list[Outcome]", options: argparse.Namespace
) -> list[Path]:
    """Writes the requested files, and returns their paths."""
    written: list[Path] = []
    if options.out is not None:
        from hunav_drake.systems.common.files import atomic_write
        from hunav_drake.trial.provenance import MakeValidationProvenance
        from hunav_drake.validation.page import WriteValidationPage
        from hunav_drake.validation.tables import numbers_csv, outcomes_csv

        provenance = MakeValidationProvenance(options.seed, options.quick)
        page = options.out / "validation.html"
        with input_errors():
            written.append(WriteValidationPage(outcomes, page, provenance))
            for name, text in (
                ("outcomes.csv", outcomes_csv(outcomes)),
                ("numbers.csv", numbers_csv(outcomes)),
            ):
                with atomic_write(options.out / name) as file:
                    file.write(text.encode())
                written.append(options.out / name)
    if options.markdown is not None:
        from hunav_drake.validation.page import WriteValidationMarkdown

        with input_errors():
            written.append(WriteValidationMarkdown(outcomes, options.markdown))
    return written
