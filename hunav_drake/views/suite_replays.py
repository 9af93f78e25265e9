"""Replays of the first seed of each cell of a suite, for a browser."""

from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
import json
import os
from pathlib import Path

from hunav_drake.runs.cells import Cell
from hunav_drake.runs.run_folders import replay_path
from hunav_drake.runs.run_row import FAILED
from hunav_drake.runs.suite_result import SuiteResult
from hunav_drake.runs.worker_pool import InlineExecutor, WorkerPool
from hunav_drake.systems.common.files import remove_drafts


def WriteReplays(
    result: SuiteResult,
    folder: str | Path,
    *,
    workers: int | None = None,
    imports: Sequence[str] = (),
    progress: Callable[[int, int], object] = lambda done, total: None,
) -> list[Path]:
    """Writes the missing replays of the first seed of each cell.

    Each trial runs again with Meshcat, which does not affect it: its metrics
    are compared with those of the suite.

    Args:
        result: The result of the suite.
        folder: The folder of the suite; replays are in its `replays`.
        workers: The number of processes; by default, that of processors.
        imports: Modules and files that each worker imports first.
        progress: Called with the numbers of written and of all replays.

    Returns:
        The paths of the new replays.

    Raises:
        RuntimeError: If a trial does not repeat.
        OSError: If a file cannot be written.
    """
    seeds = {
        cell.name: result.suite.seed_list(cell.scenario)[0]
        for cell in result.cells
    }
    firsts = {
        row.cell: row.metrics
        for row in result.rows
        if row.seed == seeds[row.cell]
        and row.repetition == 0
        and row.end_reason not in FAILED
    }
    wanted = [
        (cell, replay_path(Path(folder), cell.name, seeds[cell.name]))
        for cell in result.cells
        if cell.name in firsts
    ]
    missing = [it for it in wanted if not it[1].is_file()]
    if not missing:
        return []
    workers = min(workers or os.cpu_count() or 1, len(missing))
    pool = InlineExecutor if workers == 1 else WorkerPool
    arguments = (imports,) if workers == 1 else (workers, imports)
    try:
        with pool(*arguments) as executor:
            futures = {
                executor.submit(
                    *(WriteReplay, cell, path, seeds[cell.name]),
                    json.dumps(firsts[cell.name]),
                ): path
                for cell, path in missing
            }
            for done, future in enumerate(as_completed(futures), start=1):
                future.result()
                progress(done, len(futures))
    except BaseException:
        # The workers were ended at any point.
        for _, path in missing:
            remove_drafts(path)
        raise
    return [path for _, path in missing]


def WriteReplay(
    cell: Cell, path: Path, seed: int | None = None, metrics: str = ""
) -> None:
    """Runs a trial again, and writes its replay.

    Args:
        cell: Its cell.
        path: The file to write.
        seed: Its seed; by default that of its scenario.
        metrics: Its metrics as JSON, to compare them; empty if unknown.

    Raises:
        RuntimeError: If the metrics differ.
        OSError: If the file cannot be written.
    """
    import logging

    from hunav_drake.scenario import LoadScenario
    from hunav_drake.scenario.fleet import robots_of
    from hunav_drake.scenario.population import draw_people
    from hunav_drake.trial.simulation import RunTrial
    from hunav_drake.views.replay import SaveReplay, SetView, StartMeshcatLocal

    # Meshcat logs its address, which nobody needs.
    logging.getLogger("drake").setLevel(logging.WARNING)
    scenario = LoadScenario(data=cell.text) if seed is None else cell.load(seed)
    seed = scenario.simulation.seed
    meshcat = StartMeshcatLocal()
    people = draw_people(scenario)
    SetView(meshcat, scenario.world, people, robots_of(scenario))
    result = RunTrial(scenario, meshcat=meshcat)
    found = {str(k): float(v) for k, v in result.metrics.items()}
    again = json.dumps(found | cell.numbers(result.recording, seed))
    if metrics and again != metrics:
        raise RuntimeError(
            f"{cell.name}, seed {seed}: the trial does not repeat itself, so"
            " there is no replay of it; does a planner or metric of yours keep"
            " something from run to run?"
        )
    path.parent.mkdir(parents=True, exist_ok=True)
    SaveReplay(meshcat, path)
