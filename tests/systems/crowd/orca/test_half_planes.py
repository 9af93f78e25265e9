"""Checked against general solvers of linear and quadratic programs."""

import math

from hypothesis import example, given, strategies as st
import numpy as np
import pytest
from scipy.optimize import minimize

from hunav_drake.systems.crowd.orca.half_planes import best_velocity

SPEED = 1.5


def make_rules(rows):
    """Makes rules of rows (angle of the normal, b)."""
    rows = np.asarray(rows, dtype=float).reshape(-1, 2)
    return np.column_stack([np.cos(rows[:, 0]), np.sin(rows[:, 0]), rows[:, 1]])


def choose(rules, hard=0, wanted=(1.0, 0.0), speed=SPEED):
    rules = np.array(rules, order="C")
    scratch = np.empty(rules.shape)
    return np.array(
        best_velocity(rules, hard, len(rules), speed, *wanted, scratch)
    )


def offence(rules, v):
    if len(rules) == 0:
        return 0.0
    return max(0.0, (rules[:, 2] - rules[:, :2] @ v).max())


def nearest_by_scipy(rules, wanted):
    """Returns the best of several starts of SLSQP, or None.

    Found under slightly stricter rules, so that it obeys these exactly.
    """
    strict = rules + np.array([0, 0, 1e-6])
    inside = {
        "type": "ineq",
        "fun": lambda v: (SPEED - 1e-6) ** 2 - v @ v,
        "jac": lambda v: -2 * v,
    }
    obeyed = {
        "type": "ineq",
        "fun": lambda v: strict[:, :2] @ v - strict[:, 2],
        "jac": lambda v: strict[:, :2],
    }
    best = None
    for start in ([0.0, 0.0], [0.7, 0.7], [-0.7, 0.7], [0.0, -0.9]):
        result = minimize(
            lambda v: np.sum((v - wanted) ** 2),
            start,
            jac=lambda v: 2 * (v - wanted),
            constraints=[inside, obeyed] if len(rules) else [inside],
            method="SLSQP",
            options={"ftol": 1e-14, "maxiter": 200},
        )
        v = result.x
        allowed = offence(rules, v) == 0 and v @ v <= SPEED**2
        if allowed and (best is None or result.fun < best[0]):
            best = result.fun, v
    return None if best is None else best[1]


def least_offence(rules, hard):
    """Returns the least largest offence of the rules from `hard` on.

    By bisection; whether an offence is possible is decided at the points where
    the edges of the eased rules meet each other and the circle.
    """

    def possible(eased):
        r = rules.copy()
        r[hard:, 2] -= eased
        corners = [np.zeros(2)]
        for i, (nx, ny, b) in enumerate(r):
            n, t = np.array([nx, ny]), np.array([-ny, nx])
            corners.append(b * n)
            if abs(b) <= SPEED:
                half = math.sqrt(SPEED**2 - b * b)
                corners += [b * n + half * t, b * n - half * t]
            for other in r[:i]:
                slope = other[:2] @ t
                if abs(slope) > 1e-9:
                    length = (other[2] - b * (other[:2] @ n)) / slope
                    corners.append(b * n + length * t)
        return any(
            offence(r, v) < 1e-10 and v @ v <= SPEED**2 + 1e-10 for v in corners
        )

    low, high = 0.0, 10.0
    if not possible(high):
        return None
    for _ in range(45):
        middle = (low + high) / 2
        low, high = (low, middle) if possible(middle) else (middle, high)
    return high


angles = st.floats(-math.pi, math.pi)
bounds = st.floats(-1.0, 1.8)
rule_rows = st.lists(st.tuples(angles, bounds), max_size=8)


def test_without_rules_the_wish_is_granted():
    np.testing.assert_array_equal(choose(make_rules([])), [1, 0])


def test_the_nearest_point_of_an_edge():
    rules = make_rules([(math.pi / 2, 0.5), (math.pi, -2.0)])
    np.testing.assert_allclose(choose(rules), [1, 0.5], atol=1e-15)


def test_a_corner_of_two_rules():
    rules = make_rules([(math.pi / 2, 0.5), (math.pi, -0.25)])
    np.testing.assert_allclose(choose(rules), [0.25, 0.5], atol=1e-15)


def test_where_an_edge_meets_the_circle():
    rules = make_rules([(math.pi / 2, 1.2)])
    np.testing.assert_allclose(choose(rules, wanted=(1.5, 0)), [0.9, 1.2])


def test_a_squeeze_is_shared_and_the_rest_of_the_wish_granted():
    """Two rules ask for at least 0.4 up and 0.2 down."""
    rules = make_rules([(math.pi / 2, 0.4), (-math.pi / 2, 0.2)])
    np.testing.assert_allclose(choose(rules), [1, 0.1], atol=1.1e-3)


def test_hard_rules_are_kept_in_a_squeeze():
    rules = make_rules([(math.pi / 2, 0.4), (-math.pi / 2, 0.2)])
    np.testing.assert_allclose(choose(rules, hard=1), [1, 0.4], atol=1.1e-3)
    assert choose(rules, hard=1)[1] >= 0.4 - 1e-11


def test_even_hard_rules_may_contradict_each_other():
    rules = make_rules([(0.0, 9.0), (math.pi, 8.0), (math.pi / 2, 0.3)])
    np.testing.assert_allclose(choose(rules, hard=2), [0.5, 0.3], atol=5e-3)


@given(rule_rows, angles, st.floats(0, SPEED))
@example([(0.0, 0.5), (math.pi, -0.5)], 1.0, 1.0)
@example([(1.0, 0.2), (1.0, 0.2), (1.0, 0.3)], 1.0, 0.1)
def test_it_is_the_nearest_velocity(rows, angle, length):
    rules = make_rules(rows)
    wanted = length * np.array([math.cos(angle), math.sin(angle)])
    v = choose(rules, wanted=wanted)
    assert math.hypot(*v) <= SPEED + 1e-9
    best = nearest_by_scipy(rules, wanted)
    if best is not None:
        assert offence(rules, v) < 1e-9
        assert math.dist(v, wanted) <= math.dist(best, wanted) + 1e-9


@given(rule_rows, st.integers(0, 3))
def test_the_largest_offence_is_the_least(rows, hard):
    rules = make_rules(rows)
    hard = min(hard, len(rules))
    best = least_offence(rules, hard)
    v = choose(rules, hard)
    if best is not None:
        assert offence(rules[:hard], v) < 1e-8
        eased = min(1e-3, best / 8)
        assert offence(rules[hard:], v) <= best + eased + 1e-8


@given(st.data())
def test_the_order_of_rules_does_not_matter(data):
    # Rules that differ by little more than rounding are parallel or not as
    # rounding decides; such corners are far away, or of no width.
    grid = st.tuples(st.integers(0, 35), st.integers(-9, 17))
    rows = data.draw(st.lists(grid, max_size=8))
    rules = make_rules([(0.1745 * a + 0.01, b / 10) for a, b in rows])
    order = data.draw(st.permutations(range(len(rules))))
    np.testing.assert_allclose(
        choose(rules[list(order)]), choose(rules), atol=1e-9
    )


@pytest.mark.parametrize("b", [1e3, 1e100, -1e100])
def test_rules_beyond_all_measure_stay_finite(b):
    rules = make_rules([(0.3, b), (2.0, b), (4.0, 0.1), (4.0, b)])
    v = choose(rules)
    assert np.isfinite(v).all()
    assert math.hypot(*v) <= SPEED + 1e-9


def test_who_must_not_move_does_not():
    rules = make_rules([(0.3, 0.5)])
    np.testing.assert_array_equal(
        choose(rules, wanted=(0.0, 0.0), speed=0.0), [0, 0]
    )
