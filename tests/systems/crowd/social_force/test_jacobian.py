"""The derivatives written out by hand against automatic ones."""

from hypothesis import assume, given, settings, strategies as st
import numpy as np
from pydrake.autodiffutils import (
    AutoDiffXd,
    ExtractGradient,
    InitializeAutoDiff,
)
import pytest

from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.crowd.social_force import jacobian, kernel, numpy_model
from hunav_drake.systems.world.obstacles import Obstacles, nearest_points
from tests.systems.crowd.crowds import random_snapshot

WALLS = Obstacles.from_shapes(
    [
        [[-6.0, -2.0], [6.0, -2.0]],
        [[1.0, 1.5], [3.0, 1.5], [3.0, 4.0], [1.0, 4.0]],
        [[-1.0, 0.5]],
        [[-3.0, 1.0], [-3.0, 3.0], [-1.0, 3.0]],
    ],
    solid=[False, True, False, False],
)


def analytic(snapshot):
    """Returns the derivatives of the total forces, and of the next states."""
    forces = kernel.social_forces(*snapshot.as_arguments)
    return (
        jacobian.force_jacobian(*snapshot.as_arguments),
        jacobian.step_jacobian(
            *snapshot.as_arguments, forces, snapshot.time_step
        ),
    )


def automatic(snapshot):
    """Returns what `analytic` does."""
    states, robots = snapshot.states, snapshot.robots
    variables = np.concatenate([states.ravel(), robots.ravel()])
    scalars = InitializeAutoDiff(variables).ravel()
    varied = snapshot._replace(
        states=scalars[: states.size].reshape(states.shape),
        robots=scalars[states.size :].reshape(robots.shape),
        command=np.vectorize(AutoDiffXd, otypes=[object])(snapshot.command),
    )
    forces = numpy_model.social_forces(varied)
    moved = numpy_model.advance(varied, forces)
    return tuple(
        ExtractGradient(part.ravel()) for part in (forces[:, 14:], moved)
    )


@pytest.mark.slow
@settings(max_examples=12)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(1, 6),
    st.integers(0, 2),
    st.integers(0, 4),
    st.booleans(),
)
def test_all_derivatives_are_those_of_autodiff(seed, n, m, most, same):
    rng = np.random.default_rng(seed)
    snapshot = random_snapshot(rng, n, m, most=most, same=same, walls=WALLS)
    # With the center in a wall, the automatic ones lose digits: the direction
    # away from it is a small difference of places.
    places = snapshot.states[:, None, :2]
    offsets = nearest_points(WALLS, snapshot.states[:, :2]) - places
    assume(np.linalg.norm(offsets, axis=-1).min(initial=1.0) > 0.02)
    for result, expected in zip(
        analytic(snapshot), automatic(snapshot), strict=True
    ):
        np.testing.assert_allclose(result, expected, rtol=1e-9, atol=1e-9)


def test_moving_everything_changes_no_force_between_people():
    """Only goals and walls stay in place, and there are none."""
    snapshot = random_snapshot(np.random.default_rng(5), 6, 2, walls=WALLS)
    snapshot.command[:, Command.HAS_GOAL] = 0
    snapshot = snapshot._replace(obstacles=Obstacles.from_shapes([], solid=[]))
    result, _ = analytic(snapshot)
    for column in (0, 1):
        by_place = result[:, column:36:6].sum(axis=1) + result[
            :, 36 + column :: 7
        ].sum(axis=1)
        np.testing.assert_allclose(by_place, 0, atol=1e-12)


def test_a_wall_only_pushes_back_along_its_normal():
    snapshot = random_snapshot(np.random.default_rng(0), 1, 0, walls=WALLS)
    snapshot.command[:] = 0
    snapshot.states[0] = [0.5, -1.6, 0, 0, 0, 0]
    distance, radius = 0.4, snapshot.radii[0]
    k, sigma = snapshot.parameters[0, 2:4]
    snapshot = snapshot._replace(max_obstacles=1)
    result, _ = analytic(snapshot)
    slope = -k / sigma * np.exp((radius - distance) / sigma)
    np.testing.assert_allclose(result[:, :2], [[0, 0], [0, slope]], atol=1e-12)


@pytest.mark.parametrize("scale", [1e-300, 1e-155, 1e-110, 1e5])
def test_no_place_gives_an_infinite_derivative(scale):
    snapshot = random_snapshot(np.random.default_rng(7), 5, 2, walls=WALLS)
    snapshot.states[:, :2] *= scale
    snapshot.robots[:, :2] *= scale
    snapshot.command[:, :2] *= scale
    snapshot.command[:, Command.GOAL_RADIUS] = 0
    for result in analytic(snapshot):
        assert np.isfinite(result).all()
    for result in automatic(snapshot):
        assert np.isfinite(result).all()
