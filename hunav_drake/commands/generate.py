"""The command `hunav generate`."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hunav_drake.commands.errors import DONE, input_errors, write_output
from hunav_drake.commands.options import add_import_option, whole_number
from hunav_drake.systems.common.input_error import InputError

if TYPE_CHECKING:
    from hunav_drake.scenario.generate.kind import ScenarioKind


def add_generate_options(generate: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav generate`."""
    generate.description = (
        "Writes scenarios that are drawn from a seed: world, people and robot."
        " All goals can be reached."
    )
    generate.set_defaults(function=_generate)
    generate.add_argument(
        "kind",
        help="field, corridors, rooms, office, or barn, a world of the BARN"
        " Challenge",
    )
    generate.add_argument(
        "--difficulty",
        type=float,
        metavar="D",
        help="from 0, spacious, to 1, cluttered (default: 0.5)",
    )
    generate.add_argument(
        "--seed",
        type=whole_number(0),
        default=0,
        help="the seed (default: 0); of barn, the number of the world",
    )
    generate.add_argument(
        "--seeds",
        type=whole_number(1, "100000"),
        metavar="N",
        help="write N scenarios, from --seed on, to the folder of -o",
    )
    generate.add_argument(
        "--people", type=int, metavar="N", help="the number of people"
    )
    generate.add_argument(
        "--behaviors",
        type=_weights,
        metavar="NAME=WEIGHT,...",
        help="the behaviors of people: regular=0.7,scared=0.3",
    )
    generate.add_argument(
        "--worlds",
        dest="folder",
        metavar="DIR",
        help="the folder of the worlds of barn",
    )
    generate.add_argument(
        "--set",
        dest="overrides",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="another option of the kind: robot_radius=0.25",
    )
    generate.add_argument(
        "-o",
        "--output",
        type=Path,
        help="the file to write, or the folder (default: print)",
    )
    generate.add_argument(
        "--force", action="store_true", help="overwrite existing files"
    )
    add_import_option(generate)


def _weights(text: str) -> dict[str, float]:
    try:
        pairs = [part.rsplit("=", 1) for part in text.split(",")]
        return {name.strip(): float(weight) for name, weight in pairs}
    except ValueError:
        raise argparse.ArgumentTypeError(
            "must be names of behaviors with weights, as in"
            f" regular=0.7,scared=0.3, got {text!r}"
        ) from None


def _kind(options: argparse.Namespace) -> "ScenarioKind":
    from hunav_drake.scenario.generate.kind import make_kind
    from hunav_drake.scenario.yaml_source import parse_yaml

    data: dict[str, Any] = {"type": options.kind}
    for change in options.overrides:
        key, sign, value = change.partition("=")
        if not sign:
            raise InputError(f"--set must be KEY=VALUE, got {change!r}")
        data[key.strip()] = parse_yaml(value, name=f"--set {key}").plain()
    for name in ("difficulty", "people", "behaviors", "folder"):
        if getattr(options, name) is not None:
            data[name] = getattr(options, name)
    return make_kind(data)


def _generate(options: argparse.Namespace) -> int:
    from hunav_drake.scenario import SaveScenario
    from hunav_drake.scenario.generate.kind import draw_scenario

    folder: Path | None = options.output
    if options.seeds and (
        folder is None or (folder.suffix and not folder.is_dir())
    ):
        raise InputError("--seeds needs a folder for its files: -o FOLDER")
    with input_errors(ValueError):
        kind = _kind(options)
    seeds = range(options.seed, options.seed + (options.seeds or 1))
    for seed in seeds:
        with input_errors(ValueError):
            scenario, draws = draw_scenario(kind, seed)
        if folder is not None and (options.seeds or folder.is_dir()):
            options.output = folder / f"{scenario.name}.yaml"
            folder.mkdir(exist_ok=True)
        text = f"# hunav generate {options.kind}, seed {seed}\n"
        text += SaveScenario(scenario)
        number = f"{draws} draw{'s' * (draws > 1)}"
        done = f"Wrote {options.output}: {scenario.description} ({number})"
        write_output(text, options, done)
    return DONE
