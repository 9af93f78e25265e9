"""Functions that are called late are compiled when they are first needed."""

import numpy as np
import pytest

from tests.memory import needs_linux, peak_memory, reset_peak_memory
from tests.processes import run_python
from tests.systems.common.late_kernels import scaled, twice_scaled

_VECTOR = np.array([1.0, 2.0])

_IN_A_NEW_PROCESS = """
import numpy as np
from tests.systems.common.late_kernels import scaled, twice_scaled
vector = np.array([1.0, 2.0])
print(*twice_scaled(vector, 0.0), len(scaled.overloads))
print(*twice_scaled(vector, 3.0), len(scaled.overloads))
"""


@pytest.mark.slow
def test_it_is_compiled_at_the_first_call_also_of_a_caller_from_disk():
    for _ in range(2):
        lines = run_python(_IN_A_NEW_PROCESS).stdout.splitlines()
        assert lines == ["0.0 0.0 0", "6.0 12.0 1"]


def test_python_calls_it_as_any_kernel():
    assert scaled(_VECTOR, 3).tolist() == [3.0, 6.0]
    with pytest.raises(TypeError, match="expected 2, got 1"):
        scaled(_VECTOR)


def test_what_it_raises_passes_its_caller():
    with pytest.raises(ValueError, match="the factor is too large"):
        twice_scaled(_VECTOR, 1000.0)


@pytest.mark.slow
def test_one_that_cannot_be_compiled_is_told():
    code = """
from tests.systems.common import late_kernels
import numpy as np
def fail():
    raise KeyboardInterrupt
late_kernels.scaled.compiled = fail
try:
    late_kernels.twice_scaled(np.ones(1), 2.0)
except RuntimeError as error:
    print(error)
"""
    told = run_python(code).stdout
    assert "late_kernels:scaled was not compiled" in told


@needs_linux
def test_its_results_take_no_memory_for_ever():
    large = np.ones(1000)
    twice_scaled(large, 2.0)
    before = reset_peak_memory()
    for _ in range(50_000):
        twice_scaled(large, 2.0)
    # If one array of 8 KB were kept each time, 400 MB.
    assert peak_memory() - before < 40e6
