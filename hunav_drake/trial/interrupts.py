"""Defers Ctrl-C to the end of a step."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import signal
import threading
from typing import Any

from hunav_drake.systems.planning.cycles import is_interrupted


@contextmanager
def interrupts_between_steps() -> Iterator[Callable[[], None]]:
    """Defers a KeyboardInterrupt until the next check.

    An interrupt during a call from C++ into Python may be lost there, or become
    another error. A second one is not deferred. With another handler of
    interrupts, or in another thread, nothing changes.

    Yields:
        A function that raises KeyboardInterrupt if one is pending.
    """
    pending = False

    def hold(number: int, frame: Any) -> None:
        nonlocal pending
        if pending:
            signal.default_int_handler(number, frame)
        pending = True

    def check() -> None:
        if pending:
            raise KeyboardInterrupt

    if (
        threading.current_thread() is not threading.main_thread()
        or signal.getsignal(signal.SIGINT) is not signal.default_int_handler
    ):
        yield check
        return
    token = is_interrupted.set(lambda: pending)
    signal.signal(signal.SIGINT, hold)
    try:
        try:
            yield check
        finally:
            # (Also if a planner that waited failed for it.)
            check()
    finally:
        is_interrupted.reset(token)
        signal.signal(signal.SIGINT, signal.default_int_handler)
