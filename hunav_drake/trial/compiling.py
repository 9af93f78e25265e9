"""Tells when numeric kernels are compiled, which takes long, but only once."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import gc
import sys
import time
from typing import Any


class CompileTime:
    """How long kernels were compiled.

    Attributes:
        seconds: Of real time.
        kernels: How many there were, with those that they call.
    """

    def __init__(self) -> None:
        """Constructs a CompileTime of nothing yet."""
        self.seconds = 0.0
        self.kernels = 0


@contextmanager
def compile_time(
    tell: Callable[[CompileTime], None] | None = None, *, is_short: bool = False
) -> Iterator[CompileTime]:
    """Measures how long kernels are compiled in a block of code.

    Those that are read from disk are not compiled.

    Args:
        tell: Called when the first begins, and when each is done.
        is_short: Whether the program ends soon. Then what is in memory when a
            kernel is compiled stays there: to look for garbage in what the
            compiler keeps takes an eighth of its time.

    Yields:
        What was measured up to now.
    """
    # Here, for numba takes long to load.
    from numba.core import event

    measured = CompileTime()
    collects = gc.isenabled()

    class Listener(event.Listener):
        # Kernels compile those that they call: only the outermost counts.
        depth = 0
        started = 0.0

        def on_start(self, _: Any) -> None:
            if self.depth == 0:
                self.started = time.perf_counter()
                if is_short:
                    gc.disable()
            self.depth += 1
            if tell is not None and not measured.kernels:
                tell(measured)

        def on_end(self, _: Any) -> None:
            self.depth -= 1
            measured.kernels += 1
            if self.depth == 0:
                measured.seconds += time.perf_counter() - self.started
                if is_short and collects:
                    gc.freeze()
                    gc.enable()
            if tell is not None:
                tell(measured)

    with event.install_listener("numba:compile", Listener()):
        yield measured


@contextmanager
def told_compile_time() -> Iterator[CompileTime]:
    """Measures it, and tells a user who waits, on standard error."""
    told = 0
    terminal = sys.stderr.isatty()

    def tell(measured: CompileTime) -> None:
        nonlocal told
        if not told:
            print(
                "Compiling kernels (once, up to a minute) ...",
                file=sys.stderr,
                end="" if terminal else "\n",
                flush=True,
            )
        elif terminal:
            print(
                f"\rCompiling kernels (once, up to a minute) ..."
                f" {measured.kernels} done",
                file=sys.stderr,
                end="",
                flush=True,
            )
        told += 1

    with compile_time(tell, is_short=True) as measured:
        yield measured
    if told:
        print(
            f"{'\r' if terminal else ''}Compiled {measured.kernels} kernels in"
            f" {measured.seconds:.0f} s; they are kept on disk.",
            file=sys.stderr,
        )
