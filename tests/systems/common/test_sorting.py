import math

from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.common.sorting import (
    heap_between,
    pop_least,
    stable_order,
)


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


numbers = st.lists(st.integers(-5, 5) | st.just(math.inf), max_size=60)


@given(numbers, st.integers(-6, 6), st.integers(-6, 6) | st.just(math.inf))
def test_a_heap_gives_those_between_two_keys_from_the_least_on(
    values, low, high
):
    keys = np.array(values, dtype=float)
    heap, places = np.empty((2, len(keys)), dtype=np.int64)
    count = heap_between(float(low), float(high), keys, heap, places)
    popped = [pop_least(keys, heap, places, k) for k in range(count, 0, -1)]
    ordered = stable_order(keys)
    assert popped == [i for i in ordered if low <= keys[i] < high]
