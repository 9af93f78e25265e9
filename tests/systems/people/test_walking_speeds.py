"""Speeds by age and sex, and whether people walk at them."""

import dataclasses

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest
from scipy import stats

from hunav_drake.systems.people.area import Area
from hunav_drake.systems.people.population import draw_bodies, draw_population
from hunav_drake.systems.people.population_config import (
    AgeBand,
    CohortConfig,
    PopulationConfig,
    SpeedDistribution,
)
from hunav_drake.systems.people.walking_speeds import (
    mean_walking_speed,
    normal_quantiles,
    walking_speed_deviation,
)
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.trial.humans import MakeHumans

FIELD = Area(rectangle=[0, 0, 100, 100])
# The distribution of speeds in deviations from the mean.
CUT_NORMAL = stats.truncnorm(-3, 3)


def people_of_age(low, high, number=4000, **values):
    cohort = CohortConfig(
        number=number,
        start=[FIELD],
        ages=[AgeBand(low=low, high=high)],
        **values,
    )
    return draw_bodies(cohort, seed=1)


@pytest.mark.parametrize(
    ("age", "speed"),
    [(3, 0.58), (20, 1.61), (30, 1.54), (50, 1.41), (80, 0.68)],
)
def test_the_mean_is_that_of_the_guideline(age, speed):
    both = mean_walking_speed(age, [True, False])
    assert both.mean() == pytest.approx(speed)


@pytest.mark.parametrize(
    ("low", "high", "least", "most"),
    [(20, 30, 1.54, 1.61), (30, 50, 1.41, 1.54), (50, 80, 0.68, 1.41)],
)
def test_the_mean_is_within_the_bands_of_the_guideline(low, high, least, most):
    ages = np.linspace(low, high, 100)[:, None]
    both = mean_walking_speed(ages, [True, False]).mean(axis=1)
    assert least - 1e-9 <= both.min()
    assert both.max() <= most + 1e-9


def test_men_are_faster_than_women_as_in_the_table():
    men, women = (
        people_of_age(18, 80, share_of_women=share).speeds.mean()
        for share in (0, 1)
    )
    assert men / women == pytest.approx(1.41 / 1.27, abs=0.01)


def test_adults_walk_as_measured_over_all_ages():
    speeds = people_of_age(18, 80).speeds
    assert speeds.mean() == pytest.approx(1.34, abs=0.05)
    # Of 18 to 80 years in equal parts, there are more old ones than in the
    # streets.
    assert 0.26 < speeds.std() < 0.40


def test_those_of_30_differ_as_in_the_guideline():
    speeds = people_of_age(30, 30).speeds
    assert speeds.mean() == pytest.approx(1.52, abs=0.03)
    assert 0.27 < speeds.std() < 0.33


def test_quantiles_are_those_of_a_normal_distribution_that_is_cut_off():
    p = np.array([0.0, 0.1, 0.5, 0.9, 1.0])
    expected = stats.truncnorm(-3, 3, loc=1.2, scale=0.2).ppf(p)
    np.testing.assert_allclose(normal_quantiles(p, 1.2, 0.2), expected)
    np.testing.assert_array_equal(
        normal_quantiles(p, 1.2, 0.0), np.full(5, 1.2)
    )


def test_bands_of_ages_count_by_their_weights():
    bands = [
        AgeBand(low=20, high=30, weight=1),
        AgeBand(low=60, high=80, weight=3),
    ]
    cohort = CohortConfig(number=2000, start=[FIELD], ages=bands)
    p_values = []
    # Of several seeds the median: of one, it is low now and then.
    for seed in range(5):
        ages = draw_bodies(cohort, seed).ages
        assert np.mean(ages > 45) == pytest.approx(0.75, abs=0.05)
        old = ages[ages > 45]
        p_values.append(stats.kstest((old - 60) / 20, "uniform").pvalue)
    assert np.median(p_values) > 0.05


def walked_speeds(cohort, seed):
    """Returns the free speeds of people of a population, in m/s."""
    config = PopulationConfig(seed=seed, cohorts=[cohort])
    no_walls = Obstacles.from_shapes([], solid=[])
    people = [
        dataclasses.replace(
            human,
            pose=(*human.pose[:2], 0.0),
            goals=[(human.pose[0] + 1000.0, human.pose[1])],
        )
        for human in draw_population(config, no_walls)
    ]
    diagram = MakeHumans(people, num_robots=0)
    simulator = Simulator(diagram)
    states = diagram.GetOutputPort("human_states")
    x = []
    for time in (6.0, 9.0):
        simulator.AdvanceTo(time)
        x.append(states.Eval(simulator.get_context()).reshape(-1, 7)[:, 0])
    return (x[1] - x[0]) / 3.0


def test_rimea_7_fifty_adults_walk_by_the_curve_of_their_ages():
    """RiMEA 7: of 50 adults, the speeds go with the curve."""
    p_values, pooled = [], []
    for seed in range(3):
        cohort = CohortConfig(number=50, start=[FIELD], goals=[FIELD])
        speeds = walked_speeds(cohort, seed)
        bodies = draw_bodies(cohort, seed)
        mean = mean_walking_speed(bodies.ages, bodies.is_woman)
        # In deviations from the mean of their age and sex.
        scores = (speeds - mean) / walking_speed_deviation(mean)
        p_values.append(stats.kstest(scores, CUT_NORMAL.cdf).pvalue)
        pooled += scores.tolist()
        # Those of the age they are, not of another's.
        assert np.corrcoef(speeds, mean)[0, 1] > 0.5
    assert np.median(p_values) > 0.05
    assert np.mean(pooled) == pytest.approx(0, abs=0.2)
    assert np.std(pooled) == pytest.approx(1, abs=0.15)


def test_nist_2_4_a_hundred_people_walk_as_their_distribution():
    """NIST TN 1822, Verif. 2.4: N(1.2, 0.2) m/s in a room of 100 m."""
    speed = SpeedDistribution(mean=1.2, deviation=0.2)
    cohort = CohortConfig(number=100, start=[FIELD], goals=[FIELD], speed=speed)
    samples = [walked_speeds(cohort, seed) for seed in range(3)]
    expected = stats.truncnorm(-3, 3, loc=1.2, scale=0.2)
    p_values = [stats.kstest(it, expected.cdf).pvalue for it in samples]
    assert np.median(p_values) > 0.05
    assert np.mean(samples) == pytest.approx(1.2, abs=0.05)
    assert np.std(samples) == pytest.approx(0.2, abs=0.05)
