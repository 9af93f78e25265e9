"""Replays of runs of each cell of a suite, for a browser."""

from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
import json
import math
import os
from pathlib import Path

from hunav_drake.runs.cells import Cell
from hunav_drake.runs.run_folders import replay_path
from hunav_drake.runs.run_row import FAILED, RunRow
from hunav_drake.runs.suite_result import SuiteResult
from hunav_drake.runs.worker_pool import InlineExecutor, WorkerPool
from hunav_drake.systems.common.files import remove_drafts
from hunav_drake.systems.evaluation.metric import (
    LEAST_GAP,
    RELATIVE_FAMILY,
    base_name,
)


def WriteReplays(
    result: SuiteResult,
    folder: str | Path,
    *,
    workers: int | None = None,
    imports: Sequence[str] = (),
    progress: Callable[[int, int], object] = lambda done, total: None,
) -> list[Path]:
    """Writes the missing replays of each cell: of its first seed.

    Where runs have metrics of encounters, the run with the smallest gap to a
    person has one, too.

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
    missing = []
    for cell in result.cells:
        first = result.suite.seed_list(cell.scenario)[0]
        rows = [
            row
            for row in result.rows
            if row.cell == cell.name
            and row.repetition == 0
            and row.end_reason not in FAILED
        ]
        worst = min(rows, key=_least_gap, default=None)
        for row in rows:
            path = replay_path(Path(folder), cell.name, row.seed or 0)
            near = row is worst and math.isfinite(_least_gap(row))
            if (row.seed == first or near) and not path.is_file():
                missing.append((cell, path, row))
    if not missing:
        return []
    workers = min(workers or os.cpu_count() or 1, len(missing))
    pool = InlineExecutor if workers == 1 else WorkerPool
    arguments = (imports,) if workers == 1 else (workers, imports)
    try:
        with pool(*arguments) as executor:
            futures = {
                executor.submit(
                    *(WriteReplay, cell, path, row.seed),
                    json.dumps(_known(row)),
                ): path
                for cell, path, row in missing
            }
            for done, future in enumerate(as_completed(futures), start=1):
                future.result()
                progress(done, len(futures))
    except BaseException:
        # The workers were ended at any point.
        for _, path, _ in missing:
            remove_drafts(path)
        raise
    return [path for _, path, _ in missing]


def _least_gap(row: RunRow) -> float:
    """Returns the smallest gap to a person; infinite if it is not known."""
    gaps = (v for k, v in row.metrics.items() if base_name(k) == LEAST_GAP)
    return min((it for it in gaps if not math.isnan(it)), default=math.inf)


def _known(row: RunRow) -> dict[str, float]:
    """Returns the metrics of a single trial."""
    alone = row.facts.items()
    paired = {k for k, it in alone if it["family"] == RELATIVE_FAMILY}
    return {k: v for k, v in row.metrics.items() if k not in paired}


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
    from hunav_drake.views.events import events_of
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
    SaveReplay(meshcat, path, events=events_of(result.recording))
