"""The NumPy functions and the compiled kernel compute the same forces."""

import dataclasses
import math

from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.crowd.social_force import numpy_forces
from hunav_drake.systems.crowd.social_force.kernel import social_forces
from hunav_drake.systems.people.parameters import SocialForceParameters
from hunav_drake.systems.world.obstacles import Obstacles

place = st.tuples(*[st.floats(-20, 20)] * 2)
velocity = st.tuples(*[st.floats(-3, 3)] * 2)


def pair_force(p_from, p_to, v_from, v_to, parameters):
    d, dv = np.subtract(p_to, p_from), np.subtract(v_from, v_to)
    return np.array(numpy_forces.pair_force(*d, *dv, parameters))


def obstacle_force(p, p_wall, radius, parameters):
    d = np.subtract(p, p_wall, dtype=float)
    return np.array(numpy_forces.obstacle_force(*d, radius, parameters))


def kernel_forces_on_first(p, v, *, parameters, points=()):
    """Returns the forces on the first of some people, shape (8, 2)."""
    n = len(p)
    states = np.zeros((n, 6))
    states[:, :2] = p
    states[:, 3:5] = v
    points = np.reshape(np.asarray(points, dtype=float), (-1, 2))
    command = np.zeros((n, COMMAND_SIZE))
    command[:, Command.GROUP_ID] = -1
    return social_forces(
        states,
        np.full(n, 0.35),
        command,
        np.array([dataclasses.astuple(parameters)] * n),
        np.zeros((0, 7)),
        np.tile([0.35, parameters.obstacle_factor], (n, 1)),
        Obstacles.from_points(points).table,
        1e5,
        0,
    )[0].reshape(8, 2)


@given(place, place, velocity, velocity, st.sampled_from([0.0, 0.005]))
def test_pair_forces_agree(p_from, p_to, v_from, v_to, epsilon):
    parameters = SocialForceParameters(epsilon=epsilon)
    expected = pair_force(p_from, p_to, v_from, v_to, parameters)
    assert np.isfinite(expected).all()
    result = kernel_forces_on_first(
        [p_from, p_to], [v_from, v_to], parameters=parameters
    )
    np.testing.assert_allclose(result[2], expected, rtol=1e-12, atol=1e-12)


@given(place, place)
def test_obstacle_forces_agree(p, p_wall):
    parameters = SocialForceParameters()
    expected = obstacle_force(p, p_wall, 0.35, parameters)
    assert np.isfinite(expected).all()
    result = kernel_forces_on_first(
        [p], [[0, 0]], parameters=parameters, points=p_wall
    )
    np.testing.assert_allclose(result[1], expected, rtol=1e-12, atol=1e-12)


def test_a_person_ahead_slows_one_down_by_the_formula():
    """Standing face to face the angle is zero, and B is gamma."""
    parameters = SocialForceParameters(epsilon=0.0)
    force = pair_force([0, 0], [2, 0], [0, 0], [0, 0], parameters)
    np.testing.assert_allclose(force, [-5.0 * math.exp(-2 / 0.35), 0])


def test_the_force_is_opposite_for_the_other():
    parameters = SocialForceParameters(epsilon=0.0)
    args = [0, 0], [1, 0.4], [1, 0], [-0.5, 0.2]
    there = pair_force(*args, parameters)
    back = pair_force(args[1], args[0], args[3], args[2], parameters)
    np.testing.assert_allclose(back, -there, atol=1e-15)


def test_an_exact_encounter_is_passed_on_the_right():
    force = pair_force([0, 0], [4, 0], [1, 0], [-1, 0], SocialForceParameters())
    assert force[1] < 0


@pytest.mark.parametrize(
    ("p_to", "v_from", "v_to"),
    [
        ([0, 0], [0, 0], [0, 0]),
        ([0, 0], [1, 0], [0, 0]),
        ([2, 0], [-0.25, 0], [0.25, 0]),
    ],
    ids=["coincident", "coincident and moving", "no direction"],
)
def test_what_is_undefined_is_zero(p_to, v_from, v_to):
    parameters = SocialForceParameters(epsilon=0.0)
    force = pair_force([0, 0], p_to, v_from, v_to, parameters)
    np.testing.assert_array_equal(force, [0, 0])
    result = kernel_forces_on_first(
        [[0, 0], p_to], [v_from, v_to], parameters=parameters
    )
    np.testing.assert_array_equal(result[2], [0, 0])
    np.testing.assert_array_equal(
        obstacle_force([0, 0], [0, 0], 0.3, parameters), [0, 0]
    )
