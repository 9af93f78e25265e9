"""Measures and reports the compilation of numeric kernels."""

from collections.abc import Callable, Iterator
from contextlib import (
    AbstractContextManager,
    ExitStack,
    contextmanager,
    nullcontext,
)
from dataclasses import dataclass
import gc
import sys
import time
from typing import Any


@dataclass
class CompileTime:
    """The time that compilation of kernels took so far."""

    seconds: float = 0.0
    """Real time, in seconds."""

    kernels: int = 0
    """Number of compiled kernels, with those that they call."""


@contextmanager
def compile_time(
    tell: Callable[[CompileTime], None] | None = None, *, is_short: bool = False
) -> Iterator[CompileTime]:
    """Measures the time of compilation of kernels in a block of code.

    Kernels that are read from disk are not compiled.

    Args:
        tell: Called when the first compilation begins, and after each one.
        is_short: Whether the program ends soon. Then garbage collection stops
            during compilation, and never frees what is in memory by then: this
            saves an eighth of the time.

    Yields:
        The measured time so far.
    """
    # Imported here: numba takes long to load.
    from numba.core import event

    measured = CompileTime()
    collects = gc.isenabled()

    class Listener(event.Listener):
        # A kernel compiles those that it calls: only the outermost counts.
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
def told_compile_time(
    helping: Callable[[], AbstractContextManager[None]] = nullcontext,
    *,
    quiet: bool = False,
) -> Iterator[CompileTime]:
    """Measures the time of compilation, and reports it on standard error.

    From the first compilation on, the rest runs in the context that `helping`
    makes. If it is `quiet`, nothing is reported.
    """
    from hunav_drake.systems.common.kernels import keeps_code

    told = False
    stack = ExitStack()
    terminal = sys.stderr.isatty()

    def write(text: str, end: str = "\n") -> None:
        if not quiet:
            print(text, end=end, file=sys.stderr, flush=True)

    def tell(measured: CompileTime) -> None:
        nonlocal told
        text = "Compiling kernels (once, up to a minute) ..."
        if not told:
            told = True
            write(text, end="" if terminal else "\n")
            stack.enter_context(helping())
        elif terminal:
            write(f"\r{text} {measured.kernels} done", end="")

    with stack, compile_time(tell, is_short=True) as measured:
        yield measured
    if told:
        write(
            f"{'\r' if terminal else ''}Compiled {measured.kernels} kernels in"
            f" {measured.seconds:.0f} s"
            + ("; they are kept on disk." if keeps_code() else ".")
        )
