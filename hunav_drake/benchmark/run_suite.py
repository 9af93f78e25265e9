"""Runs a suite: in worker processes, to be stopped and resumed at any time."""

from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
import contextlib
import os
from pathlib import Path

from hunav_drake.benchmark.running.cell import make_cells
from hunav_drake.benchmark.running.plan import CellPlan
from hunav_drake.benchmark.running.pool import InlineExecutor, WorkerPool
from hunav_drake.benchmark.running.recordings import keep_recording
from hunav_drake.benchmark.running.run_log import RunLog
from hunav_drake.benchmark.running.run_row import RunRow, failed_row
from hunav_drake.benchmark.running.worker import Task, do_task, warm_up
from hunav_drake.benchmark.suite import Suite
from hunav_drake.benchmark.suite_result import SuiteResult

# How often a task is given out again whose worker has died.
_ATTEMPTS = 3

# Called with each run that has ended, how many have, and how many there are.
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
    """Runs all trials of a suite that are not yet done.

    Everything is checked before the first trial. A trial that fails is a row
    with its reason. The results do not depend on who runs what, and in which
    order.

    Args:
        suite: What to run: see `LoadSuite`.
        out: A folder for the results. What it holds already is not run again.
            By default they are in memory alone.
        workers: How many processes run trials; by default one for each
            processor. With 1, this one does.
        executor: Who runs trials instead: any of `concurrent.futures`, such as
            that of a Dask client, `client.get_executor()`. It is not shut
            down.
        folder: Where relative paths of scenarios begin, as in a suite file.
        imports: Modules and files that each worker imports first, as with
            `--import`.
        fresh: Runs everything. What `out` holds is kept as `runs_old.jsonl`.
        progress: Called with each run that ends.

    Raises:
        ScenarioError: If a scenario of a cell is not sound: all faults.
        ValueError: If `out` holds runs of these cells by other scenarios or
            another version of this package.
        OSError: If `out` cannot be written, or is in use.
    """
    cells = make_cells(suite, Path(folder) if folder is not None else None)
    workers = workers or os.cpu_count() or 1
    with contextlib.ExitStack() as stack:
        log = None
        done: list[RunRow] = []
        if out is not None:
            out = Path(out)
            log = stack.enter_context(RunLog(out, fresh=fresh))
            done = log.check(cells)
        plans = [CellPlan(cell, suite, done) for cell in cells]
        if all(plan.is_done for plan in plans):
            return SuiteResult(suite, cells, done, out)
        if executor is None:
            made = (
                InlineExecutor(imports)
                if workers == 1
                else WorkerPool(workers, imports)
            )
            executor = stack.enter_context(made)
        driver = _Driver(executor, plans, log, out, progress)
        driver.rows = done
        driver.run(window=2 * workers + 2)
        return SuiteResult(suite, cells, driver.rows, out)


class _Driver:
    """Gives out tasks, and takes in rows."""

    def __init__(
        self,
        executor: Executor,
        plans: Sequence[CellPlan],
        log: RunLog | None,
        out: Path | None,
        progress: Progress,
    ) -> None:
        self._executor = executor
        self._plans = {plan.cell.name: plan for plan in plans}
        self._log = log
        self._out = out
        self._progress = progress
        self._attempts: dict[tuple[str, int, int], int] = {}
        self._again: list[Task] = []
        self.rows: list[RunRow] = []

    def run(self, window: int) -> None:
        """Runs until all plans are done, `window` tasks at a time at most."""
        self._warm_up()
        running: dict[Future[list[RunRow]], Task] = {}
        try:
            while True:
                while len(running) < window and (task := self._next()):
                    running[self._executor.submit(do_task, task)] = task
                if not running:
                    return
                ended, _ = wait(running, return_when=FIRST_COMPLETED)
                for future in ended:
                    self._take(future, running.pop(future))
        except BaseException:
            for future in running:
                future.cancel()
            raise

    def _warm_up(self) -> None:
        """Lets one worker compile the kernels, before all do at once."""
        kinds: dict[tuple[str, str], str] = {}
        for plan in self._plans.values():
            if not plan.is_done:
                kinds.setdefault(plan.kind, plan.cell.text)
        future = self._executor.submit(warm_up, list(kinds.values()))
        # What fails here fails again in its own run, which tells it.
        with contextlib.suppress(Exception):
            future.result()

    def _next(self) -> Task | None:
        if self._again:
            return self._again.pop()
        for plan in self._plans.values():
            if task := plan.next_task():
                return task
        return None

    def _take(self, future: "Future[list[RunRow]]", task: Task) -> None:
        try:
            rows = future.result()
        except Exception as error:
            rows = self._retry(task, error)
        if self._out is not None:
            # First the recording: a row in the log is a run that is done.
            for row in rows:
                keep_recording(row, self._out)
        new = self._log.append(rows) if self._log is not None else rows
        for row in new:
            self.rows.append(row._replace(recording=None))
            self._plans[row.cell].take(row)
            done = sum(plan.done for plan in self._plans.values())
            total = sum(plan.total for plan in self._plans.values())
            self._progress(row, done, total)

    def _retry(self, task: Task, error: Exception) -> list[RunRow]:
        """Gives the runs of a dead worker out again, one by one."""
        failed = []
        for seed, repetition in task.runs:
            key = task.cell, seed, repetition
            self._attempts[key] = self._attempts.get(key, 0) + 1
            if self._attempts[key] < _ATTEMPTS:
                self._again.append(task.one(seed, repetition))
                continue
            reason = (
                f"its worker process died {_ATTEMPTS} times"
                f" ({type(error).__name__}: {error})"
            )
            failed.append(
                failed_row(task.cell, task.sha256, seed, repetition, reason)
            )
        return failed
