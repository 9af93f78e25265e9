"""Runs of single scenes, on the workers and with the log of suites."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
import contextlib
import copy
from dataclasses import dataclass, replace
import hashlib
import json
import math
import os
from pathlib import Path
from typing import Any, Self, TypedDict, Unpack

import numpy as np

from hunav_drake.runs.cell_plan import CellPlan
from hunav_drake.runs.cells import Cell, cell_sha256
from hunav_drake.runs.code_hash import hash_code, hash_of_all
from hunav_drake.runs.run_log import RunLog, read_rows
from hunav_drake.runs.run_row import LOST, RunRow
from hunav_drake.runs.run_suite import Driver, absolute_imports
from hunav_drake.runs.suite import Suite
from hunav_drake.runs.tasks import Task, load_trials
from hunav_drake.runs.worker_pool import InlineExecutor, WorkerPool
from hunav_drake.scenario import SaveScenario, Scenario
from hunav_drake.scenario.building import build_scenario
from hunav_drake.scenario.checks import ALL_CHECKS
from hunav_drake.scenario.error import path_text
from hunav_drake.scenario.fleet import planners_of, robot_parts
from hunav_drake.scenario.randomness import drawn_by_seed
from hunav_drake.systems.common.files import atomic_write
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.robustness import (
    NO_FAILURE,
    Failing,
    robustness_of,
)
from hunav_drake.trial.provenance import drawn_text
from hunav_drake.trial.user_code import import_user_code

# What a folder of runs of scenes was made for.
_ABOUT = "search.json"

# The only metrics that are computed in a search: they do not affect a trial.
_METRICS = ("completed",)


class RunOptions(TypedDict, total=False):
    """Where scenes are run, and where their runs are kept; see `RunSuite`."""

    # A folder for the runs and the results, where runs are not repeated.
    out: str | Path | None

    # The number of processes; 1, the default, is this process, and 0 stands for
    # one for each processor.
    workers: int

    # An executor instead, such as that of a Dask client.
    executor: Executor | None

    # Modules and files that each worker imports first.
    imports: Sequence[str]

    # Whether to run all scenes again.
    fresh: bool

    # Called with the number of finished runs and that of all.
    progress: Callable[[int, int], object]


@dataclass(frozen=True, kw_only=True)
class SceneCell(Cell):
    """A scene, whose rows have the numbers of a kind of failure.

    Attributes:
        robustness: The name of that kind.
        duration: The time limit, in seconds.
    """

    robustness: str
    duration: float

    def numbers(self, recording: Recording, seed: int) -> dict[str, float]:
        """Returns the fields of `Failing`, and the `fingerprint`.

        That is a whole number that differs where recordings do.
        """
        del seed
        kind = robustness_of(self.robustness)
        # Of several robots, the one that is nearest to a failure counts.
        each = [
            kind.failing(robot.until_end(), self.duration)
            for robot in recording.robots
        ]
        found = min(each, key=lambda it: it.robustness)
        digest = recording_sha256(recording)
        named = {name: float(it) for name, it in found._asdict().items()}
        return {**named, "fingerprint": float(int(digest[:12], 16))}


def recording_sha256(recording: Recording) -> str:
    """Returns the hash of the states of the robot and the people."""
    digest = hashlib.sha256()
    for array in (recording.robot, recording.humans):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def failing_of(row: RunRow | None) -> Failing:
    """Returns how near the run of a row was to a failure.

    A scene that is no trial, or a run without a result, was as far as can be.
    """
    values = {} if row is None else row.metrics
    if "robustness" not in values:
        return Failing(NO_FAILURE, math.nan, -1, math.nan, math.nan)
    fields: Any = {name: values[name] for name in Failing._fields}
    return Failing(**{**fields, "person": int(fields["person"])})


def scene_cell(
    scenario: Scenario, robustness: str, setting: str = ""
) -> SceneCell:
    """Returns the cell of a checked scenario; by default it has its own name.

    Its text leaves out all metrics that a search does not need.
    """
    evaluator = replace(scenario.evaluator, metrics=list(_METRICS))
    scenario = replace(scenario, evaluator=evaluator)
    text = SaveScenario(scenario)
    sha256 = cell_sha256(text, scenario)
    return SceneCell(
        scenario=scenario.name,
        planner=planners_of(scenario),
        setting=setting or sha256[:12],
        text=text,
        sha256=sha256,
        drawn=drawn_text(drawn_by_seed(scenario)),
        robustness=robustness,
        duration=scenario.simulation.duration,
    )


def built_scene(data: Any, start_gap: float) -> Scenario | str:
    """Returns the scenario of plain data, or why it is not to be tried.

    That is if it cannot be simulated, or if somebody starts nearer to a robot
    than the gap, in meters.
    """
    scenario, findings = build_scenario(copy.deepcopy(data), ALL_CHECKS)
    if scenario is None:
        loc, message = findings[0].loc, findings[0].message
        return f"{path_text(data, loc)}: {message}"
    for part in robot_parts(scenario):
        robot = part.scenario.robot
        for human in scenario.humans:
            away = math.dist(human.pose[:2], robot.start[:2])
            gap = away - robot.radius - human.radius
            if gap < start_gap:
                return (
                    f"{human.name or 'somebody'} starts {max(gap, 0.0):.2g} m"
                    f" from the robot, nearer than require.start_gap"
                )
    return scenario


def _show_nothing(done: int, total: int) -> None:
    pass


class _Plan(CellPlan):
    """The plan of a scene, whose recordings nobody needs."""

    def next_task(self) -> Task | None:
        task = super().next_task()
        return None if task is None else replace(task, keep=None)


class SceneRuns:
    """Runs scenes, each only once, also if a search is started again.

    The results do not depend on the number of workers.
    """

    def __init__(
        self, about: Mapping[str, Any], **options: Unpack[RunOptions]
    ) -> None:
        """Prepares to run; `about` is all that a folder's runs are made for."""
        out = options.get("out")
        self._out = None if out is None else Path(out)
        self._fresh = options.get("fresh", False)
        self._executor = options.get("executor")
        self._workers = options.get("workers", 1) or os.cpu_count() or 1
        self._progress: Callable[[int, int], object] = options.get(
            "progress", _show_nothing
        )
        self._imports = absolute_imports(options.get("imports", ()))
        import_user_code(self._imports)
        self._code = hash_code(self._imports)
        self._about = {**about, "code": hash_of_all(self._code)}
        self._remote = () if self._executor is None else self._imports
        self._known: dict[tuple[str, int | None], RunRow] = {}
        self._stack = contextlib.ExitStack()
        self._log: RunLog | None = None
        self._is_warm = False
        self.done = 0

    def __enter__(self) -> Self:
        if self._out is not None:
            self._log = self._stack.enter_context(
                RunLog(self._out, fresh=self._fresh)
            )
            try:
                self._take_up(self._out)
            except BaseException:
                self._stack.close()
                raise
        if not self._known and self._executor is None and self._workers > 1:
            # There will be runs, so workers start while they are planned.
            for _ in range(self._workers):
                self._pool().submit(load_trials)
        return self

    def __exit__(self, *error: Any) -> None:
        self._stack.__exit__(*error)

    def _take_up(self, out: Path) -> None:
        """Takes up the runs of a folder.

        Raises:
            ValueError: If they were made for something else.
        """
        text = json.dumps(self._about, indent=2)
        path = out / _ABOUT
        rows = list(read_rows(out / "runs.jsonl"))
        if rows and (not path.is_file() or path.read_text() != text):
            raise ValueError(
                f"{out}: holds the runs of another search, or of other code:"
                " choose another folder, or --fresh, which keeps them as"
                " runs_old.jsonl"
            )
        with atomic_write(path) as file:
            file.write(text.encode())
        code = self._about["code"]
        self._known = {
            (row.sha256, row.seed): row
            for row in rows
            if row.end_reason != LOST and row.code_sha256 == code
        }

    def run(
        self, runs: Sequence[tuple[SceneCell, Sequence[int]]], total: int
    ) -> list[list[RunRow]]:
        """Runs scenes with their seeds; returns their rows in that order.

        Args:
            runs: Each a scene and its seeds; scenes may be equal.
            total: The number of runs that are expected in all.
        """
        wanted = {
            cell.name: (cell, tuple(seeds))
            for cell, seeds in runs
            if any((cell.sha256, it) not in self._known for it in seeds)
        }
        before = self.done

        def count(row: RunRow, *_: int) -> None:
            self._known[row.sha256, row.seed] = row
            self.done += 1
            self._progress(self.done, total)

        plans = [self._plan(*it) for it in wanted.values()]
        if plans:
            driver = Driver(self._pool(), plans, self._log, None, count)
            inline = isinstance(self._executor, InlineExecutor)
            window = 1 if inline else 2 * self._workers + 2
            driver.run(window, warm_up=not self._is_warm)
            self._is_warm = True
        self.done = before + sum(len(seeds) for _, seeds in runs)
        self._progress(self.done, total)
        return [
            [self._known[cell.sha256, it] for it in seeds]
            for cell, seeds in runs
        ]

    def _plan(self, cell: SceneCell, seeds: Iterable[int]) -> CellPlan:
        new = [it for it in seeds if (cell.sha256, it) not in self._known]
        suite = Suite(scenarios=[cell.scenario], seeds=new)
        # (Plans of scenes that draw nothing have one seed.)
        return _Plan(cell, suite, self._code, self._remote)

    def _pool(self) -> Executor:
        """Returns the executor, which is started when it is first needed."""
        if self._executor is None:
            pool: Any = InlineExecutor()
            if self._workers > 1:
                pool = WorkerPool(self._workers, self._imports)
            self._executor = self._stack.enter_context(pool)
        return self._executor
