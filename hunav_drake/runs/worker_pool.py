"""Executors of tasks: worker processes, or this process."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
)
import contextlib
import multiprocessing
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
import os
import signal
import threading
from typing import Any

from hunav_drake.trial.user_code import import_user_code


class InlineExecutor(Executor):
    """Runs each task in this process, when it is submitted."""

    def __init__(self, imports: Sequence[str] = ()) -> None:
        """Imports modules of the user."""
        import_user_code(imports)

    def submit(
        self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any
    ) -> "Future[Any]":
        """Runs a function, and returns its result as a future."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


class WorkerPool(Executor):
    """Worker processes; if one dies, all are started again.

    As a context manager it waits for running tasks, except if the block ends
    with an exception, such as KeyboardInterrupt: then they end at once.
    """

    def __init__(self, workers: int, imports: Sequence[str] = ()) -> None:
        """Prepares the processes, which start with the first tasks."""
        self._workers = workers
        self._imports = tuple(imports)
        # A forked process would not have Drake's threads.
        self._spawning = multiprocessing.get_context("spawn")
        # Workers end when the other end of this pipe is closed.
        self._told, self._leash = self._spawning.Pipe(duplex=False)
        self._pool = self._start()

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Ends the workers; after an exception, at once."""
        if kind is not None:
            self._leash.close()
        self.shutdown()

    def submit(
        self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any
    ) -> "Future[Any]":
        """Gives a task to a worker."""
        with _interrupts_held():
            try:
                return self._pool.submit(fn, *args, **kwargs)
            except BrokenExecutor:
                self._pool.shutdown(wait=False, cancel_futures=True)
                self._pool = self._start()
                return self._pool.submit(fn, *args, **kwargs)

    def shutdown(
        self, wait: bool = True, *, cancel_futures: bool = False
    ) -> None:
        """Ends the workers; tasks that have not started are cancelled."""
        self._pool.shutdown(wait=wait, cancel_futures=True)

    def _start(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(
            self._workers, self._spawning, _prepare, (self._imports, self._told)
        )


def _prepare(imports: Sequence[str], leash: Connection) -> None:
    """Prepares a worker.

    It ends when its driver ends, for any reason, or closes the leash.
    """
    parent = multiprocessing.parent_process()
    if parent is not None:
        ends: list[Any] = [parent.sentinel, leash]

        def end_with_driver() -> None:
            with contextlib.suppress(OSError):
                wait(ends)
            os._exit(1)

        threading.Thread(target=end_with_driver, daemon=True).start()
    _ignore_interrupts()
    # Each worker has one processor, so more threads do not help.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    import_user_code(imports)


@contextlib.contextmanager
def _interrupts_held() -> Iterator[None]:
    """Blocks Ctrl-C, also in processes that are started in the block."""
    # The tracker unblocks Ctrl-C when it starts, so it starts first.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _ignore_interrupts() -> None:
    """Ignores Ctrl-C, which all processes of a terminal get."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
