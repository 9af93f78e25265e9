"""The wall clock around the cycles of planners: measured, and limited.

Nothing of it enters a decision, so runs repeat all the same.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
import signal
import threading
import time
from typing import Any

# The lists that collect now, of this thread.
_collecting: ContextVar[tuple[list[float], ...]] = ContextVar(
    "collecting", default=()
)


class CycleTimeout(BaseException):
    """A cycle took too long; no `except Exception` of a planner holds it."""


@contextmanager
def time_cycles() -> Iterator[list[float]]:
    """Measures how long planners take for each cycle.

    It is about every `Planner` that runs in this thread meanwhile, in
    whatever trial:

        with time_cycles() as times:
            RunTrial(scenario)
        print(f"{1e3 * statistics.median(times):.2f} ms per cycle")

    Yields:
        A list that grows with each call of a planner's `plan`, by the seconds
        that it took, of the wall clock.
    """
    times: list[float] = []
    token = _collecting.set((*_collecting.get(), times))
    try:
        yield times
    finally:
        _collecting.reset(token)


def call_cycle(
    plan: Callable[..., Any], arguments: tuple[Any, ...], limit: float | None
) -> Any:
    """Returns what a planner decides, measured and limited.

    In the main thread, Python code that takes longer than the limit is ended.
    In other threads, and while compiled code runs, it is told only afterwards.

    Args:
        plan: The planner's function.
        arguments: What it is called with.
        limit: The most seconds of the wall clock that it may take.

    Raises:
        CycleTimeout: If it takes longer.
    """
    lists = _collecting.get()
    if limit is None:
        if not lists:
            return plan(*arguments)
        started = time.perf_counter()
        result = plan(*arguments)
        elapsed = time.perf_counter() - started
    else:
        started = time.perf_counter()
        with _alarm(limit):
            result = plan(*arguments)
        elapsed = time.perf_counter() - started
        if elapsed > limit:
            raise CycleTimeout
    for times in lists:
        times.append(elapsed)
    return result


@contextmanager
def _alarm(seconds: float) -> Iterator[None]:
    """Raises CycleTimeout in the main thread after some time."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def ring(number: int, frame: Any) -> None:
        raise CycleTimeout

    before = signal.signal(signal.SIGALRM, ring)
    started = time.monotonic()
    left, interval = signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        if left > 0:
            # Somebody else's alarm goes on.
            passed = time.monotonic() - started
            signal.setitimer(
                signal.ITIMER_REAL, max(left - passed, 1e-3), interval
            )
