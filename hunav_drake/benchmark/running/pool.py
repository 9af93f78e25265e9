"""Who runs tasks: worker processes, or this one."""

from collections.abc import Callable, Sequence
from concurrent.futures import (
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
)
import contextlib
import multiprocessing
from multiprocessing.connection import wait
import os
import threading
from typing import Any

from hunav_drake.commands.user_code import import_user_code


class InlineExecutor(Executor):
    """Runs each task when it is given out, in this process."""

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
    """Worker processes; when one dies, they all are started anew."""

    def __init__(self, workers: int, imports: Sequence[str] = ()) -> None:
        """Prepares so many processes, which begin with the first tasks."""
        self._workers = workers
        self._imports = tuple(imports)
        self._pool = self._start()

    def submit(
        self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any
    ) -> "Future[Any]":
        """Gives a task to a worker."""
        try:
            return self._pool.submit(fn, *args, **kwargs)
        except BrokenExecutor:
            self._pool.shutdown(wait=False, cancel_futures=True)
            self._pool = self._start()
            return self._pool.submit(fn, *args, **kwargs)

    def shutdown(
        self, wait: bool = True, *, cancel_futures: bool = False
    ) -> None:
        """Ends the workers; what was not begun is not."""
        self._pool.shutdown(wait=wait, cancel_futures=True)

    def _start(self) -> ProcessPoolExecutor:
        # Drake has threads, which a forked process would lack.
        return ProcessPoolExecutor(
            self._workers,
            multiprocessing.get_context("spawn"),
            _prepare,
            (self._imports,),
        )


def _prepare(imports: Sequence[str]) -> None:
    """Prepares a worker: it ends with its driver, however that ends."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        sentinel = parent.sentinel

        def end_with_driver() -> None:
            with contextlib.suppress(OSError):
                wait([sentinel])
            os._exit(1)

        threading.Thread(target=end_with_driver, daemon=True).start()
    _ignore_interrupts()
    # Each worker has a processor; more threads would only be in the way.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    import_user_code(imports)


def _ignore_interrupts() -> None:
    """Leaves Ctrl-C, which all processes of a terminal get, to the driver."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)
