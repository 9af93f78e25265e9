"""Thousands of inputs with something wrong: none may end uncleanly.

`python -m tests.reliability.mutated_inputs 6000` tries so many, and prints
those that do: with a traceback or words of a fault of this package, by a
crash, in over 20 s or 2 GB, with a message of over 4000 letters, or accepted
by one command and refused by the next.
"""

import argparse
from collections import Counter
from collections.abc import Iterable, Iterator
import contextlib
import io
import json
import os
from pathlib import Path
import re
import resource
import select
import subprocess
import sys
import tempfile
import time
from typing import NamedTuple

import numpy as np

from tests.memory import peak_memory

_MODULE = "tests.reliability.mutated_inputs"
ROOT = Path(__file__).resolve().parents[2]

# In seconds, of the processor; a busy machine gets some times as many.
_TIME = 20.0
_HANG = 120.0
# In bytes, of which the program itself takes half a GB.
_MEMORY = 2.5e9
_LONGEST = 4000

_FAULT = re.compile(
    r"may be a bug|Traceback|\b(Key|Index|Type|Attribute|Assertion|Value"
    r"|ZeroDivision|Unicode\w*|Overflow|Recursion|Memory|Runtime)Error\b"
)


class Outcome(NamedTuple):
    """What became of an input.

    Attributes:
        kind: Its kind.
        seed: What it was drawn from.
        state: "accepted", "refused", or "unclean".
        told: What was printed last, or what is unclean about it.
    """

    kind: str
    seed: int
    state: str
    told: str


def try_inputs(kind: str, seeds: Iterable[int]) -> Iterator[Outcome]:
    """Tries inputs of a kind, in child processes that may die."""
    left = list(seeds)
    while left:
        with tempfile.TemporaryDirectory() as folder:
            words = [kind, folder, *map(str, left)]
            child = subprocess.Popen(
                [sys.executable, "-m", _MODULE, "--child", *words],
                cwd=ROOT,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )
            for line in _lines(child):
                yield (found := Outcome(*json.loads(line)))
                left.remove(found.seed)
            child.kill()
            code = child.wait()
        if left:
            how = "a hang" if code == -9 else f"a crash ({code})"
            yield Outcome(kind, left.pop(0), "unclean", how)


def _lines(child: "subprocess.Popen[bytes]") -> Iterator[bytes]:
    assert child.stdout is not None
    while select.select([child.stdout], [], [], _HANG)[0]:
        line = child.stdout.readline()
        if not line:
            child.wait(_HANG)
            return
        yield line


def _be_child(kind: str, folder: str, seeds: Iterable[int]) -> None:
    """Tries inputs here, and writes a line on each to the parent."""
    from tests.reliability.inputs import KINDS

    parent = os.dup(1)
    # What native code prints is not for the parent.
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    resource.setrlimit(resource.RLIMIT_DATA, (int(2 * _MEMORY), hard))
    os.chdir(folder)
    for seed in seeds:
        place = Path(folder) / str(seed)
        place.mkdir()
        rng = np.random.default_rng([seed, *kind.encode()])
        started = time.process_time()
        with np.errstate(all="ignore"):
            steps = KINDS[kind](rng, place)
            state, told = verdict(steps, str(place))
        took = time.process_time() - started
        peak = peak_memory()
        if took > _TIME:
            state, told = "unclean", f"{took:.0f} s: {told}"
        elif peak > _MEMORY:
            state, told = "unclean", f"{peak / 1e9:.1f} GB: {told}"
        line = json.dumps([kind, seed, state, told[-2000:]])
        os.write(parent, f"{line}\n".encode())
        if peak > _MEMORY:
            return


def verdict(steps, place: str) -> tuple[str, str]:
    """Returns what becomes of an input, and what was told: see `Outcome`.

    Args:
        steps: Who reads it: see `tests.reliability.inputs`.
        place: Its folder, which makes no message long.
    """
    from hunav_drake.commands.cli import main

    for number, step in enumerate(steps):
        out, err = io.StringIO(), io.StringIO()
        try:
            with (
                contextlib.redirect_stdout(out),
                contextlib.redirect_stderr(err),
            ):
                code = main(step) if isinstance(step, list) else _call(step)
        # That nothing gets here is what is tested.
        except BaseException as error:
            return "unclean", f"{type(error).__name__}: {error}"
        told = err.getvalue().replace(place, "PLACE")
        longest = max(map(len, told.splitlines()), default=0)
        if (
            _FAULT.search(told)
            or longest > _LONGEST
            or code not in (0, 1, 2)
            or (code == 2 and not told.strip())
        ):
            return "unclean", f"{code}: {told}"
        if code == 2:
            late = number and isinstance(step, list) and step[0] == "run"
            return "unclean" if late else "refused", told
        if fault := re.search(r"\b[A-Z]\w+Error: .*", out.getvalue()):
            return "unclean", fault[0]
    return "accepted", ""


def _call(step) -> int:
    try:
        step()
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


def main() -> None:
    """Tries inputs, and prints those that end uncleanly, and counts."""
    from concurrent.futures import ThreadPoolExecutor

    from tests.reliability.inputs import KINDS

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, help="how many, of all kinds")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--kind", nargs="+", choices=KINDS, help="only these")
    parser.add_argument("--processes", type=int, default=1)
    options = parser.parse_args()
    kinds = options.kind or list(KINDS)
    each = -(-options.count // len(kinds))

    def try_kind(kind: str) -> list[Outcome]:
        found = []
        for outcome in try_inputs(
            kind, range(options.first, options.first + each)
        ):
            found.append(outcome)
            if outcome.state == "unclean":
                print(*outcome[:3], outcome.told[-600:], flush=True)
        counts = dict(Counter(it.state for it in found))
        print(f"{kind}: {counts}", flush=True)
        return found

    with ThreadPoolExecutor(options.processes) as pool:
        states = [it.state for part in pool.map(try_kind, kinds) for it in part]
    print(f"{states.count('unclean')} of {len(states)} inputs end uncleanly")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        _be_child(sys.argv[2], sys.argv[3], map(int, sys.argv[4:]))
    else:
        main()
