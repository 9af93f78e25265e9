"""People are bodies in any trial: see `tests/random_trials.py`."""

import pytest

from tests.random_trials import is_good, run_trial, run_world


@pytest.mark.parametrize("seed", range(500, 504))
def test_bodies_in_a_random_trial(seed):
    worst = run_trial(seed)
    assert is_good(worst), worst


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 60, 20))
def test_bodies_in_many_random_trials(first):
    for seed in range(first, first + 20):
        worst = run_trial(seed)
        assert is_good(worst), (seed, worst)


@pytest.mark.slow
@pytest.mark.parametrize("planner", ["scl", "dwb", "sfm"])
def test_bodies_with_other_planners(planner):
    for seed in range(3):
        worst = run_trial(seed, planner)
        assert is_good(worst), (seed, worst)


@pytest.mark.parametrize("seed", range(500, 502))
def test_a_random_world(seed):
    """With walls, furniture, robot, sensors, people drawn from the schema."""
    worst = run_world(seed)
    assert is_good(worst), worst


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 40, 20))
def test_many_random_worlds(first):
    for seed in range(first, first + 20):
        worst = run_world(seed)
        assert is_good(worst), (seed, worst)
