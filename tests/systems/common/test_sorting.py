from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.common.sorting import stable_order


@pytest.mark.parametrize("n", [0, 1, 2, 15, 16, 17, 32, 33, 100, 1000])
def test_is_that_of_numpy(n):
    values = np.random.default_rng(n).integers(0, 40, n).astype(float)
    order = stable_order(values)
    np.testing.assert_array_equal(order, np.argsort(values, kind="stable"))


@given(st.lists(st.floats(allow_nan=False), max_size=80))
def test_is_stable_for_any_numbers(values):
    values = np.array(values, dtype=float)
    order = stable_order(values)
    np.testing.assert_array_equal(order, np.argsort(values, kind="stable"))
