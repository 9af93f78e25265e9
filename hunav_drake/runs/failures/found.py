"""The failures that a search has found, and their files."""

import csv
from dataclasses import dataclass, replace
import math
from pathlib import Path
import re
from typing import TYPE_CHECKING, Any, NamedTuple

from hunav_drake.runs.failures.scene_runs import (
    SceneCell,
    recording_sha256,
    scene_cell,
)
from hunav_drake.scenario import SaveScenario, Scenario
from hunav_drake.scenario.fleet import planners_of
from hunav_drake.scenario.population import num_people
from hunav_drake.systems.common.files import atomic_write
from hunav_drake.systems.evaluation.robustness import Failing
from hunav_drake.trial.context_file import SaveContext
from hunav_drake.trial.diagram import MakeTrialDiagram
from hunav_drake.trial.simulation import GetTrialResult, MakeTrialSimulator

if TYPE_CHECKING:
    import pandas as pd
else:
    import lazy_loader

    pd = lazy_loader.load("pandas")

# A Context is kept of this time before a failure, in seconds.
_BEFORE = 3.0

# The columns of the table of scenes.
_COLUMNS = (
    *("scene", "rho", "time", "person", "kind", "closing_speed", "people"),
    *("run", "found"),
)

# The files of a search, beside the scenes.
RANK, TRIED = "rank.csv", "tried.csv"

# The files of a scene: itself, a Context before its failure, and a replay.
_SUFFIXES = (".yaml", ".npz", ".html")


# Directions from a robot, counterclockwise, and closing speeds, in m/s.
_DIRECTIONS = (
    *("ahead", "ahead on the left", "on the left", "behind on the left"),
    *("behind", "behind on the right", "on the right", "ahead on the right"),
)
_PACES = ((0.0, "moving apart"), (0.5, "slowly"), (1.25, "at walking pace"))


class Scene(NamedTuple):
    """A minimal scene in which a planner fails.

    Attributes:
        scenario: The scene, with the planner.
        failing: How it fails.
        kind: Where the person is, and how fast both approach.
        run: The number of the run that found it.
        found: The number of runs that failed in this way.
    """

    scenario: Scenario
    failing: Failing
    kind: str
    run: int
    found: int

    @property
    def person(self) -> str:
        """The name of the person; empty for nobody."""
        index = self.failing.person
        if not 0 <= index < len(self.scenario.humans):
            return f"person {index + 1}" if index >= 0 else ""
        return self.scenario.humans[index].name


@dataclass(frozen=True)
class Failures:
    """What a search has found.

    Attributes:
        robustness: The kind of failure.
        scenes: The minimal scenes, the worst first.
        runs: For each run, its values by path, and how near it was.
        refused: The number of scenes without a result: they cannot be
            simulated, begin too near, or end with an error.
        fault: Why the first of these has none; empty if all have.
    """

    robustness: str
    scenes: list[Scene]
    runs: list[tuple[dict[str, Any], Failing]]
    refused: int
    fault: str = ""

    @property
    def num_failures(self) -> int:
        """The number of runs that failed."""
        return sum(it.robustness < 0 for _, it in self.runs)

    @property
    def first_failure(self) -> int | None:
        """The number of the first run that failed, from 0."""
        failed = [k for k, it in enumerate(self.runs) if it[1].robustness < 0]
        return failed[0] if failed else None

    @property
    def table(self) -> "pd.DataFrame":
        """A row for each scene, the worst first."""
        rows = [
            {
                "scene": scene_name(i),
                "rho": it.failing.robustness,
                "time": round(it.failing.time, 6),
                "person": it.person,
                "kind": it.kind,
                "closing_speed": it.failing.closing_speed,
                "people": num_people(it.scenario),
                "run": it.run,
                "found": it.found,
            }
            for i, it in enumerate(self.scenes)
        ]
        return pd.DataFrame(rows, columns=[*_COLUMNS])

    def cells(self) -> list[SceneCell]:
        """Returns the cells of the scenes, as for replays."""
        return [scene_cell(it.scenario, self.robustness) for it in self.scenes]

    def __repr__(self) -> str:
        return (
            f"<Failures: {self.num_failures} of {len(self.runs)} runs,"
            f" {len(self.scenes)} scenes>"
        )


def scene_name(index: int) -> str:
    """Returns the name of the file of a scene: 001, 002, ..."""
    return f"{index + 1:03d}"


def kind_of_failure(failing: Failing) -> str:
    """Returns where the person is, and how fast both approach, in words."""
    if math.isnan(failing.bearing):
        return "nobody"
    sector = round(failing.bearing / (math.pi / 4)) % 8
    pace = next((it for v, it in _PACES if failing.closing_speed < v), "fast")
    return f"{_DIRECTIONS[sector]}, {pace}"


# What a robot does in each kind of failure.
_DOES = {
    "collision": "runs into {person}",
    "freeze": "stands for 5 s, {person} nearest",
    "intrusion": "drives in the intimate space of {person} for 2 s",
    "timeout": "does not arrive",
}


def described(scene: Scene, robustness: str) -> Scenario:
    """Returns the scenario of a scene, with what happens as description."""
    does = _DOES.get(robustness, f"fails by {robustness}, near {{person}}")
    text = (
        f"With {planners_of(scene.scenario)}, the robot"
        f" {does.format(person=scene.person or 'nobody')} after"
        f" {scene.failing.time:.4g} s ({scene.kind})."
    )
    return replace(scene.scenario, description=text)


def write_failures(failures: Failures, folder: Path) -> None:
    """Writes the scenes and the tables of a search to a folder.

    Each scene gets a scenario file, 001.yaml, and the Context 3 s before the
    failure, 001.npz; rank.csv lists them with the hash of the states of robot
    and people, and tried.csv all runs. Those that the rank.csv of an earlier
    search lists are removed; other files stay.

    Raises:
        RuntimeError: If a scene does not fail as it did.
        OSError: If a file cannot be written.
    """
    for name in _listed_scenes(folder / RANK):
        for suffix in _SUFFIXES:
            (folder / f"{name}{suffix}").unlink(missing_ok=True)
    table, hashes = failures.table, []
    # (Before the scenes, so that they are listed even if one raises.)
    _write_table(folder / RANK, table)
    for i, scene in enumerate(failures.scenes):
        path = folder / f"{scene_name(i)}.yaml"
        SaveScenario(described(scene, failures.robustness), path)
        hashes.append(
            _run_again(scene, failures.robustness, path.with_suffix(".npz"))
        )
    _write_table(folder / RANK, table.assign(sha256=hashes))
    tried = [
        {"run": k, "rho": it.robustness, "time": round(it.time, 6)} | values
        for k, (values, it) in enumerate(failures.runs)
    ]
    _write_table(folder / TRIED, pd.DataFrame(tried))


def _listed_scenes(rank: Path) -> list[str]:
    """Returns the names of the scenes in a table; none if there is no table."""
    if not rank.is_file():
        return []
    with rank.open(newline="", encoding="utf-8", errors="replace") as file:
        names = [row.get("scene") or "" for row in csv.DictReader(file)]
    return [it for it in names if re.fullmatch("[0-9]{3,}", it)]


def _run_again(scene: Scene, robustness: str, path: Path) -> str:
    """Runs a scene, saves a Context, and returns the hash of the states."""
    scenario = scene.scenario
    diagram = MakeTrialDiagram(scenario, drawn=False)
    simulator = MakeTrialSimulator(diagram)
    step = scenario.simulation.time_step
    before = max(0, round((scene.failing.time - _BEFORE) / step)) * step
    simulator.AdvanceTo(before)
    SaveContext(diagram, simulator.get_context(), path)
    simulator.AdvanceTo(scenario.simulation.duration)
    context = simulator.get_context()
    simulator.clear_monitor()
    recording = GetTrialResult(scenario, diagram, context).recording
    cell = scene_cell(scenario, robustness)
    again = cell.numbers(recording, scenario.simulation.seed)
    if again["robustness"] != scene.failing.robustness:
        raise RuntimeError(
            f"{path.stem}: the scene does not repeat itself: its robustness was"
            f" {scene.failing.robustness}, and is {again['robustness']}; does a"
            " planner of yours keep something from run to run?"
        )
    return recording_sha256(recording)


def _write_table(path: Path, table: "pd.DataFrame") -> None:
    with atomic_write(path) as file:
        file.write(table.to_csv(index=False).encode())
