"""Commands on scenarios: `hunav list`, `new`, `check`, `schema`, ..."""

import argparse
import dataclasses
import json
import os
from pathlib import Path
import shlex
import sys
from typing import TYPE_CHECKING

from hunav_drake.commands.errors import (
    DONE,
    check_each,
    check_output,
    input_errors,
    write_output,
)
from hunav_drake.commands.options import (
    add_import_option,
    add_output_options,
    add_scenario_options,
    load_scenario,
    tell_doubts,
)
from hunav_drake.systems.common.input_error import InputError
from hunav_drake.systems.common.suggest import counted

if TYPE_CHECKING:
    from hunav_drake.scenario import Scenario
    from hunav_drake.systems.world.shapes import World


def add_list_options(listing: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav list`."""
    listing.set_defaults(function=_list)


def add_check_options(check: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav check`."""
    check.set_defaults(function=_check)
    check.add_argument(
        "scenario", nargs="+", help="a shipped scenario or a file"
    )
    check.add_argument(
        "--fix",
        action="store_true",
        help="first replace old words in the files by new ones",
    )
    add_scenario_options(check)
    add_import_option(check)


def add_schema_options(schema: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav schema`."""
    schema.set_defaults(function=_schema)
    add_output_options(schema)
    add_import_option(schema)


def add_import_options(importing: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav import`."""
    importing.description = (
        "Writes a scenario of HuNavSim's people, of recorded ones, or of a"
        " world of Gazebo."
    )
    importing.set_defaults(function=_import)
    importing.add_argument(
        "agents",
        type=Path,
        nargs="?",
        help="the agents.yaml of HuNavSim, or a world of Gazebo (.world, .sdf)",
    )
    _add_world_options(importing.add_argument_group("worlds of Gazebo"))
    _add_tracks_options(importing.add_argument_group("recorded people"))
    importing.add_argument(
        "--metrics", type=Path, help="the metrics.yaml of HuNavSim"
    )
    importing.add_argument(
        "--map",
        type=Path,
        help="the YAML file of the map, for ROS 2's map_server (default: the"
        " map that agents.yaml names, if it is in the same folder)",
    )
    for name in ("start", "goal"):
        importing.add_argument(
            f"--{name}",
            nargs=3,
            type=float,
            metavar=("X", "Y", "YAW"),
            help=f"the {name} of the robot, in meters and radians",
        )
    importing.add_argument(
        "--profile",
        choices=("default", "hunavsim"),
        default="default",
        help="hunavsim: people move as in HuNavSim, with all differences",
    )
    add_output_options(importing)


# Options that are for recorded people only, and for worlds of Gazebo, by the
# keys of their values.
_OF_TRACKS = {
    "--from": "start_time",
    "--to": "end_time",
    **{
        f"--{key}": key
        for key in ("format", "fps", "smooth", "on", "off", "unit", "mode")
    },
}
_OF_WORLDS = {"--model-path": "model_path", "--skip-missing": "skip_missing"}


def _add_world_options(group: "argparse._ArgumentGroup") -> None:
    """Adds the options of worlds of Gazebo."""
    group.add_argument(
        "--world",
        type=Path,
        metavar="FILE",
        help="a world of Gazebo, beside the people of an agents.yaml",
    )
    group.add_argument(
        "--model-path",
        nargs="+",
        default=[],
        metavar="DIR",
        help="folders of the models that it names",
    )
    group.add_argument(
        "--skip-missing",
        action="store_true",
        help="leave out the models and meshes that are not there",
    )


def _add_tracks_options(group: "argparse._ArgumentGroup") -> None:
    """Adds the options of recorded people, named like keys of `tracks`."""
    group.add_argument(
        "--tracks",
        type=Path,
        metavar="FILE",
        help="a file of recorded people, instead of agents.yaml: see `hunav"
        " tracks`",
    )
    group.add_argument("--format", metavar="NAME", help="its format")
    for name, word, text in (
        ("--fps", "N", "frames per second, where the file does not say"),
        ("--from", "T", "the time at which the trial begins, in seconds"),
        ("--to", "T", "the time at which the replay ends, in seconds"),
        ("--smooth", "SIGMA", "noise to take out, in m; 0: as estimated"),
        ("--on", "D", "distance of a hand-over, in meters (default: 2)"),
        ("--off", "D", "distance of the way back, in meters (default: 3)"),
    ):
        key = {"--from": "start_time", "--to": "end_time"}.get(name, name[2:])
        group.add_argument(name, dest=key, type=float, metavar=word, help=text)
    group.add_argument("--unit", metavar="U", help="m, cm or mm")
    group.add_argument(
        "--mode",
        choices=("blind", "hand_over", "reactive"),
        help="whether people react to the robot (default: hand_over, near it)",
    )


def add_new_options(new: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav new`."""
    new.description = (
        "Writes a small scenario with comments. It is valid: change it, and"
        " find errors with `hunav check`."
    )
    new.set_defaults(function=_new)
    new.add_argument(
        "name",
        type=Path,
        help="the file to write; .yaml is added if it is missing",
    )
    new.add_argument(
        "--template",
        metavar="NAME",
        default="corridor",
        help="the template: corridor (default), crossing, office, cafe or room",
    )
    new.add_argument(
        "--force", action="store_true", help="overwrite an existing file"
    )


def add_completion_options(completion: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav completion`."""
    completion.description = (
        "Prints a script for a shell. It needs shtab: pip install"
        " 'hunav_drake[completion]'."
    )
    completion.set_defaults(function=_completion)
    completion.add_argument("shell", choices=("bash", "zsh", "fish"))


def _list(options: argparse.Namespace) -> int:
    from hunav_drake.scenario import ListScenarios

    scenarios = ListScenarios()
    width = max(map(len, scenarios))
    for name, description in scenarios.items():
        print(f"{name:{width}}  {description}")
    return DONE


def _check(options: argparse.Namespace) -> int:
    from hunav_drake.scenario.fleet import planners_of
    from hunav_drake.scenario.population import num_people
    from hunav_drake.scenarios import shipped_names

    def describe(name: str) -> str:
        is_shipped = name in shipped_names() and not Path(name).is_file()
        if options.fix and not is_shipped:
            _fix(Path(name))
        scenario = load_scenario(name, options, ways=True)
        robots = len(scenario.robots)
        sound[name] = scenario
        return (
            f"{counted(num_people(scenario), 'person', 'people')},"
            f" {_describe_world(scenario.world)},"
            + (f" {robots} robots," if robots > 1 else "")
            + f" planner {planners_of(scenario)}"
        )

    sound: dict[str, Scenario] = {}
    code = check_each(options.scenario, options, describe)
    for name, scenario in sound.items():
        tell_doubts(scenario, f"{name}: ")
    return code


def _fix(path: Path) -> None:
    """Replaces old words in a file by new ones, and prints which."""
    from hunav_drake.scenario import ScenarioError
    from hunav_drake.scenario.old_words import renewed_text
    from hunav_drake.systems.common.files import atomic_write

    with input_errors(ScenarioError, place=path):
        content = path.read_bytes()
        new, counts = renewed_text(content, str(path))
        if not counts:
            return
        with atomic_write(path) as file:
            file.write(new)
    replaced = ", ".join(f"{old!r} {count}" for old, count in counts.items())
    print(f"{path}: wrote 'type' for old words: {replaced}")


def _describe_world(world: "World") -> str:
    words = [counted(len(world.walls), "wall")]
    if world.furniture:
        words.append(counted(len(world.furniture), "piece") + " of furniture")
    if world.map:
        words.append("a map")
    if world.models:
        words.append(counted(len(world.models), "model"))
    return ", ".join(words)


def _schema(options: argparse.Namespace) -> int:
    from hunav_drake.scenario.json_schema import scenario_json_schema

    text = json.dumps(scenario_json_schema(), indent=2)
    done = f"Wrote the schema to {options.output}"
    return write_output(f"{text}\n", options, done)


def _import_tracks(options: argparse.Namespace) -> int:
    from hunav_drake.scenario import SaveScenario
    from hunav_drake.scenario.recorded_scenario import import_tracks
    from hunav_drake.systems.people.track_config import TracksConfig

    if options.metrics or options.map or options.profile != "default":
        raise InputError(
            "--metrics, --map and --profile are for an agents.yaml of HuNavSim;"
            " leave them out with --tracks"
        )
    given = {
        "format": options.format,
        "fps": options.fps,
        "unit": options.unit,
        "start": options.start_time,
        "end": options.end_time,
        "smooth": options.smooth,
        "mode": options.mode,
        "on": options.on,
        "off": options.off,
    }
    given = {key: it for key, it in given.items() if it is not None}
    start, goal = options.start, options.goal
    with input_errors(ValueError, place=options.tracks):
        config = TracksConfig(file=str(options.tracks), **given)
        scenario = import_tracks(config, start=start, goal=goal)
    # Paths are relative to the file that is written.
    folder = options.output.parent if options.output else "."
    tracks = scenario.population.tracks or config
    tracks.file = os.path.relpath(options.tracks, folder)
    done = f"Wrote {scenario.description} to {options.output}"
    return write_output(SaveScenario(scenario), options, done)


def _import(options: argparse.Namespace) -> int:
    if options.agents and options.agents.suffix.lower() in (".world", ".sdf"):
        if options.world is not None:
            raise InputError("give one world of Gazebo; leave --world out")
        options.world, options.agents = options.agents, None
    people = (options.agents, options.tracks)
    if None not in people or (people == (None, None) and not options.world):
        raise InputError(
            "give either the agents.yaml of HuNavSim, or --tracks FILE with"
            " recorded people, or a world of Gazebo"
        )
    for is_there, names, whose in (
        (options.tracks, _OF_TRACKS, "recorded people: give --tracks FILE"),
        (options.world, _OF_WORLDS, "worlds of Gazebo: give one"),
    ):
        asked = [
            it
            for it, key in names.items()
            if getattr(options, key) not in (None, [])
            and getattr(options, key) is not False
        ]
        if asked and not is_there:
            verb, these = ("is", "it") if len(asked) == 1 else ("are", "them")
            raise InputError(
                f"{', '.join(asked)} {verb} for {whose}, or leave {these} out"
            )
    if options.tracks is not None:
        if options.world:
            raise InputError(
                "--tracks goes with no world of Gazebo; add it to the file that"
                " is written, as world: {models: [{file: ...}]}"
            )
        return _import_tracks(options)
    from hunav_drake.hunavsim.agents_yaml import ImportAgents
    from hunav_drake.hunavsim.import_notes import LeftOut, group_notes
    from hunav_drake.scenario import SaveScenario, ScenarioError
    from hunav_drake.systems.common.models.apart import ModelFault
    from hunav_drake.systems.common.plain_errors import ConfigError
    from hunav_drake.systems.people.behavior_choice import is_path

    notes: list[str] = []
    places = {"start": options.start, "goal": options.goal}
    given = {key: it for key, it in places.items() if it is not None}
    with input_errors(ScenarioError, ConfigError):
        left_out: list[LeftOut] = []
        scenario = None
        if options.agents is not None:
            scenario = ImportAgents(
                options.agents,
                metrics_filename=options.metrics,
                map_filename=options.map,
                profile=options.profile,
                left_out=left_out,
            )
        if options.world is not None:
            try:
                scenario = _in_world(options, scenario, notes)
            except ModelFault as fault:
                raise InputError(f"{options.world}: {fault}") from fault
        assert scenario is not None
        robot = dataclasses.replace(scenario.robot, **given)
    # Paths are relative to the file that is written.
    folder = options.output.parent if options.output else "."
    world = scenario.world
    if world.map:
        relative = os.path.relpath(world.map, folder)
        world = dataclasses.replace(world, map=relative)
    for model in world.models:
        model.file = os.path.relpath(model.file, folder)
        model.model_path = [
            os.path.relpath(it, folder) for it in model.model_path
        ]
    for human in scenario.humans:
        if isinstance(human.behavior, str) and is_path(human.behavior):
            human.behavior = os.path.relpath(human.behavior, folder)
    scenario = dataclasses.replace(scenario, robot=robot, world=world)
    for line in [*notes, *group_notes(left_out)]:
        print(line, file=sys.stderr)
    if len(given) < len(places):
        missing = [key for key in places if key not in given]
        stands = "" if options.goal else ", and without a goal it stands still"
        give = " and ".join(f"--{it} X Y YAW" for it in missing)
        keys = " and ".join(f"robot.{it}" for it in missing)
        print(
            f"the robot: its {' and '.join(missing)} are not in the files"
            f"{stands}; add {give}, or set {keys}",
            file=sys.stderr,
        )
    parts = [counted(len(scenario.humans), "person", "people")]
    parts += ["their map"] * bool(world.map) + ["a world"] * bool(world.models)
    done = f"Wrote {' and '.join(parts)} to {options.output}"
    return write_output(SaveScenario(scenario), options, done)


def _in_world(
    options: argparse.Namespace, people: "Scenario | None", notes: list[str]
) -> "Scenario":
    """Returns a scenario in a world of Gazebo, perhaps with other people."""
    from hunav_drake.scenario.gazebo_import import import_world

    if people is None and (
        options.metrics or options.map or options.profile != "default"
    ):
        raise InputError(
            "--metrics, --map and --profile are for an agents.yaml of HuNavSim;"
            " give one, and the world by --world"
        )
    scenario = import_world(
        options.world, options.model_path, options.skip_missing, notes
    )
    if people is None:
        return scenario
    if scenario.humans:
        notes.append(
            f"{len(scenario.humans)} actors of {options.world.name}: those of"
            f" {options.agents.name} are taken instead"
        )
    world = dataclasses.replace(people.world, models=scenario.world.models)
    return dataclasses.replace(people, world=world)


def _new(options: argparse.Namespace) -> int:
    from hunav_drake.scenario.templates import template_text
    from hunav_drake.systems.common.files import atomic_write

    with input_errors(ValueError):
        text = template_text(options.template)
    path: Path = options.name
    if path.name in ("", ".."):
        raise InputError(f"{path}: give the file a name, such as my_office")
    if path.suffix not in (".yaml", ".yml"):
        path = path.with_name(f"{path.name}.yaml")
    check_output(path, options.force)
    text = text.replace("FILE", shlex.quote(path.name))
    with input_errors(place=path), atomic_write(path) as file:
        file.write(text.encode())
    print(f"Wrote {path}. Now: hunav run {shlex.quote(str(path))}")
    return DONE


def _completion(options: argparse.Namespace) -> int:
    try:
        import shtab
    except ImportError as error:
        raise InputError(
            "completion needs shtab: pip install 'hunav_drake[completion]'"
        ) from error
    whole = options.make_parser()
    _name_choices(whole, is_bash=options.shell == "bash")
    print(shtab.complete(whole, shell=options.shell))
    return DONE


def _name_choices(whole: argparse.ArgumentParser, is_bash: bool) -> None:
    """Sets as choices the names that a shell completes.

    They are too narrow for parsing: parts that users register have names, too.
    """
    from hunav_drake.runs import ListSuites
    from hunav_drake.scenario import ListScenarios
    from hunav_drake.scenario.templates import list_templates
    from hunav_drake.systems.crowd.motion_model import MOTION_MODELS
    from hunav_drake.systems.evaluation.metrics import METRICS
    from hunav_drake.systems.planning import PLANNERS
    from hunav_drake.validation.cases import CASES

    names: dict[str, list[str]] = {
        "planner": list(PLANNERS),
        "template": list(list_templates()),
        "model": list(MOTION_MODELS),
        "case": list(CASES),
        "metrics": list(METRICS),
    }
    if is_bash:
        # Bash also completes files, where no name fits.
        names |= {
            "scenario": list(ListScenarios()),
            "suite": list(ListSuites()),
        }
    todo = [whole]
    while todo:
        parser = todo.pop()
        for action in parser._actions:
            if isinstance(action, argparse._SubParsersAction):
                todo += action.choices.values()
            elif parser.prog.endswith("metrics show") and action.dest == "name":
                action.choices = names["metrics"]
            elif action.dest in names and action.type is not Path:
                action.choices = names[action.dest]
