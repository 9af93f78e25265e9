"""The smaller brother of `tests/benchmarks/bench_suite.py`."""

from pathlib import Path

import pytest

from tests.benchmarks.bench_suite import WARM, measure


@pytest.mark.slow
@pytest.mark.skipif(
    not Path("/proc/self/statm").exists(), reason="there is no /proc"
)
def test_memory_does_not_grow_with_runs(tmp_path):
    runs = WARM + 200
    cost = measure(runs, tmp_path)
    print(cost)
    # 200 rows as Python objects would be 10 MB, a diagram for each run more.
    assert cost.driver < 5e6
    # The other worker may just have begun when it was first looked at.
    assert min(cost.workers) < 10e6
    assert cost.size < 10e3 * runs
