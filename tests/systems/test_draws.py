from hypothesis import given
from hypothesis import strategies as st
import numpy as np

from hunav_drake.systems.draws import Purpose, draw_uniform


@given(st.integers(0, 2**63 - 1), st.integers(0, 2**31 - 1))
def test_draws_repeat_and_differ_between_people(seed, human_id):
    numbers = draw_uniform(seed, human_id, Purpose.START_JITTER, 4)
    again = draw_uniform(seed, human_id, Purpose.START_JITTER, 4)
    np.testing.assert_array_equal(numbers, again)
    assert ((numbers >= 0) & (numbers < 1)).all()
    other = draw_uniform(seed, human_id + 1, Purpose.START_JITTER, 4)
    later = draw_uniform(seed, human_id, Purpose.START_JITTER, 4, tick=1)
    assert (numbers != other).all()
    assert (numbers != later).all()


def test_draws_fill_the_range():
    numbers = [draw_uniform(0, i, Purpose.START_JITTER, 2) for i in range(2000)]
    counts, _ = np.histogram(numbers, bins=10, range=(0, 1))
    assert abs(counts - 400).max() < 100
