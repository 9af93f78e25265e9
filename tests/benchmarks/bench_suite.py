"""What a large suite costs: memory while it runs, disk, and reading it back."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
import multiprocessing
import os
from pathlib import Path
import resource
import sys
import tempfile
import threading
import time

from hunav_drake.report.suite_files import WriteSuite
from hunav_drake.runs import LoadSuite, RunSuite
from hunav_drake.runs.run_log import NAME

RUNS = 10_000

# A trial of 5 s, whose robot does not arrive before.
SUITE = """
name: many
scenarios: [crossing]
planners: [pursuit]
overrides: [simulation.duration=5.0]
seeds: {seeds}
"""

# After so many runs nobody allocates for the first time any more.
WARM = 200


@dataclass(frozen=True)
class Cost:
    """What was measured; memory in bytes, time in seconds.

    Attributes:
        driver: The growth of the resident memory of the process that gave out
            the runs, from `WARM` of them on.
        workers: That of each worker.
        resident: The resident memory of a worker at the end.
        seconds: How long it took.
        cpu: Processor time of this process until the last run had ended.
        size: The log on disk.
        reading: How long it took to read back.
        peak: How far reading and writing tables raised this process's memory.
        writing: How long it took to write all tables and the report.
    """

    driver: int
    workers: list[int]
    resident: int
    seconds: float
    cpu: float
    size: int
    reading: float
    peak: int
    writing: float


def resident(pid: int) -> int:
    """Returns the resident memory of a process."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * resource.getpagesize()


@contextmanager
def peak_resident(pid: int) -> Iterator[list[int]]:
    """Yields a list that has one item at the end: the most memory."""
    most = [resident(pid)]
    over = threading.Event()

    def watch() -> None:
        while not over.wait(0.02):
            most[0] = max(most[0], resident(pid))

    thread = threading.Thread(target=watch)
    thread.start()
    try:
        yield most
    finally:
        over.set()
        thread.join()


def measure(runs: int, folder: Path, workers: int = 2) -> Cost:
    """Runs a suite of many trials in worker processes."""
    suite = LoadSuite(data=SUITE.format(seeds=runs))
    here = os.getpid()
    samples: list[tuple[int, dict[int, int]]] = []

    def sample(row: object, done: int, total: int) -> None:
        if done % max(1, runs // 20) and done != total:
            return
        pids = [child.pid for child in multiprocessing.active_children()]
        found = {pid: resident(pid) for pid in pids if pid}
        samples.append((done, {here: resident(here), **found}))
        told = ", ".join(f"{found[pid] / 1e6:.1f}" for pid in found)
        if sys.stdout.isatty() or runs >= RUNS:
            print(
                f"{done:6} runs: driver {samples[-1][1][here] / 1e6:.1f} MB,"
                f" workers {told} MB",
                flush=True,
            )

    started, cpu = time.perf_counter(), time.process_time()
    result = RunSuite(suite, out=folder, workers=workers, progress=sample)
    seconds, cpu = time.perf_counter() - started, time.process_time() - cpu
    del result
    first = next(s for done, s in samples if done >= WARM)
    last = samples[-1][1]
    growth = {pid: last[pid] - first[pid] for pid in last if pid in first}
    before = resident(here)
    with peak_resident(here) as most:
        started = time.perf_counter()
        result = RunSuite(suite, out=folder)
        reading = time.perf_counter() - started
        assert len(result.runs()) == runs
        started = time.perf_counter()
        WriteSuite(result, folder)
        writing = time.perf_counter() - started
    return Cost(
        driver=growth.pop(here),
        workers=list(growth.values()),
        resident=max(m for pid, m in last.items() if pid != here),
        seconds=seconds,
        cpu=cpu,
        size=(folder / NAME).stat().st_size,
        reading=reading,
        peak=most[0] - before,
        writing=writing,
    )


def main() -> None:
    """Prints what a large suite costs."""
    with tempfile.TemporaryDirectory() as folder:
        cost = measure(RUNS, Path(folder))
    grown = ", ".join(f"{size / 1e6:+.1f}" for size in cost.workers)
    print(
        f"{RUNS} runs: {cost.seconds:.0f} s, {1e3 * cost.cpu / RUNS:.2f} ms of"
        f" the driver and {cost.size / RUNS / 1e3:.1f} kB of disk for each;"
        f" memory {cost.driver / 1e6:+.1f} MB (driver), {grown} MB (workers,"
        f" of {cost.resident / 1e6:.0f} MB); read back in {cost.reading:.1f} s,"
        f" tables and report written in {cost.writing:.1f} s, both with"
        f" {cost.peak / 1e6:.0f} MB more"
    )


if __name__ == "__main__":
    main()
