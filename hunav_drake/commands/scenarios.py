"""The commands `hunav list`, `check`, `schema` and `import`."""

import argparse
import json
from pathlib import Path
import sys
from typing import Any

from hunav_drake.commands.errors import (
    BAD_INPUT,
    DONE,
    InputError,
    check_new,
    print_import_hint,
)
from hunav_drake.commands.options import (
    add_import_option,
    add_scenario_options,
    load_scenario,
)


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
    schema.add_argument(
        "-o", "--output", type=Path, help="the file to write, else it is shown"
    )
    schema.add_argument(
        "--force", action="store_true", help="write over an existing file"
    )
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
        "-o",
        "--output",
        type=Path,
        help="the file to write; by default printed",
    )
    importing.add_argument(
        "--force", action="store_true", help="overwrite an existing file"
    )


def _list(options: argparse.Namespace) -> int:
    from hunav_drake.scenario import ListScenarios

    scenarios = ListScenarios()
    width = max(map(len, scenarios))
    for name, description in scenarios.items():
        print(f"{name:{width}}  {description}")
    return DONE


def _check(options: argparse.Namespace) -> int:
    from hunav_drake.systems.common.registry import name_of

    code = DONE
    for name in options.scenario:
        try:
            scenario = load_scenario(name, options)
        except InputError as error:
            print(error, file=sys.stderr)
            print_import_hint(error, options)
            code = BAD_INPUT
        else:
            people = len(scenario.humans)
            print(
                f"{name}: ok ({people} {'person' if people == 1 else 'people'},"
                f" {len(scenario.world.walls)} walls,"
                f" planner {name_of(scenario.planner)})"
            )
    return code


def _schema(options: argparse.Namespace) -> int:
    from hunav_drake.scenario.json_schema import scenario_json_schema
    from hunav_drake.systems.common.files import atomic_write

    output: Path | None = options.output
    text = json.dumps(scenario_json_schema(), indent=2)
    if output is None:
        print(text)
        return DONE
    check_new(output, force=options.force)
    try:
        with atomic_write(output) as file:
            file.write(f"{text}\n".encode())
    except OSError as error:
        raise InputError(f"{output}: {error.strerror}") from error
    print(f"Wrote the schema to {output}")
    return DONE


def _import(options: argparse.Namespace) -> int:
    from hunav_drake.hunavsim.agents_yaml import ImportAgents
    from hunav_drake.scenario import SaveScenario, ScenarioError

    output: Path | None = options.output
    if output is not None:
        check_new(output, force=options.force)
    try:
        scenario = ImportAgents(
            options.agents, metrics_filename=options.metrics
        )
        text = SaveScenario(scenario, output)
    except ScenarioError as error:
        raise InputError(str(error)) from error
    except OSError as error:
        raise InputError(f"{output}: {error.strerror}") from error
    if output is None:
        print(text, end="")
    else:
        print(f"Wrote {len(scenario.humans)} people to {output}")
    return DONE
