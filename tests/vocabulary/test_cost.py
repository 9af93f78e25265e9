"""What it costs to take notice of signals: see `bench_signals`."""

import pytest

from tests.benchmarks.bench_signals import seconds_per_step


@pytest.mark.slow
@pytest.mark.parametrize("count", [5, 100])
def test_38_ten_nodes_with_signals_take_half_as_long_again_at_most(count):
    social, plain = seconds_per_step(count)
    assert social < 1.5 * plain
