"""Those who bar a way are the ones that a look at everybody finds."""

import math

from hypothesis import given, strategies as st
import numpy as np

from hunav_drake.systems.common.layout import RADIUS, VX, VY, X, Y
from hunav_drake.systems.people.standing import bar_the_way, find_standing

GAP = 0.3


def bars(people, i, goal, least):
    """Whether people (n, 7) who stand bar the way of person i, one by one."""
    state = people[i]
    distance = math.dist(state[:2], goal)
    away = np.hypot(people[:, X] - goal[0], people[:, Y] - goal[1])
    speed = np.hypot(people[:, VX], people[:, VY])
    them = people[(away < distance) & (speed < 0.1)]
    offset = them[:, :2] - state[:2]
    near = np.hypot(*offset.T) - (them[:, RADIUS] + state[RADIUS]) <= GAP
    ahead = offset @ (goal - state[:2]) > 0
    return len(them) >= least and bool((near & ahead).any())


def rows_of(people):
    found = np.empty(3 * len(people))
    count = find_standing(people.ravel(), found)
    return found[: 3 * count].reshape(-1, 3)


def barred(standing, people, i, goal, least):
    x, y, radius = people[i, [X, Y, RADIUS]]
    distance = math.dist((x, y), goal)
    return bar_the_way(standing, x, y, radius, *goal, distance, GAP, least)


def crowd(n, density, seed):
    """People of whom half stand, shape (n, 7)."""
    rng = np.random.default_rng(seed)
    people = np.zeros((n, 7))
    people[:, :2] = rng.uniform(0, math.sqrt(n / density), (n, 2))
    people[:, VX] = rng.choice([0.0, 0.09, 0.2], n)
    people[:, RADIUS] = rng.uniform(0.2, 0.4, n)
    return people


def test_a_crowd_bars_ways_as_its_people_do_one_by_one():
    found = 0
    for seed in range(20):
        people = crowd(60, 1.0, seed)
        standing = rows_of(people)
        rng = np.random.default_rng(seed)
        for i in range(len(people)):
            goal, least = rng.uniform(0, 8, 2), rng.uniform(0, 12)
            expected = bars(people, i, goal, least)
            assert barred(standing, people, i, goal, least) == expected
            found += expected
    assert 200 < found < 1000


places = st.tuples(st.integers(-3, 3), st.integers(-3, 3))


@given(st.lists(places, min_size=1, max_size=8), places, st.integers(0, 3))
def test_people_on_a_grid_bar_ways_as_they_do_one_by_one(at, goal, least):
    """Many are equally near, and some stand on one another, or on the goal."""
    people = np.zeros((len(at), 7))
    people[:, :2] = np.array(at) / 2
    people[:, RADIUS] = 0.35
    goal = np.array(goal) / 2
    standing = rows_of(people)
    for i in range(len(people)):
        assert barred(standing, people, i, goal, least) == bars(
            people, i, goal, least
        )


def test_nobody_bars_a_way():
    nobody = rows_of(np.zeros((0, 7)))
    assert not bar_the_way(nobody, 0, 0, 0.3, 1, 0, 1.0, GAP, 0.0)
