"""Tasks of workers: runs of one cell, one seed after another."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
import functools
import importlib
import math
import platform
import threading
import time
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np

from hunav_drake.runs.cells import Cell, cell_sha256
from hunav_drake.runs.code_hash import CodeHashes, code_sha256, hash_of_all
from hunav_drake.runs.run_row import (
    ERROR,
    FAILED,
    MetricFacts,
    RunRow,
    make_row,
)
from hunav_drake.systems.common.input_error import InputError
from hunav_drake.systems.common.layout import RADIUS, VX, VY, X, Y
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.trial.provenance import program_versions
from hunav_drake.trial.user_code import fault_of_user_code, import_user_code

if TYPE_CHECKING:
    from hunav_drake.trial.result import TrialResult

# The personal space of a person, in meters (Hall 1966).
_NEAR = 1.2


@dataclass(frozen=True, kw_only=True)
class Task:
    """Some runs of one cell.

    Attributes:
        cell: The cell.
        runs: Pairs of a seed and a repetition.
        keep: The seed whose recording is returned with the row, if any.
        code: The expected hashes of the code.
        imports: Modules and files of the user that the worker imports first.
    """

    cell: Cell
    code: CodeHashes
    runs: tuple[tuple[int, int], ...]
    keep: int | None = None
    imports: tuple[str, ...] = ()

    def one(self, seed: int, repetition: int) -> Self:
        """Returns a task with one of its runs."""
        return replace(self, runs=((seed, repetition),))


class UnfitWorkerError(RuntimeError):
    """A worker cannot give the same results as the driver."""


# The facts about a number of a kind of scenario.
_SCORE: MetricFacts = {"unit": "-", "family": "goal", "direction": "higher"}

# The last cell of this thread, which its next task may reuse.
_last = threading.local()

_imported: set[str] = set()
_importing = threading.Lock()


def do_task(task: Task) -> list[RunRow]:
    """Runs the trials of a task; the row of a failed one has the reason.

    Raises:
        UnfitWorkerError: If versions, code or behavior trees differ from the
            driver's, or user code cannot be imported here.
    """
    _import(task.imports)
    _check_version(task)
    return [_run(task, seed, repetition) for seed, repetition in task.runs]


def load_trials() -> None:
    """Imports what runs need."""
    importlib.import_module("hunav_drake.trial.simulation")


def warm_up(texts: Iterable[str]) -> None:
    """Compiles the kernels of scenarios, and caches them on disk."""
    from hunav_drake.runs.compiling_ahead import compiling_ahead
    from hunav_drake.scenario import LoadScenario
    from hunav_drake.trial.compiling import told_compile_time
    from hunav_drake.trial.diagram import MakeTrialDiagram
    from hunav_drake.trial.simulation import MakeTrialSimulator

    for text in texts:
        scenario = LoadScenario(data=text)
        helping = functools.partial(compiling_ahead, scenario)
        with told_compile_time(helping, quiet=True):
            diagram = MakeTrialDiagram(scenario, drawn=False)
            simulator = MakeTrialSimulator(diagram)
            simulator.AdvanceTo(4 * scenario.simulation.time_step)


def _run(task: Task, seed: int, repetition: int) -> RunRow:
    from hunav_drake.systems.planning import time_cycles
    from hunav_drake.trial.simulation import RunTrial

    wall, cpu = time.perf_counter(), time.process_time()
    try:
        scenario, diagram = _prepared(task, seed)
        with time_cycles() as cycles:
            result = RunTrial(scenario, seed, diagram=diagram)
        numbers = task.cell.numbers(result.recording, seed)
        # (Of the trial alone.)
        cost = {
            "wall": time.perf_counter() - wall,
            "cpu": time.process_time() - cpu,
        }
        if task.cell.relative and result.end_reason not in FAILED:
            result = _compared(result, scenario, seed, diagram)
    except (KeyboardInterrupt, MemoryError):
        raise
    except Exception as error:
        reason = fault_of_user_code(error) or f"{type(error).__name__}: {error}"
        return failed_row(task, seed, repetition, reason)
    if cycles:
        median, p95 = np.quantile(cycles, (0.5, 0.95)).tolist()
        cost |= {"cycle_median": median, "cycle_p95": p95}
    is_kept = task.keep == seed and repetition == 0
    row = make_row(result)
    return row._replace(
        **_about(task, seed, repetition),
        metrics=row.metrics | numbers,
        facts={**row.facts, **dict.fromkeys(numbers, _SCORE)},
        # The provenance is in its cell.
        provenance={},
        cost=cost,
        extras=extra_values(result.recording),
        recording=result.recording if is_kept else None,
    )


def _compared(
    result: "TrialResult", scenario: Any, seed: int, diagram: Any
) -> "TrialResult":
    """Returns a result that also has the relative metrics.

    They are NaN if a planner fails alone, or after the end of the trial: it has
    not failed in the trial.
    """
    from hunav_drake.systems.planning.planner_error import PlannerError
    from hunav_drake.trial.branches.relative import (
        CompareAlone,
        unknown_relative,
        with_relative,
    )
    from hunav_drake.trial.seeds import SetTrialSeed

    simulation = replace(scenario.simulation, seed=seed)
    scenario = replace(scenario, simulation=simulation)
    context = diagram.CreateDefaultContext()
    SetTrialSeed(diagram, context, seed)
    try:
        found = CompareAlone(scenario, diagram, context)
    except PlannerError:
        found = unknown_relative(scenario)
    return with_relative(result, replace(found, costs={}))


def extra_values(recording: Recording) -> dict[str, float]:
    """Returns further numbers of a recording, by name; NaN for no value.

    "lowest_speed_near_people": the lowest speed of the robot while a person is
    within 1.2 m, from surface to surface, in m/s. "cruising_speed": the median
    speed of the robot between samples, in m/s. "walked_per_person": the mean
    length of a person's path, in meters. "min_dist_to_person_1", ...: the
    smallest distance between the surfaces of the robot and each person, in
    meters.
    """
    robot, people = recording.robot, recording.humans
    offsets = people[:, :, [X, Y]] - robot[:, None, [X, Y]]
    gaps = (
        np.hypot(offsets[..., 0], offsets[..., 1])
        - robot[:, None, RADIUS]
        - people[:, :, RADIUS]
    )
    speeds = np.hypot(robot[:, VX], robot[:, VY])
    way = np.hypot(*np.diff(robot[:, [X, Y]], axis=0).T)
    paces = way / np.diff(recording.times)
    near = (gaps < _NEAR).any(axis=1)
    steps = np.diff(people[:, :, [X, Y]], axis=0)
    walked = np.nansum(np.hypot(steps[..., 0], steps[..., 1]), axis=0)
    values = {
        "cruising_speed": np.median(paces) if len(paces) else None,
        "lowest_speed_near_people": speeds[near].min() if near.any() else None,
        "walked_per_person": walked.mean() if walked.size else None,
    }
    for i, gap in enumerate(gaps.T, start=1):
        present = gap[np.isfinite(gap)]
        values[f"min_dist_to_person_{i}"] = (
            max(float(present.min()), 0.0) if present.size else None
        )
    return {k: math.nan if v is None else float(v) for k, v in values.items()}


def failed_row(
    task: Task,
    seed: int,
    repetition: int,
    reason: str,
    end_reason: Literal["error", "worker_died"] = ERROR,
) -> RunRow:
    """Returns the row of a run without a result."""
    return RunRow(
        **_about(task, seed, repetition),
        end_reason=end_reason,
        end_message=" ".join(reason.split()),
        end_time=math.nan,
        metrics={},
        by_behavior={},
    )


def _about(task: Task, seed: int, repetition: int) -> dict[str, Any]:
    """Returns the fields that identify a run of a suite."""
    cell = task.cell
    return {
        "scenario": cell.scenario,
        "planner": cell.planner,
        "setting": cell.setting,
        "drawn": cell.drawn,
        "seed": seed,
        "repetition": repetition,
        "sha256": cell.sha256,
        "code_sha256": hash_of_all(task.code),
    }


def _prepared(task: Task, seed: int) -> tuple[Any, Any]:
    """Returns the scenario and the diagram, which its seeds share.

    If each seed draws its own people or world, each needs its own diagram.
    """
    from hunav_drake.scenario.population import people_seed
    from hunav_drake.trial.diagram import MakeTrialDiagram

    sha256, made = getattr(_last, "cell", ("", None))
    if (
        made is None
        or sha256 != task.cell.sha256
        or task.cell.kind
        or people_seed(made[0]) not in (None, seed)
    ):
        _last.cell = "", None
        scenario = task.cell.load(seed)
        made = scenario, MakeTrialDiagram(scenario, drawn=False)
        _last.cell = task.cell.sha256, made
    return made


def _import(names: Iterable[str]) -> None:
    """Imports the modules that this process has not imported yet."""
    with _importing:
        new = [name for name in names if name not in _imported]
        try:
            import_user_code(new)
        except InputError as error:
            raise UnfitWorkerError(f"{_place()}: {error}") from None
        _imported.update(new)


@functools.lru_cache(maxsize=64)
def _loaded(text: str) -> Any:
    from hunav_drake.scenario import LoadScenario

    return LoadScenario(data=text)


def _sha256_here(cell: Cell) -> str:
    """Returns the hash of a cell with the current files that it names."""
    return cell_sha256(
        cell.text, _loaded(cell.text), cell.kind, relative=cell.relative
    )


@functools.lru_cache(maxsize=64)
def _has_code(name: str, sha256: str) -> bool:
    """Returns whether the code here is that of the driver."""
    try:
        return code_sha256(name) == sha256
    except (OSError, ImportError):
        return False


def _check_version(task: Task) -> None:
    """Checks that code, versions and files are those of the driver."""
    for name, sha256 in task.code:
        if not _has_code(name, sha256):
            raise UnfitWorkerError(
                f"{_place()}: has other code of {name} than the suite: the"
                " code was changed during the suite, or differs there; install"
                " the same on all workers, and start the suite again"
            )
    try:
        here = _sha256_here(task.cell)
    except Exception as error:
        # The rows of its runs will have the error.
        if not isinstance(error, ImportError):
            return
        raise UnfitWorkerError(f"{_place()}: {error}") from None
    if here != task.cell.sha256:
        versions = ", ".join(f"{k} {v}" for k, v in program_versions().items())
        raise UnfitWorkerError(
            f"{_place()}: has other versions, behavior trees or files than the"
            f" suite ({versions}): install the same on all workers; if a map or"
            " a model was changed during the suite, start the suite again"
        )


def _place() -> str:
    return f"the worker on {platform.node() or 'this machine'}"
