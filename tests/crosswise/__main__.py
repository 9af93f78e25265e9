"""Runs trials of every choice with every other, and prints what fails.

`python -m tests.crosswise` runs rows that have each pair of choices at least
once; with `--count 1000 --seed 7`, so many rows drawn from all that there are.
"""

import argparse
from concurrent.futures import ThreadPoolExecutor
import resource
import shlex
import sys
import time

from tests.crosswise.children import run_apart
from tests.crosswise.factors import Row, overrides
from tests.crosswise.rows import pair_rows, random_rows, refused_rows
from tests.crosswise.trial import run_row


def command_of(row: Row) -> str:
    """Returns what runs the trial of a row at a prompt."""
    settings = (f"--set {shlex.quote(it)}" for it in overrides(row))
    end = f"# {row['view']}, {row['format']}"
    return " ".join(["hunav run", row["scenario"], *settings, end])


def main() -> None:
    """Runs rows, and prints those that fail."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, help="rows that are drawn")
    parser.add_argument("--seed", type=int, default=0, help="what draws them")
    parser.add_argument("--first", type=int, default=0, help="the first row")
    parser.add_argument("--last", type=int, help="the one after the last")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    options = parser.parse_args()
    if options.count is None:
        rows = [*pair_rows(), *refused_rows()]
    else:
        rows = list(random_rows(options.count, options.seed))
    last = min(options.last or len(rows), len(rows))
    started = time.monotonic()
    times: list[tuple[float, int]] = []

    def work(part: int) -> int:
        failed, before = 0, time.monotonic()
        numbers = range(options.first + part, last, options.jobs)
        found = run_apart(run_row, (rows[i] for i in numbers))
        for i, (row, failure) in zip(numbers, found, strict=True):
            now = time.monotonic()
            times.append((now - before, i))
            before = now
            print(f"row {i}: {times[-1][0]:.1f} s", file=sys.stderr, flush=True)
            if failure:
                failed += 1
                print(f"{i}: {command_of(row)}\n{failure}", flush=True)
        return failed

    with ThreadPoolExecutor(options.jobs) as pool:
        failed = sum(pool.map(work, range(options.jobs)))
    for seconds, i in sorted(times)[-10:]:
        print(f"row {i} took {seconds:.1f} s ({rows[i]['planner']})")
    seconds = time.monotonic() - started
    cpu = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(
        f"{failed} of {len(times)} rows failed, in {seconds:.0f} s"
        f" ({cpu.ru_utime + cpu.ru_stime:.0f} s of CPU time)"
    )
    raise SystemExit(failed > 0)


if __name__ == "__main__":
    main()
