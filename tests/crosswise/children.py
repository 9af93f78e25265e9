"""Rows in child processes: who brings one down is known."""

from collections.abc import Callable, Iterable, Iterator
import faulthandler
import multiprocessing
from multiprocessing.connection import Connection
import signal
import traceback
from typing import Any

# How long a row may take, in seconds, on a machine that does other things too.
LIMIT = 400.0


def run_apart[T](
    run: Callable[[T], None], rows: Iterable[T]
) -> Iterator[tuple[T, str]]:
    """Runs rows in a child process, and in a new one after each that died.

    Args:
        run: Runs a row; a function of a module.
        rows: What to run.

    Yields:
        Each row with what it failed of, and an empty text if it did not.
    """
    child, pipe = None, None
    for row in rows:
        if child is None:
            child, pipe = _start(run)
        try:
            pipe.send(row)
            failure = pipe.recv() if pipe.poll(LIMIT) else _stop(child)
        except (EOFError, BrokenPipeError):
            failure = _death(child)
        if not child.is_alive():
            child = None
        yield row, failure
    if child is not None:
        pipe.send(None)
        child.join()


def _start(run: Callable[..., None]) -> tuple[Any, Connection]:
    spawn = multiprocessing.get_context("spawn")
    ours, theirs = spawn.Pipe()
    child = spawn.Process(target=_serve, args=(run, theirs), daemon=True)
    child.start()
    theirs.close()
    # To start takes its time, which is not that of a row.
    ours.recv()
    return child, ours


def _serve(run: Callable[..., None], pipe: Connection) -> None:
    """Runs the rows that come, and answers with what each failed of."""
    faulthandler.enable()
    pipe.send("ready")
    while (row := pipe.recv()) is not None:
        failure = ""
        try:
            run(row)
        except Exception:
            failure = traceback.format_exc()
        pipe.send(failure)


def _death(child: Any) -> str:
    child.join()
    code = child.exitcode
    if code < 0:
        return f"ended by {signal.Signals(-code).name}"
    return f"ended the process with {code}"


def _stop(child: Any) -> str:
    child.kill()
    child.join()
    return f"took longer than {LIMIT:g} s"
