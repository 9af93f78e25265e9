"""Wall-clock time of planner cycles: measured and limited.

Decisions do not depend on it, so runs stay repeatable.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
import signal
import threading
import time
from typing import Any

# The lists that collect times now, of this thread.
_collecting: ContextVar[tuple[list[float], ...]] = ContextVar(
    "collecting", default=()
)

# Says whether Ctrl-C waits for the end of a step, so that a planner that waits
# for another program does not.
is_interrupted: ContextVar[Callable[[], bool]] = ContextVar(
    "is_interrupted", default=lambda: False
)


class CycleTimeout(BaseException):
    """A cycle took too long. `except Exception` does not catch it."""


@contextmanager
def time_cycles() -> Iterator[list[float]]:
    """Measures the duration of each planner cycle.

    It covers every `Planner` that runs in this thread meanwhile, in any trial:

        with time_cycles() as times:
            RunTrial(scenario)
        print(f"{1e3 * statistics.median(times):.2f} ms per cycle")

    Yields:
        A list that gains the wall-clock seconds of each call of a planner's
        `plan`.
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
    """Returns a planner's decision; measures and limits its time.

    The limit is in seconds of wall-clock time. In the main thread, Python code
    that exceeds it is interrupted. In other threads, and while compiled code
    runs, it is checked afterwards.

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
    """Raises CycleTimeout in the main thread after `seconds`."""
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
            # Another alarm that was set before continues.
            passed = time.monotonic() - started
            signal.setitimer(
                signal.ITIMER_REAL, max(left - passed, 1e-3), interval
            )
