"""The commands `hunav list`, `check`, `schema` and `import`."""

import argparse
import json
from pathlib import Path
import sys
from typing import TYPE_CHECKING, Any

from hunav_drake.commands.errors import (
    DONE,
    check_each,
    input_errors,
    write_output,
)
from hunav_drake.commands.options import (
    add_import_option,
    add_output_options,
    add_scenario_options,
    load_scenario,
)

if TYPE_CHECKING:
    from hunav_drake.systems.world.shapes import World


def add_scenario_commands(commands: Any) -> None:
    """Adds `hunav list`, `check`, `schema` and `import`."""
    listing = commands.add_parser("list", help="list the shipped scenarios")
    listing.set_defaults(function=_list)

    check = commands.add_parser("check", help="check scenario files")
    check.set_defaults(function=_check)
    check.add_argument(
        "scenario", nargs="+", help="a shipped scenario or a file"
    )
    add_scenario_options(check)
    add_import_option(check)

    schema = commands.add_parser(
        "schema", help="show the JSON schema of scenarios, for editors"
    )
    schema.set_defaults(function=_schema)
    add_output_options(schema)
    add_import_option(schema)

    importing = commands.add_parser(
        "import", help="convert an agents.yaml of HuNavSim to a scenario"
    )
    importing.set_defaults(function=_import)
    importing.add_argument(
        "agents", type=Path, help="the agents.yaml of HuNavSim"
    )
    importing.add_argument(
        "--metrics", type=Path, help="the metrics.yaml of HuNavSim"
    )
    importing.add_argument(
        "--map",
        type=Path,
        help="the YAML file of the map, for ROS 2's map_server; by default the"
        " one that the agents.yaml names, if it is beside it",
    )
    importing.add_argument(
        "--profile",
        choices=("default", "hunavsim"),
        default="default",
        help="hunavsim: people move as in HuNavSim, with all that differs",
    )
    add_output_options(importing)


def _list(options: argparse.Namespace) -> int:
    from hunav_drake.scenario import ListScenarios

    scenarios = ListScenarios()
    width = max(map(len, scenarios))
    for name, description in scenarios.items():
        print(f"{name:{width}}  {description}")
    return DONE


def _check(options: argparse.Namespace) -> int:
    from hunav_drake.systems.common.registry import name_of

    def describe(name: str) -> str:
        scenario = load_scenario(name, options, ways=True)
        people = len(scenario.humans) + scenario.population.number
        return (
            f"{people} {'person' if people == 1 else 'people'},"
            f" {_describe_world(scenario.world)},"
            f" planner {name_of(scenario.planner)}"
        )

    return check_each(options.scenario, options, describe)


def _describe_world(world: "World") -> str:
    words = [f"{len(world.walls)} walls"]
    if world.furniture:
        words.append(f"{len(world.furniture)} pieces of furniture")
    if world.map:
        words.append("a map")
    if world.models:
        words.append(f"{len(world.models)} models")
    return ", ".join(words)


def _schema(options: argparse.Namespace) -> int:
    from hunav_drake.scenario.json_schema import scenario_json_schema

    text = json.dumps(scenario_json_schema(), indent=2)
    done = f"Wrote the schema to {options.output}"
    return write_output(f"{text}\n", options, done)


def _import(options: argparse.Namespace) -> int:
    from hunav_drake.hunavsim.agents_yaml import ImportAgents
    from hunav_drake.scenario import SaveScenario, ScenarioError
    from hunav_drake.scenario.error import Fault

    with input_errors(ScenarioError):
        left_out: list[Fault] = []
        scenario = ImportAgents(
            options.agents,
            metrics_filename=options.metrics,
            map_filename=options.map,
            profile=options.profile,
            left_out=left_out,
        )
    for fault in left_out:
        print(fault, file=sys.stderr)
    print(
        "the robot: the files do not say where it is; set robot.start and"
        " robot.goal",
        file=sys.stderr,
    )
    done = (
        f"Wrote {len(scenario.humans)} people"
        f"{' and their map' if scenario.world.map else ''} to {options.output}"
    )
    return write_output(SaveScenario(scenario), options, done)
