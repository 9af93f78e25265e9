"""What a worker process does: runs of one cell, one seed after the other."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
import time
from typing import Any, Self

from hunav_drake.benchmark.running.run_row import (
    RunRow,
    cycle_cost,
    failed_row,
    make_row,
)
from hunav_drake.commands.user_code import fault_of_user_code


@dataclass(frozen=True, kw_only=True)
class Task:
    """Some runs of one cell.

    Attributes:
        cell: The name of the cell.
        sha256: The hash of the cell.
        text: Its scenario.
        runs: Pairs of a seed and a repetition.
        keep: The seed of which the recording comes with the row, if any.
    """

    cell: str
    sha256: str
    text: str
    runs: tuple[tuple[int, int], ...]
    keep: int | None = None

    def one(self, seed: int, repetition: int) -> Self:
        """Returns the task of one of its runs."""
        return replace(self, runs=((seed, repetition),))


# The last cell of this process, for the next of its tasks.
_last: dict[str, Any] = {}


def do_task(task: Task) -> list[RunRow]:
    """Runs the trials of a task; what fails becomes a row that says why."""
    return [_run(task, seed, repetition) for seed, repetition in task.runs]


def warm_up(texts: Iterable[str]) -> None:
    """Compiles what trials need, and writes it to the cache on disk."""
    from hunav_drake.scenario import LoadScenario
    from hunav_drake.simulation import MakeTrialSimulator
    from hunav_drake.trial_diagram import MakeTrialDiagram

    for text in texts:
        scenario = LoadScenario(data=text)
        simulator = MakeTrialSimulator(MakeTrialDiagram(scenario))
        simulator.AdvanceTo(4 * scenario.simulation.time_step)


def _run(task: Task, seed: int, repetition: int) -> RunRow:
    from hunav_drake.simulation import RunTrial
    from hunav_drake.systems.planning import time_cycles

    wall, cpu = time.perf_counter(), time.process_time()
    try:
        scenario, diagram = _prepared(task)
        with time_cycles() as cycles:
            result = RunTrial(scenario, seed, diagram=diagram)
    except (KeyboardInterrupt, MemoryError):
        raise
    except Exception as error:
        reason = fault_of_user_code(error) or f"{type(error).__name__}: {error}"
        return failed_row(task.cell, task.sha256, seed, repetition, reason)
    return make_row(
        result,
        cell=task.cell,
        sha256=task.sha256,
        seed=seed,
        repetition=repetition,
        cost={
            "wall": time.perf_counter() - wall,
            "cpu": time.process_time() - cpu,
            **cycle_cost(cycles),
        },
        with_recording=task.keep == seed and repetition == 0,
    )


def _prepared(task: Task) -> tuple[Any, Any]:
    """Returns the scenario and the diagram, made once for all its seeds."""
    from hunav_drake.scenario import LoadScenario
    from hunav_drake.trial_diagram import MakeTrialDiagram

    if _last.get("sha256") != task.sha256:
        _last.clear()
        scenario = LoadScenario(data=task.text)
        _last.update(
            sha256=task.sha256, made=(scenario, MakeTrialDiagram(scenario))
        )
    made: tuple[Any, Any] = _last["made"]
    return made
