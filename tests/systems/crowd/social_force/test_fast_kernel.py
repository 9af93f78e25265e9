"""The fast kernel agrees with the reference, and says how well."""

import dataclasses
import math
import platform
import re

from hypothesis import given, settings, strategies as st
import numba
import numpy as np
import pytest

from hunav_drake.systems.crowd import SocialForceModel
from hunav_drake.systems.crowd.social_force.elementary import (
    arctan2,
    exp_negative,
)
from hunav_drake.systems.crowd.social_force.fast_kernel import people_forces
from hunav_drake.systems.people.parameters import SocialForceParameters
from tests.systems.crowd.crowds import make_snapshot, random_states

PARAMETERS = np.array(dataclasses.astuple(SocialForceParameters()))


@numba.njit
def map_exp(x):
    return np.array([exp_negative(value) for value in x])


@numba.njit
def map_arctan2(y, x):
    return np.array([arctan2(y[i], x[i]) for i in range(len(x))])


def social(states, parameters=None, **options):
    """Returns the social forces, shape (n, 2)."""
    snapshot = make_snapshot(
        states, states[:, :2], radius=0.35, parameters=parameters
    )
    return SocialForceModel(**options).forces(snapshot)[:, 4:6]


def test_exp_is_right_to_the_last_digits():
    x = np.concatenate([-np.geomspace(1e-300, 700, 40001), [0.0]])
    expected = np.exp(x.astype(np.longdouble))
    error = np.abs(map_exp(x) / expected - 1)
    print(f"largest relative error of exp: {error.max():.2e}")
    assert error.max() < 4e-16


@pytest.mark.parametrize("x", [-701.0, -1e10, -1e300])
def test_exp_of_very_little_is_very_little(x):
    assert 0 <= map_exp(np.array([x]))[0] < 1e-300


def test_arctan2_is_right_to_the_last_digits():
    angle = np.linspace(-np.pi, np.pi, 40001)[1:]
    radius = np.geomspace(1e-100, 1e100, len(angle))
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    expected = np.arctan2(y.astype(np.longdouble), x.astype(np.longdouble))
    error = np.abs(map_arctan2(y, x) - expected)
    print(f"largest absolute error of arctan2: {error.max():.2e} rad")
    assert error.max() < 9e-16


@pytest.mark.parametrize(
    ("y", "x"), [(0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (-1, -1)]
)
def test_arctan2_knows_the_axes(y, x):
    result = map_arctan2(np.array([float(y)]), np.array([float(x)]))
    assert result[0] == pytest.approx(math.atan2(y, x), abs=1e-15)


@pytest.mark.parametrize("n", [2, 3, 8, 20, 47, 48, 200])
@pytest.mark.parametrize("alike", [True, False])
def test_nothing_left_out_agrees_with_the_reference(n, alike):
    states = random_states(n)
    parameters = np.tile(PARAMETERS, (n, 1))
    if not alike:
        parameters[:, 4:10] *= np.random.default_rng(1).uniform(
            0.5, 1.5, (n, 6)
        )
    reference = social(states, parameters, kernel="reference")
    fast = social(states, parameters, error_bound=0.0)
    np.testing.assert_allclose(fast, reference, rtol=1e-12, atol=1e-12)


coordinate = st.floats(-3, 3) | st.sampled_from([0.0, 1.0, 1e4, -1e5, 1e-12])
speed = st.floats(-3, 3) | st.sampled_from([0.0, 1.0, -1.0, 1e3, -1e5])
people = st.lists(
    st.tuples(coordinate, coordinate, speed, speed), min_size=0, max_size=9
)


@given(people)
def test_agrees_and_stays_finite_wherever_people_are(rows):
    states = np.zeros((len(rows), 6))
    if rows:
        states[:, [0, 1, 3, 4]] = rows
    reference = social(states, kernel="reference")
    fast = social(states)
    assert np.isfinite(reference).all()
    assert np.isfinite(fast).all()
    # Where rounding decides the side, the two may differ in the side.
    for i, j in zip(*np.nonzero(abs(fast - reference) > 1e-9), strict=True):
        del j
        assert has_a_tie(states, i)


def has_a_tie(states, i):
    """Returns whether an angle is near a jump of its sign."""
    d = states[:, :2] - states[i, :2]
    r = np.hypot(*d.T)
    n = d / np.where(r > 0, r, 1)[:, None]
    interaction = 2 * (states[i, 3:5] - states[:, 3:5]) + n
    length = np.hypot(*interaction.T)
    cross = interaction[:, 0] * n[:, 1] - interaction[:, 1] * n[:, 0]
    dot = (interaction * n).sum(axis=1)
    theta = np.arctan2(cross, dot) + 0.005 * 0.35 * length
    theta = np.remainder(theta + np.pi, 2 * np.pi) - np.pi
    near = np.minimum(abs(theta), np.pi - abs(theta)) * (0.35 * length + 1)
    near = np.where(length < 1e-9, 0, near)
    return np.delete(near, i).min(initial=1) < 1e-6


@settings(max_examples=40)
@given(
    st.integers(48, 400),
    st.floats(0.01, 5.0),
    st.floats(0.0, 20.0),
    st.sampled_from([1e-9, 1e-6, 1e-3, 0.1]),
    st.integers(0, 2**32 - 1),
)
def test_what_is_left_out_stays_below_the_bound(n, density, top, bound, seed):
    states = random_states(n, density=density, fastest=top, seed=seed)
    rng = np.random.default_rng(seed)
    parameters = np.tile(PARAMETERS, (n, 1))
    if seed % 2:
        parameters[:, 4:10] *= rng.uniform(0.2, 3.0, (n, 6))
    exact = social(states, parameters, error_bound=0.0)
    fast = social(states, parameters, error_bound=bound)
    assert np.hypot(*(fast - exact).T).max() < bound + 1e-12 * n


@pytest.mark.parametrize("n", [1499, 1500, 3000])
@pytest.mark.parametrize("alike", [True, False])
def test_sorting_into_columns_loses_nobody(n, alike):
    states = random_states(n)
    parameters = np.tile(PARAMETERS, (n, 1))
    if not alike:
        parameters[0, 4] = 5.1
    exact = social(states, parameters, error_bound=0.0)
    fast = social(states, parameters)
    assert np.hypot(*(fast - exact).T).max() < 1e-6


def test_many_people_in_one_line_or_one_place_are_sorted_too():
    for x, y in [(0.0, 1.0), (1.0, 0.0), (0.0, 0.0), (1e3, 0.0)]:
        states = random_states(1600)
        states[:, 0] = x * np.arange(1600) / 10
        states[:, 1] = y * np.arange(1600) / 10
        exact = social(states, error_bound=0.0)
        assert np.hypot(*(social(states) - exact).T).max() < 1e-6


def test_the_order_of_many_people_does_not_matter():
    states = random_states(2000)
    order = np.random.default_rng(3).permutation(2000)
    np.testing.assert_allclose(
        social(states[order], error_bound=0.0),
        social(states, error_bound=0.0)[order],
        atol=1e-9,
    )
    assert abs(social(states[order]) - social(states)[order]).max() < 2e-6


@pytest.mark.slow
def test_the_loops_are_compiled_to_vector_instructions():
    if platform.machine() not in ("x86_64", "AMD64"):
        pytest.skip("the names of the instructions are those of x86-64")
    # A fresh function: what comes from the disk cache has no assembler.
    compiled = numba.njit(error_model="numpy")(people_forces.py_func)
    states = random_states(10)
    compiled(states, np.tile(PARAMETERS, (10, 1)), 1e-6)
    code = "\n".join(compiled.inspect_asm().values())
    packed = {
        name: len(re.findall(rf"\bv?{name}\b", code))
        for name in ("sqrtpd", "divpd", "mulpd", "sqrtps")
    }
    print(packed)
    assert all(packed.values())


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"kernel": "quick"}, "fast, hunavsim, numpy, reference"),
        ({"error_bound": -1.0}, r"must be in \[0, 1\] m/s\^2, got -1"),
    ],
)
def test_bad_options_are_refused(options, words):
    with pytest.raises(ValueError, match=words):
        SocialForceModel(**options)
