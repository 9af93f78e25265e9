"""People are bodies in any trial: see `tests/random_trials.py`."""

import pytest

from tests.random_trials import is_good, run_trial, run_world


def many(run, count):
    """Returns the parameters of so many trials, 20 at a time."""
    return [
        pytest.param(run, range(first, first + 20), marks=pytest.mark.slow)
        for first in range(0, count, 20)
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("run", "seeds"),
    [
        *((run_trial, [seed]) for seed in range(500, 504)),
        # Walls, furniture, robot, sensors, people drawn from the schema.
        *((run_world, [seed]) for seed in range(500, 502)),
        *many(run_trial, 60),
        *many(run_world, 40),
    ],
)
def test_bodies_in_random_trials(run, seeds):
    for seed in seeds:
        worst = run(seed)
        assert is_good(worst), (seed, worst)


@pytest.mark.slow
@pytest.mark.parametrize("planner", ["scl", "dwb", "sfm"])
def test_bodies_with_other_planners(planner):
    for seed in range(3):
        worst = run_trial(seed, planner)
        assert is_good(worst), (seed, worst)
