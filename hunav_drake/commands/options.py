"""Options that several commands of `hunav` share, and examples of commands."""

import argparse
from collections.abc import Callable, Iterator, Sequence
import contextlib
import importlib.util
import json
from pathlib import Path
import sys
from typing import TYPE_CHECKING, Any

from hunav_drake.commands.errors import input_errors
from hunav_drake.systems.common.input_error import InputError
from hunav_drake.systems.common.suggest import did_you_mean

if TYPE_CHECKING:
    from hunav_drake.scenario import Scenario
    from hunav_drake.systems.scene.scene_config import Overlay


def add_import_option(parser: argparse.ArgumentParser) -> None:
    """Adds the option that imports user code."""
    parser.add_argument(
        "--import",
        dest="imports",
        action="append",
        # Without a default, it may come before or after a second word.
        default=argparse.SUPPRESS,
        metavar="MODULE",
        help="import your module or file.py that registers tree nodes, motion"
        " models, planners or metrics",
    )


def add_scenario_options(parser: argparse.ArgumentParser) -> None:
    """Adds the options that choose and change a scenario."""
    parser.add_argument(
        "--name", help="the scenario to use, if the file holds several"
    )
    parser.add_argument(
        "--set",
        dest="overrides",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="change a value of the scenario: robot.radius=0.3,"
        " humans[0].behavior=...",
    )


def add_trial_options(parser: argparse.ArgumentParser) -> None:
    """Adds the scenario of a trial, with its changes and its seed."""
    parser.add_argument(
        "scenario", help="a shipped scenario (see `hunav list`) or a file"
    )
    add_scenario_options(parser)
    parser.add_argument(
        "--seed",
        type=whole_number(0),
        help="the seed, instead of the scenario's",
    )


def add_executor_options(parser: argparse.ArgumentParser) -> None:
    """Adds the options that choose where trials are run."""
    parser.add_argument(
        "--workers",
        type=whole_number(1),
        help="the number of worker processes (default: one per processor)",
    )
    parser.add_argument(
        "--executor",
        choices=("processes", "dask"),
        default="processes",
        help="run trials in processes on this machine, or on a Dask cluster",
    )
    parser.add_argument(
        "--address", help="the address of the Dask scheduler, host:port"
    )


@contextlib.contextmanager
def run_executor(
    options: argparse.Namespace,
) -> Iterator[tuple[Any, int | None]]:
    """Yields an executor, or None for the workers of runs, and their number."""
    if options.executor != "dask":
        if options.address:
            raise InputError("--address goes with --executor dask")
        if options.workers == 1:
            # A separate process: if it dies, the suite continues.
            from hunav_drake.runs.worker_pool import WorkerPool

            with WorkerPool(1) as pool:
                yield pool, 1
        else:
            yield None, options.workers
        return
    if importlib.util.find_spec("distributed") is None:
        raise InputError(
            "--executor dask needs Dask: pip install 'hunav_drake[dask]'"
        )
    from hunav_drake.runs.cluster import ClusterError, connect

    if not options.address:
        raise InputError(
            "--executor dask needs --address HOST:PORT, the address of the"
            " scheduler"
        )
    try:
        with connect(options.address) as (executor, count):
            yield executor, options.workers or count
    except ClusterError as error:
        raise InputError(f"--address {options.address}: {error}") from error


def overlay_names(text: str) -> list["Overlay"]:
    """Returns the overlays of an option: a list, "all" or "none"."""
    from hunav_drake.systems.scene.scene_config import OVERLAYS

    if text in ("all", "none"):
        return list(OVERLAYS) if text == "all" else []
    names = [name.strip() for name in text.split(",")]
    for name in names:
        if name not in OVERLAYS:
            raise argparse.ArgumentTypeError(
                f"there is no overlay {name!r}{did_you_mean(name, OVERLAYS)};"
                f" valid: {', '.join(OVERLAYS)}, or all, or none"
            )
    return [overlay for overlay in OVERLAYS if overlay in names]


def add_format_option(parser: argparse.ArgumentParser) -> None:
    """Adds the option for the format of the files that `--out` writes."""
    parser.add_argument(
        "--format",
        choices=("csv", "hunav"),
        default="csv",
        help="hunav: also write the text files of HuNavSim",
    )


def add_output_options(parser: argparse.ArgumentParser) -> None:
    """Adds the options for the output file of a command."""
    parser.add_argument(
        "-o", "--output", type=Path, help="the file to write (default: print)"
    )
    parser.add_argument(
        "--force", action="store_true", help="overwrite an existing file"
    )


def whole_number(least: int, end: str = "2^63") -> Callable[[str], int]:
    """Returns a parser of whole numbers from `least`, below `end`."""
    limit = 2**63 if end == "2^63" else int(end)

    def parse(text: str) -> int:
        if not text.isdecimal() or not least <= int(text) < limit:
            raise argparse.ArgumentTypeError(
                f"must be a whole number in [{least}, {end}), got {text!r}"
            )
        return int(text)

    return parse


@contextlib.contextmanager
def progress_bar(
    unit: str, quiet: bool = False
) -> Iterator[tuple[Any, Callable[[int, int], None]]]:
    """Yields a progress bar, and a function that shows done and total.

    It is shown only if the output is a terminal.
    """
    from tqdm import tqdm

    disable = True if quiet else None
    with tqdm(unit=f" {unit}", disable=disable, leave=False) as bar:

        def show(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        yield bar, show


def load_matplotlib() -> None:
    """Loads Matplotlib without the texts on setters, a third of its time.

    They are part of its docstrings, which no command shows.
    """
    import matplotlib.artist

    matplotlib.artist.kwdoc = lambda _: ""
    import matplotlib.figure


def load_scenario(
    scenario: str,
    options: Any,
    more: Sequence[str] = (),
    *,
    ways: bool = False,
    planner: str | None = None,
) -> "Scenario":
    """Loads a scenario, with the changes of the options.

    A `planner` replaces that of the scenario, with its parameters, before
    other changes, as in a suite. The changes `more` are applied last; with
    `ways`, all goals must be reachable. Errors in the scenario raise
    InputError.
    """
    from hunav_drake.scenario import LoadScenario, ScenarioError

    # A user's planner, module:Class, may be in the current folder.
    if str(Path.cwd()) not in sys.path:
        sys.path.append(str(Path.cwd()))
    with input_errors(ScenarioError):
        return LoadScenario(
            filename=scenario,
            scenario_name=options.name,
            overrides=[
                *([f"planner={json.dumps(planner)}"] if planner else []),
                *options.overrides,
                *more,
            ],
            ways=ways,
        )


def tell_doubts(scenario: "Scenario", place: str = "") -> None:
    """Prints notes on a valid scenario that may not be what the user wants."""
    from hunav_drake.scenario.fleet import robot_parts
    from hunav_drake.scenario.geometry import world_losses
    from hunav_drake.scenario.population import people_who_never_come
    from hunav_drake.scenario.randomness import is_own, same_for_all_seeds

    notes = [same_for_all_seeds(scenario)]
    for i, (name, alone) in enumerate(robot_parts(scenario)):
        if alone.robot.goal is None and not is_own(alone.planner):
            robot = f"robots[{i}].robot" if name else "robot"
            duration = f"{scenario.simulation.duration:g} s"
            notes.append(
                f"the robot {name}".strip() + " has no goal, so it stands still"
                f" for all {duration}; set {robot}.goal, as in --set"
                f" '{robot}.goal=[5, 0, 0]'"
            )
    notes.append(people_who_never_come(scenario))
    notes += world_losses(scenario.world)
    for note in filter(None, notes):
        print(f"hunav: note: {place}{note}", file=sys.stderr)


# An example of each command.
EXAMPLES = {
    "run": "hunav run passing --planner pursuit --seed 1 --out results",
    "list": "hunav list",
    "check": "hunav check passing --set robot.radius=0.3",
    "schema": "hunav schema -o scenario.schema.json",
    "import": "hunav import agents.yaml --profile hunavsim -o mine.yaml",
    "tracks": "hunav tracks zara01.txt --period 0.1 -o zara01.csv",
    "fit": "hunav fit zara01.txt --free social_factor,gamma -o people.yaml",
    "new": "hunav new mine --template crossing",
    "generate": "hunav generate office --difficulty 0.7 -o mine.yaml",
    "evaluate": "hunav evaluate recording.npz --metrics goal path --json",
    "situations": "hunav situations recording.npz --csv",
    "branch": "hunav branch crossing --at 4 --planner mppi --robot gone",
    "who": "hunav who crossing --until 40 --shapley 40",
    "metrics": "hunav metrics",
    "metrics show": "hunav metrics show path_length",
    "report": "hunav report results",
    "render": "hunav render results/runs/passing_pursuit_1 -o film.gif",
    "export": "hunav export results/runs/passing_pursuit_1 --mcap",
    "bridge": "hunav bridge crossing --real-time",
    "tree": "hunav tree show regular",
    "tree show": "hunav tree show regular",
    "tree check": "hunav tree check regular curious",
    "tree convert": "hunav tree convert regular -o regular_v4.xml",
    "edit": "hunav edit mine.yaml",
    "bench": "hunav bench standard --seeds 2 --out results",
    "falsify": "hunav falsify space.yaml --planner dwb --out failures",
    "risk": "hunav risk crossing --planner dwb --set crowd.decisions={}",
    "differences": "hunav differences --left",
    "validate": "hunav validate --case corridor_time --quick",
    "doctor": "hunav doctor",
    "completion": 'eval "$(hunav completion bash)"',
}

# Hints after an interrupt. Files are written in one piece, so none is damaged.
AFTER_INTERRUPT = {
    "run": "nothing was written of this run; run it again",
    "evaluate": "no run was written; the same command writes it",
    "bench": "finished runs are kept; the same command continues from there",
    "falsify": "finished runs are kept; the same command continues from there",
    "risk": "with --out, finished runs are kept, and the same command goes on",
    "validate": "nothing was written; --case and --model choose fewer cases",
    "render": "no film was written; --from and --to film a part",
    "export": "no bag was written; the same command writes it",
    "bridge": "nothing was written of this run; run it again",
    "report": "no report was written; run it again",
}
