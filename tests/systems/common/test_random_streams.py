from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.common.random_streams import Purpose, draw_uniform


@given(st.integers(0, 2**63 - 1), st.integers(0, 2**31 - 1))
def test_draws_repeat_and_differ_between_people(seed, human_id):
    numbers = draw_uniform(seed, human_id, Purpose.START_JITTER, 4)
    again = draw_uniform(seed, human_id, Purpose.START_JITTER, 4)
    np.testing.assert_array_equal(numbers, again)
    assert ((numbers >= 0) & (numbers < 1)).all()
    other = draw_uniform(seed, human_id + 1, Purpose.START_JITTER, 4)
    otherwise = draw_uniform(seed, human_id, Purpose.WEIGHTS_UNIFORM, 4)
    assert (numbers != other).all()
    assert (numbers != otherwise).all()


@pytest.mark.parametrize("seed", [-1, 1.5, 2**63, 2**70, True, "1", None])
def test_a_seed_is_a_whole_number_of_63_bits(seed):
    with pytest.raises(ValueError, match=r"in \[0, 2\^63\), got"):
        draw_uniform(seed, 1, Purpose.START_JITTER, 4)


def test_a_seed_may_be_an_integer_of_numpy():
    np.testing.assert_array_equal(
        draw_uniform(np.int64(7), 1, Purpose.START_JITTER, 4),
        draw_uniform(7, 1, Purpose.START_JITTER, 4),
    )


def test_draws_fill_the_range():
    numbers = [draw_uniform(0, i, Purpose.START_JITTER, 2) for i in range(2000)]
    counts, _ = np.histogram(numbers, bins=10, range=(0, 1))
    assert abs(counts - 400).max() < 100
