"""The plain NumPy path computes what the compiled kernel does."""

import dataclasses

from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
import numpy as np
import pytest

from hunav_drake.systems.common.layout import COMMAND_SIZE, Command, RobotRole
from hunav_drake.systems.crowd.motion_model import Snapshot
from hunav_drake.systems.crowd.social_force import kernel, numpy_model
from hunav_drake.systems.people.parameters import SocialForceParameters
from hunav_drake.systems.world.obstacles import Obstacles
from tests.systems.crowd.crowds import NO_WALLS, random_snapshot

WALLS = Obstacles.from_shapes(
    [
        [[-5.0, -1.0], [9.0, -1.0]],
        [[2.0, 2.0], [3.0, 2.0], [3.0, 4.0], [2.0, 4.0]],
        [[0.0, 0.0]],
        [[-3.0, 3.0], [-1.0, 3.5], [-2.0, 5.0]],
    ],
    solid=[False, True, False, False],
)


def table(rows, columns):
    """Returns a strategy for arrays of people or robots, some coincident."""
    return st.one_of(
        arrays(float, (rows, columns), elements=st.floats(-8, 8)),
        arrays(float, (rows, columns), elements=st.integers(-3, 3)),
    )


@st.composite
def snapshots(draw, *, scale=1.0, speed_scale=1.0):
    n = draw(st.integers(0, 6))
    m = draw(st.integers(0, 2))
    states = draw(table(n, 6)) * [scale, scale, 0.4, *[speed_scale] * 2, 1]
    robots = draw(table(m, 7)) * [scale, scale, 0.4, *[speed_scale] * 2, 1, 0]
    command = np.zeros((n, COMMAND_SIZE))
    choices = {
        Command.GOAL_RADIUS: st.sampled_from([0.0, 0.3]),
        Command.HAS_GOAL: st.sampled_from([0.0, 1.0]),
        Command.DESIRED_SPEED: st.floats(0, 2),
        Command.MAX_SPEED: st.floats(0, 3),
        Command.ROBOT_ROLE: st.sampled_from(RobotRole),
        Command.ROBOT_REPULSION: st.sampled_from([0.0, 2.5]),
        Command.HOLD: st.sampled_from([0.0, 0.0, 1.0]),
        Command.TURN_RATE: st.sampled_from([0.0, 0.0, 1.0]),
        Command.YAW_TARGET: st.floats(-3, 3),
        Command.GROUP_ID: st.integers(-1, 2),
    }
    for column, choice in choices.items():
        command[:, column] = draw(
            arrays(float, n, elements=choice.map(float), fill=st.nothing())
        )
    command[:, :2] = draw(table(n, 2)) * scale
    parameters = [
        dataclasses.astuple(
            SocialForceParameters(
                epsilon=draw(st.sampled_from([0.005, -0.02])),
                social_factor=draw(st.sampled_from([0.0, 2.1, 5.0])),
                obstacle_sigma=draw(st.sampled_from([0.1, 0.2])),
            )
        )
        for _ in range(n)
    ]
    return Snapshot(
        states=states,
        radii=draw(arrays(float, n, elements=st.floats(0.1, 0.6))),
        command=command,
        parameters=np.array(parameters).reshape(n, 13),
        robots=robots,
        obstacles=draw(st.sampled_from([WALLS, NO_WALLS])),
        obstacle_range=draw(st.sampled_from([2.0, 1e5])),
        max_obstacles=draw(st.integers(0, 5)),
        time_step=0.05,
    )


def check_step(snapshot):
    forces = numpy_model.social_forces(snapshot)
    np.testing.assert_allclose(
        forces,
        kernel.social_forces(*snapshot.as_arguments),
        rtol=1e-12,
        atol=1e-12,
    )
    moved = numpy_model.advance(snapshot, forces)
    # The yaw jumps where a person stops, so both move by the same forces.
    expected = kernel.advance(
        snapshot.states, forces, snapshot.command, snapshot.time_step
    )
    np.testing.assert_allclose(moved, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.slow
@given(snapshots())
def test_a_step_is_that_of_the_kernel(snapshot):
    check_step(snapshot)


@given(snapshots(scale=1.2e4, speed_scale=120.0))
def test_no_place_or_speed_gives_nan(snapshot):
    """Up to 1e5 m and 1e3 m/s."""
    forces = numpy_model.social_forces(snapshot)
    assert np.isfinite(forces).all()
    assert np.isfinite(numpy_model.advance(snapshot, forces)).all()
    # Large forces cancel in part.
    size = max(abs(forces).max(initial=1.0), 1.0)
    np.testing.assert_allclose(
        forces,
        kernel.social_forces(*snapshot.as_arguments),
        rtol=1e-12,
        atol=1e-13 * size,
    )


@pytest.mark.parametrize("epsilon", [0.0, 0.005])
@pytest.mark.parametrize("n", [2, 20, 700])
def test_a_crowd_of_any_size_steps_like_the_kernel(n, epsilon):
    """The largest is computed in pieces."""
    rng = np.random.default_rng(0)
    check_step(
        random_snapshot(rng, n, 2, walls=WALLS, spread=5.0, epsilon=epsilon)
    )


def test_a_hard_surface_gives_no_infinite_force():
    snapshot = random_snapshot(np.random.default_rng(0), 2, 2, walls=WALLS)
    snapshot.parameters[:, 3] = 1e-4
    snapshot.radii[:] = 5.0
    snapshot.states[0, :2] = -4.0, -0.9
    forces = numpy_model.social_forces(snapshot)
    assert np.isfinite(forces).all()
    assert np.isfinite(numpy_model.advance(snapshot, forces)).all()


def test_the_arguments_are_left_alone():
    snapshot = random_snapshot(np.random.default_rng(0), 5, 2, walls=WALLS)
    before = [np.array(array) for array in snapshot[:5]]
    numpy_model.advance(snapshot, numpy_model.social_forces(snapshot))
    for array, copy in zip(snapshot[:5], before, strict=True):
        np.testing.assert_array_equal(array, copy)
