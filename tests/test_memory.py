"""Trials that are over leave no memory behind."""

from pathlib import Path

import pytest

from tests.processes import run_python

STATM = Path("/proc/self/statm")
WARM_UP = 20
CYCLES = 100

# Runs in an interpreter of its own, whose memory nothing else fills.
CODE = f"""
import gc
from pathlib import Path
import resource

from hunav_drake import (LoadScenario, RunTrial)

scenario = LoadScenario(
    filename="passing", overrides=["simulation.duration=1.0"]
)


def resident():
    pages = int(Path({str(STATM)!r}).read_text().split()[1])
    return pages * resource.getpagesize()


# A diagram and its systems refer to each other: only the garbage collector
# ends them, and it does not know how much memory hangs on them.
def run(cycles):
    for seed in range(cycles):
        RunTrial(scenario, seed)
        gc.collect()


run({WARM_UP})
before = resident()
run({CYCLES})
print(resident() - before)
"""


@pytest.mark.slow
@pytest.mark.skipif(not STATM.exists(), reason=f"there is no {STATM}")
def test_trials_that_are_over_leave_no_memory_behind():
    output = run_python(CODE).stdout
    growth = int(output) / 1e6
    print(f"resident memory grows by {growth:.2f} MB over {CYCLES} trials")
    assert growth < 2.5
