"""Runs a suite in worker processes; it can be stopped and resumed."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Executor, Future
import contextlib
import gc
import os
from pathlib import Path
from queue import Empty, SimpleQueue

import numpy as np

from hunav_drake.runs.cell_plan import CellPlan
from hunav_drake.runs.cells import make_cells
from hunav_drake.runs.code_hash import hash_code, hash_of_all
from hunav_drake.runs.run_folders import recording_path
from hunav_drake.runs.run_log import RunLog
from hunav_drake.runs.run_row import LOST, RunRow
from hunav_drake.runs.run_table import RunTable
from hunav_drake.runs.suite import Suite
from hunav_drake.runs.suite_result import SuiteResult
from hunav_drake.runs.suite_tables import WriteSuiteTables
from hunav_drake.runs.tasks import (
    Task,
    UnfitWorkerError,
    do_task,
    failed_row,
    warm_up,
)
from hunav_drake.runs.worker_pool import InlineExecutor, WorkerPool
from hunav_drake.trial.user_code import import_user_code

# The number of attempts to run a trial alone, if its worker dies each time.
_ATTEMPTS = 3

# Called with each finished run, the number of finished runs, and of all runs.
Progress = Callable[[RunRow, int, int], object]


def RunSuite(
    suite: Suite,
    *,
    out: str | Path | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    folder: str | Path | None = None,
    imports: Sequence[str] = (),
    fresh: bool = False,
    progress: Progress = lambda row, done, total: None,
) -> SuiteResult:
    """Runs all trials of a suite that are not finished yet.

    Everything is checked before the first trial. The row of a failed trial has
    the reason. The results do not depend on the order of the runs and on the
    processes that run them.

    Args:
        suite: The suite: see `LoadSuite`.
        out: A folder for the results: a line per run as it ends, and at the
            end the tables of `WriteSuiteTables`; `hunav report` adds the page.
            Runs in it are not repeated. By default the results are only in
            memory.
        workers: The number of processes that run trials; by default one for
            each processor. With 1, this process runs them, so a crash of a
            library ends it. With `executor`, the number of trials that it can
            run at once: it gets twice as many tasks.
        executor: An executor of `concurrent.futures` to run trials, such as
            that of a Dask client, `client.get_executor()`. It is not shut
            down.
        folder: The folder of relative paths of scenarios, as for a suite file.
        imports: Modules and files that this process and each worker import
            first, as with `--import`. A file must have the same path for all
            of them. If one of them has changed, the runs in `out` do not
            count; changes of modules that they import, or of parts that are
            registered elsewhere, as in a notebook, are not detected: see
            `fresh`.
        fresh: Runs all trials. The old files in `out` become `runs_old.jsonl`,
            `recordings_old` and `replays_old`.
        progress: Called with each finished run.

    Raises:
        ScenarioError: If scenarios are invalid, or names in the suite are
            unknown; it lists all faults.
        ValueError: If `out` has runs of these cells with other scenarios,
            files that they name, versions or code.
        OSError: If `out` cannot be written, or is in use.
        UnfitWorkerError: If a worker has other versions or code than this
            process.
        ConnectionError: If the executor has cancelled its tasks.
    """
    imported = absolute_imports(imports)
    # The suite may name parts that they register.
    import_user_code(imported)
    cells = make_cells(suite, Path(folder) if folder is not None else None)
    in_this_process = executor is None and workers == 1
    workers = workers or os.cpu_count() or 1
    code = hash_code(imported)
    # The pools of this package import them as they start.
    remote = () if executor is None else imported
    with contextlib.ExitStack() as stack:
        log = None
        done = RunTable()
        plans = [CellPlan(cell, suite, code, remote) for cell in cells]
        if out is not None:
            out = Path(out)
            log = stack.enter_context(RunLog(out, fresh=fresh))
            done = _take_done(log, plans, hash_of_all(code))
        if all(plan.is_done for plan in plans):
            return _result(suite, plans, done, out)
        if log is not None and out is not None:
            # Not at the first run, if nothing can be written.
            log.path.touch()
            # Tables of other runs: until the end, the suite is unfinished.
            (out / "suite.json").unlink(missing_ok=True)
        window = 2 * workers + 2
        if in_this_process:
            # This process writes each run before it starts the next.
            window = 1
            executor = stack.enter_context(InlineExecutor())
        elif executor is None:
            executor = stack.enter_context(WorkerPool(workers, imports))
        else:
            # Its tasks may be threads, and a Meshcat that is collected in any
            # but its own ends the process.
            gc.collect()
        # If there is a log, runs are not kept in memory.
        rows = done if log is None else None
        done = RunTable()
        Driver(executor, plans, log, rows, progress).run(window)
        if log is not None:
            rows = RunTable(log.read(cells, hash_of_all(code)))
        return _result(suite, plans, rows or done, out)


def _result(
    suite: Suite, plans: Sequence[CellPlan], rows: RunTable, out: Path | None
) -> SuiteResult:
    """Returns the result of all runs, and writes its tables to the folder."""
    cells = [plan.cell for plan in plans]
    result = SuiteResult(suite, cells, _counted(rows, plans), out)
    if out is not None:
        WriteSuiteTables(result, out)
    return result


def absolute_imports(imports: Sequence[str]) -> tuple[str, ...]:
    """Returns modules and files, the latter with absolute paths."""
    return tuple(
        str(Path(name).resolve()) if name.endswith(".py") else name
        for name in imports
    )


def _take_done(
    log: RunLog, plans: Sequence[CellPlan], code_sha256: str
) -> RunTable:
    """Adds the runs of a log to the plans, and returns them."""
    by_name = {plan.cell.name: plan for plan in plans}
    done = RunTable()
    for row in log.read([plan.cell for plan in plans], code_sha256):
        # A run whose worker died may succeed now.
        if row.end_reason != LOST:
            by_name[row.cell].take(row)
            done.append(row)
    return done


def _counted(rows: RunTable, plans: Sequence[CellPlan]) -> RunTable:
    """Returns the runs that the suite asks for.

    A folder may have more runs, of other seeds, repetitions or `until`.
    """
    by_name = {plan.cell.name: plan for plan in plans}
    runs = zip(
        rows.texts("cell"),
        rows.seeds.tolist(),
        rows.repetitions.tolist(),
        strict=True,
    )
    asked = [
        i
        for i, (cell, seed, repetition) in enumerate(runs)
        if by_name[cell].counts(seed, repetition)
    ]
    return rows.sorted(np.array(asked, dtype=np.int64))


class Driver:
    """Submits tasks, and collects rows."""

    def __init__(
        self,
        executor: Executor,
        plans: Sequence[CellPlan],
        log: RunLog | None,
        rows: RunTable | None,
        progress: Progress,
    ) -> None:
        """Constructs a Driver of plans; it adds rows to log and table."""
        self._executor = executor
        self._plans = {plan.cell.name: plan for plan in plans}
        self._log = log
        self._rows = rows
        self._progress = progress
        # Runs that may have killed a worker, and how often they did alone.
        self._suspects: dict[tuple[str, int | None, int], int] = {}
        self._again: list[Task] = []
        self._done = sum(plan.done for plan in plans)
        # Plans that may have more tasks.
        self._open = list(plans)

    def run(self, window: int, *, warm_up: bool = True) -> None:
        """Runs until all plans are done.

        Args:
            window: The largest number of tasks at once.
            warm_up: Whether one worker compiles kernels before all need them.
        """
        if warm_up:
            self._warm_up()
        running: dict[Future[list[RunRow]], Task] = {}
        ended: SimpleQueue[Future[list[RunRow]]] = SimpleQueue()
        try:
            while True:
                # If a worker dies, all running tasks may be lost with it, so
                # suspected tasks run alone.
                most = 1 if self._suspects else window
                while len(running) < most and (task := self._next()):
                    future = self._executor.submit(do_task, task)
                    running[future] = task
                    future.add_done_callback(ended.put)
                if not running:
                    return
                rows: list[RunRow] = []
                for future in _all(ended):
                    rows += self._result(future, running.pop(future))
                self._take(rows)
        except BaseException:
            for future in running:
                future.cancel()
            raise

    def _warm_up(self) -> None:
        """Lets one worker compile the kernels, before all need them."""
        kinds: dict[tuple[str, str], str] = {}
        for plan in self._plans.values():
            if not plan.is_done:
                kinds.setdefault(plan.kind, plan.cell.text)
        future = self._executor.submit(warm_up, list(kinds.values()))
        # A failure here occurs again in a run, which reports it.
        with contextlib.suppress(Exception):
            future.result()

    def _next(self) -> Task | None:
        if self._again:
            return self._again.pop()
        while self._open:
            if task := self._open[0].next_task():
                return task
            self._open.pop(0)
        # Plans with `until` may have more tasks by now.
        self._open = [p for p in self._plans.values() if not p.is_done]
        return next(filter(None, (p.next_task() for p in self._open)), None)

    def _take(self, rows: Sequence[RunRow]) -> None:
        """Stores the rows of finished runs."""
        new = [row for row in rows if self._plans[row.cell].take(row)]
        if self._log is not None:
            # The recording first: a run in the log is complete.
            for row in new:
                _keep_recording(row, self._log.path.parent)
            self._log.append(new)
        total = sum(plan.total for plan in self._plans.values())
        for row in new:
            if self._rows is not None:
                self._rows.append(row)
            self._done += 1
            self._progress(row, self._done, total)

    def _result(
        self, future: "Future[list[RunRow]]", task: Task
    ) -> list[RunRow]:
        try:
            rows = future.result()
            for row in rows:
                self._suspects.pop((row.cell, row.seed, row.repetition), None)
            return rows
        except UnfitWorkerError:
            raise
        except CancelledError as error:
            raise ConnectionError(
                "the executor has cancelled its tasks: is its cluster still"
                " running? Finished runs are kept"
            ) from error
        except Exception as error:
            return self._retry(task, error)

    def _retry(self, task: Task, error: Exception) -> list[RunRow]:
        """Submits the runs of a dead worker again, each alone."""
        failed = []
        for seed, repetition in task.runs:
            key = task.cell.name, seed, repetition
            # The first attempt was not alone.
            deaths = self._suspects.get(key, -1) + 1
            if deaths < _ATTEMPTS:
                self._suspects[key] = deaths
                self._again.append(task.one(seed, repetition))
                continue
            del self._suspects[key]
            reason = (
                f"its worker process died {_ATTEMPTS} times"
                f" ({type(error).__name__}: {error}); start the suite again to"
                " repeat it"
            )
            failed.append(failed_row(task, seed, repetition, reason, LOST))
        return failed


def _all(
    queue: "SimpleQueue[Future[list[RunRow]]]",
) -> Iterator["Future[list[RunRow]]"]:
    """Yields the items of a queue; waits for one if it is empty."""
    yield queue.get()
    with contextlib.suppress(Empty):
        while True:
            yield queue.get_nowait()


def _keep_recording(row: RunRow, folder: Path) -> None:
    if row.recording is not None and row.seed is not None:
        path = recording_path(folder, row.cell, row.seed)
        path.parent.mkdir(parents=True, exist_ok=True)
        row.recording.save(path)
