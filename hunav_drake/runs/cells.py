"""The cells of a suite: a scenario with a planner and a setting."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import functools
import hashlib
import json
from pathlib import Path
import re
from typing import Any

from hunav_drake.runs.run_folders import recording_path
from hunav_drake.runs.run_row import cell_name
from hunav_drake.runs.suite import Suite, planner_overrides
from hunav_drake.runs.suite_checks import name_faults
from hunav_drake.scenario import (
    CheckScenario,
    Fault,
    LoadScenario,
    SaveScenario,
    Scenario,
    ScenarioError,
)
from hunav_drake.scenario.checks import check_begins_alone
from hunav_drake.scenario.fleet import planners_of, robot_parts
from hunav_drake.scenario.generate.kind import (
    ScenarioKind,
    draw_scenario,
    make_kind,
)
from hunav_drake.scenario.named_files import behavior_sha256, files_sha256
from hunav_drake.scenario.overrides import seed_change
from hunav_drake.scenario.population import has_recorded_people
from hunav_drake.scenario.randomness import drawn_by_seed, how_to_draw, is_own
from hunav_drake.scenario.writer import plain
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.common.suggest import shown
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.trial.leaving import why_nobody_leaves
from hunav_drake.trial.provenance import drawn_text, program_versions


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One scenario with one planner and one setting.

    Attributes:
        scenario: The name of the scenario.
        planner: The label of the planner.
        setting: The name of the setting; empty if there is only one.
        text: The scenario with both, as `SaveScenario` writes it.
        sha256: A hash of all that determines its runs, apart from the seed:
            the scenario, the content of files that it names, behavior trees,
            versions and the kind of machine.
        drawn: What its seeds draw: see `ReadRuns`.
        how_to_draw: How to make seeds differ, if they do not.
        kind: A kind of scenario with its changes, as JSON; each seed has a
            scenario of its own, and `text` is that of the first. Empty if all
            seeds have the same scenario.
        once: Whether one run is enough: its seeds draw nothing, and its
            planner is part of the package, so it is deterministic.
        relative: Whether its runs also have the relative metrics.
    """

    scenario: str
    planner: str
    setting: str
    text: str
    sha256: str
    drawn: str = ""
    how_to_draw: str = ""
    kind: str = ""
    once: bool = False
    relative: bool = False

    @property
    def name(self) -> str:
        """The name of the cell in messages, "crossing/dwb"."""
        return cell_name(self.scenario, self.planner, self.setting)

    def load(self, seed: int) -> Scenario:
        """Returns the scenario of a seed.

        Raises:
            ScenarioError: If it cannot be simulated.
            ValueError: If a file that it is read from is damaged.
        """
        given = [f"simulation.seed={seed}"]
        if not self.kind:
            return LoadScenario(data=self.text, overrides=given)
        about = json.loads(self.kind)
        text = _drawn_text(json.dumps(about["kind"]), seed)
        return LoadScenario(data=text, overrides=[*about["overrides"], *given])

    def numbers(self, recording: Recording, seed: int) -> dict[str, float]:
        """Returns the numbers that its kind of scenario has of a trial."""
        if not self.kind:
            return {}
        kind = make_kind(json.loads(self.kind)["kind"])
        return kind.numbers(recording, seed)


# A change that takes another planner, and what is wrong with it.
_PLANNER = re.compile(r"\s*planner(\.type)?\s*=")
_TWO_PLANNERS = Fault(
    "suite",
    0,
    "planners",
    "a change of `planner` or `planner.type` would replace them, under their"
    " names; leave out one of both",
)

_TWO_SEEDS = Fault(
    "suite",
    0,
    "overrides",
    "a change of `simulation.seed` would have no effect: `seeds` has the seeds"
    " of all runs, as in seeds: [3, 7]; leave it out",
)


def make_cells(suite: Suite, folder: Path | None = None) -> list[Cell]:
    """Returns all cells of a suite, after checking each of them.

    Args:
        suite: The suite.
        folder: The folder of relative paths of scenarios; by default the
            current folder.

    Raises:
        ScenarioError: It lists the faults of all scenarios, each once; or, if
            there are none, unknown names in the suite.
    """
    faults: dict[Fault, None] = {}
    cells: list[Cell] = []
    scenarios: list[Scenario] = []
    choices = [planner_overrides(choice) for choice in suite.planners]
    settings = dict(suite.settings) or {"": []}
    for entry in suite.scenarios:
        kind = None
        if not isinstance(entry, str):
            kind = _checked_kind(entry, suite, folder, faults)
            if kind is None:
                continue
        for label, keys in choices or [("", {})]:
            for setting, changes in settings.items():
                # JSON is YAML, on one line.
                planner = [f"planner={json.dumps(keys)}"] if keys else []
                overrides = [*planner, *suite.overrides, *changes]
                if keys and any(map(_PLANNER.match, overrides[1:])):
                    faults[_TWO_PLANNERS] = None
                    continue
                if seed_change(overrides):
                    faults[_TWO_SEEDS] = None
                try:
                    if kind is None:
                        loaded = LoadScenario(
                            filename=_find(str(entry), folder),
                            overrides=overrides,
                        )
                        scenario = CheckScenario(loaded)
                        cell = _make_cell(scenario, label, setting)
                    else:
                        cell = _make_drawn(kind, overrides, suite)
                        scenario = CheckScenario(LoadScenario(data=cell.text))
                        cell = replace(
                            cell,
                            planner=label or planners_of(scenario),
                            setting=setting,
                        )
                    check_begins_alone(scenario)
                except ScenarioError as error:
                    faults |= dict.fromkeys(error.faults)
                    continue
                if suite.relative:
                    if why := why_not_alone(scenario):
                        faults[Fault(cell.name, 0, "relative", why)] = None
                        continue
                    cell = replace(
                        cell,
                        sha256=cell_sha256(
                            cell.text, scenario, cell.kind, relative=True
                        ),
                        relative=True,
                    )
                cells.append(cell)
                scenarios.append(scenario)
    faults |= dict.fromkeys(_same_names(cells))
    # The names of invalid scenarios are unknown.
    faults |= {} if faults else dict.fromkeys(name_faults(suite, scenarios))
    if faults:
        raise ScenarioError(suite.name, faults)
    return cells


def _make_cell(scenario: Scenario, label: str, setting: str) -> Cell:
    text = SaveScenario(scenario)
    drawn = drawn_by_seed(scenario)
    return Cell(
        scenario=scenario.name,
        planner=label or planners_of(scenario),
        setting=setting,
        text=text,
        sha256=cell_sha256(text, scenario),
        drawn=drawn_text(drawn),
        how_to_draw="" if drawn else how_to_draw(scenario),
        once=not drawn
        and not any(
            is_own(part.scenario.planner) for part in robot_parts(scenario)
        ),
    )


def why_not_alone(scenario: Scenario) -> str:
    """Returns why a trial has no relative metrics; empty if it has."""
    if has_recorded_people(scenario):
        return "recorded people cannot be left out; leave out `relative`"
    return why_nobody_leaves(scenario)


def _checked_kind(
    kind: ScenarioKind,
    suite: Suite,
    folder: Path | None,
    faults: dict[Fault, None],
) -> ScenarioKind | None:
    """Returns a kind with all seeds drawn, and its files found, or None.

    The first fault of its seeds is added to the faults.
    """
    name = kind.name or name_of(kind)
    given: dict[str, Any] = {"name": name}
    own = str(getattr(kind, "folder", ""))
    if folder is not None and own:
        given["folder"] = str(folder / own)
    kind = replace(kind, **given)
    text = json.dumps(plain(kind))
    for seed in suite.seed_list(name):
        try:
            _drawn_text(text, seed)
        except ValueError as error:
            faults[Fault("suite", 0, "scenarios", str(error))] = None
            return None
    return kind


def _make_drawn(
    kind: ScenarioKind, overrides: Sequence[str], suite: Suite
) -> Cell:
    """Returns the cell of a kind, without the names of planner and setting."""
    seeds = suite.seed_list(kind.name)
    about = {"kind": plain(kind), "overrides": list(overrides)}
    cell = Cell(
        scenario=kind.name,
        planner="",
        setting="",
        text="",
        sha256="",
        drawn="world",
        kind=json.dumps(about),
    )
    first = replace(cell.load(seeds[0]), name=kind.name)
    text = SaveScenario(first)
    hashed = cell_sha256(text, first, cell.kind)
    return replace(cell, text=text, sha256=hashed)


def _drawn_text(kind: str, seed: int) -> str:
    """Returns the scenario of a seed of a kind, which is given as JSON.

    It is cached, as long as the files that it may be read from do not change.
    """
    stats = [(it, it.stat()) for it in make_kind(json.loads(kind)).files()]
    stamps = [(str(it), stat.st_mtime_ns, stat.st_size) for it, stat in stats]
    return _drawn_from(kind, seed, tuple(sorted(stamps)))


@functools.lru_cache(maxsize=1024)
def _drawn_from(kind: str, seed: int, stamps: object) -> str:
    del stamps
    made = make_kind(json.loads(kind))
    return SaveScenario(replace(draw_scenario(made, seed)[0], name=made.name))


def cell_sha256(
    text: str, scenario: Scenario, kind: str = "", *, relative: bool = False
) -> str:
    """Returns the hash of all that determines runs, apart from the seed.

    It does not depend on the processor, so machines can share a suite.

    Args:
        text: The scenario, as `SaveScenario` writes it.
        scenario: The same scenario.
        kind: As in `Cell`. The scenarios of seeds follow from it.
        relative: As in `Cell`.
    """
    if kind:
        about = json.loads(kind)
        files = make_kind(about["kind"]).files()
        about["kind"].pop("folder", None)
        about["files"] = [
            (it.name, hashlib.sha256(it.read_bytes()).hexdigest())
            for it in sorted(files)
        ]
        text = json.dumps(about)
        people = [
            HumanConfig(pose=(0.0, 0.0, 0.0), behavior=it)
            for it in sorted(about["kind"]["behaviors"])
        ]
        scenario = replace(scenario, humans=[*scenario.humans, *people])
    follows = (
        program_versions(),
        text,
        behavior_sha256(scenario),
        files_sha256(scenario),
        *["relative"] * relative,
    )
    return hashlib.sha256(json.dumps(follows).encode()).hexdigest()


def _find(entry: str, folder: Path | None) -> str:
    """Returns the path of a scenario's file, or its shipped name."""
    if folder is not None and (folder / entry).is_file():
        return str(folder / entry)
    return entry


def _same_names(cells: Sequence[Cell]) -> list[Fault]:
    seen: dict[str, str] = {}
    faults = []
    for cell in cells:
        # Their recordings are in one folder.
        name = recording_path(Path(), cell.name, 0).name.lower()
        if name in seen:
            message = (
                f"two cells are called {shown(cell.name)}"
                if seen[name] == cell.name
                else f"the names of the cells {shown(seen[name])} and"
                f" {shown(cell.name)} are too similar for file names"
            )
            message += (
                "; give each scenario a unique name, and each planner a unique"
                " label"
            )
            faults.append(Fault("suite", 0, "", message))
        seen[name] = cell.name
    return faults
