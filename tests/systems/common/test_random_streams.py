from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.common.random_streams import (
    Purpose,
    draw_normal,
    draw_uniform,
)


@given(st.integers(0, 2**63 - 1), st.integers(0, 2**31 - 1))
def test_draws_repeat_and_differ_between_people(seed, human_id):
    numbers = draw_uniform(seed, [human_id], Purpose.START_JITTER, 4)
    other, again = draw_uniform(
        seed, [human_id + 1, human_id], Purpose.START_JITTER, 4
    )
    np.testing.assert_array_equal(numbers[0], again)
    assert ((numbers >= 0) & (numbers < 1)).all()
    otherwise = draw_uniform(seed, [human_id], Purpose.WEIGHTS_UNIFORM, 4)
    assert (numbers != other).all()
    assert (numbers != otherwise).all()


@pytest.mark.parametrize("seed", [-1, 1.5, 2**63, 2**70, True, "1", None])
def test_a_seed_is_a_whole_number_of_63_bits(seed):
    with pytest.raises(ValueError, match=r"in \[0, 2\^63\), got"):
        draw_uniform(seed, [1], Purpose.START_JITTER, 4)


def test_a_seed_may_be_an_integer_of_numpy():
    np.testing.assert_array_equal(
        draw_uniform(np.int64(7), [1], Purpose.START_JITTER, 4),
        draw_uniform(7, [1], Purpose.START_JITTER, 4),
    )


def test_draws_fill_the_range():
    numbers = draw_uniform(0, range(2000), Purpose.START_JITTER, 2)
    counts, _ = np.histogram(numbers, bins=10, range=(0, 1))
    assert abs(counts - 400).max() < 100


def test_nobody_draws_nothing():
    assert draw_uniform(0, [], Purpose.START_JITTER, 2).shape == (0, 2)
    assert draw_normal(0, [], Purpose.WEIGHTS_NORMAL, 3).shape == (0, 3)


def test_each_step_has_a_stream_of_its_own():
    key, counter = [5, 2], [0, 0, int(Purpose.LIDAR_NOISE), 9]
    stream = np.random.Generator(np.random.Philox(key=key, counter=counter))
    (draws,) = draw_normal(5, [2], Purpose.LIDAR_NOISE, 4, step=9)
    np.testing.assert_array_equal(draws, stream.standard_normal(4))
    (others,) = draw_normal(5, [2], Purpose.LIDAR_NOISE, 4, step=10)
    assert (draws != others).all()


def test_a_stream_is_philox_by_seed_person_and_purpose():
    """So other programs can draw the same numbers."""
    key, counter = [5, 8], [0, 0, int(Purpose.WEIGHTS_NORMAL), 0]
    stream = np.random.Generator(np.random.Philox(key=key, counter=counter))
    draws = draw_normal(5, [3, 8], Purpose.WEIGHTS_NORMAL, 7)
    np.testing.assert_array_equal(draws[1], stream.standard_normal(7))
