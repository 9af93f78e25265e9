import math

import numpy as np
import pytest
from scipy.linalg import expm

from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.crowd import HeadedSocialForceModel, SocialForceModel
from hunav_drake.systems.crowd.headed_social_force import _turn


@pytest.fixture
def dut():
    return HeadedSocialForceModel()


def sideways(states):
    """Returns the velocities to the left of the headings, in m/s."""
    yaw = states[..., 2]
    return np.cos(yaw) * states[..., 4] - np.sin(yaw) * states[..., 3]


@pytest.mark.parametrize(
    ("stiffness", "damping"),
    [(117.0, 25.0), (100.0, 20.0), (0.0, 2.0), (0.0, 0.0), (1e-9, 3.0)],
)
@pytest.mark.parametrize("time", [1e-3, 0.05, 1.0])
def test_the_heading_is_solved_exactly(stiffness, damping, time):
    matrix = np.array([[0.0, 1.0], [-stiffness, -damping]])
    error, omega = expm(matrix * time) @ [1.3, -0.7]
    change, rate = _turn(1.3, -0.7, stiffness, damping, time)
    assert change == pytest.approx(error - 1.3, rel=1e-9, abs=1e-12)
    assert rate == pytest.approx(omega, rel=1e-9, abs=1e-12)


def test_the_heading_decays_with_the_rates_of_the_paper():
    """They have the ratio alpha, and the product k_lambda |f0|."""
    stiffness, alpha = 58.5, 3.0
    damping = (1 + alpha) * math.sqrt(stiffness / alpha)
    slow = math.sqrt(stiffness / alpha)
    change, rate = _turn(1.0, -slow, stiffness, damping, 0.3)
    assert 1 + change == pytest.approx(math.exp(-slow * 0.3))
    assert rate == pytest.approx(-slow * math.exp(-slow * 0.3))


def test_straight_ahead_it_is_the_social_force_model(dut, make_snapshot, walk):
    snapshot = make_snapshot([0] * 6, [100, 0])
    np.testing.assert_allclose(
        walk(dut, snapshot, 5.0), walk(SocialForceModel(), snapshot, 5.0)
    )


@pytest.mark.parametrize("time_step", [0.05, 0.01])
def test_a_step_aside_is_damped_exactly(time_step, make_snapshot, walk):
    dut = HeadedSocialForceModel(stepping_speed=0.0)
    snapshot = make_snapshot([0, 0, 0, 0, 1, 0], [0, 0], time_step=time_step)
    snapshot.command[0, Command.HAS_GOAL] = 0
    # At a standstill ahead, only the total counts: without a force on it, the
    # velocity to the side is left to the damping.
    no_force = np.zeros((1, 16))
    state = snapshot.states
    for _ in range(round(0.3 / time_step)):
        state = dut.advance(snapshot._replace(states=state), no_force)
    assert state[0, 4] == pytest.approx(math.exp(-500 / 75 * 0.3))
    assert state[0, 3] == 0


@pytest.mark.parametrize("speed", [0.0, 0.4, 0.8, 1.0, 1.2])
def test_who_is_slow_steps_as_the_forces_have_it(speed, make_snapshot):
    """By the share 1 - (v / s)^2; from s = 1 m/s on, not at all."""
    snapshot = make_snapshot(
        [0, 0, 0, speed, 0, 0], [9, 0], speed=1.0, max_speed=3.0
    )
    forces = np.zeros((1, 16))
    forces[0, 14:] = 0.5, 2.0
    free = SocialForceModel().advance(snapshot, forces)[0, 3:5]
    headed, mixed = (
        HeadedSocialForceModel(stepping_speed=s).advance(snapshot, forces)[0]
        for s in (0.0, 1.0)
    )
    share = max(1 - speed**2, 0.0)
    expected = share * free + (1 - share) * headed[3:5]
    np.testing.assert_allclose(mixed[3:5], expected, atol=1e-12)
    assert mixed[2] == headed[2]
    if speed < 1:
        assert abs(free[1] - headed[4]) > 0.005


def test_no_damping_is_too_stiff(make_snapshot, walk):
    dut = HeadedSocialForceModel(
        k_damping=1e6, k_lambda=1e3, mass=1.0, stepping_speed=0.0
    )
    snapshot = make_snapshot([0, 0, 1.0, 0, 1, 0], [3, 2])
    states = walk(dut, snapshot, 8.0)
    assert math.dist(states[-1, 0, :2], (3, 2)) < 0.5
    assert np.abs(sideways(states)[1:]).max() < 1e-3


@pytest.mark.parametrize("time_step", [0.05, 0.01])
def test_a_goal_behind_is_turned_to_smoothly(
    time_step, dut, make_snapshot, walk
):
    snapshot = make_snapshot([0] * 6, [-6, 0], time_step=time_step)
    states = walk(dut, snapshot, 12.0)[:, 0]
    turn = np.unwrap(states[:, 2])
    # To the right, by half a turn, without swinging back.
    assert np.diff(turn).max() < 0.01
    assert turn[-1] == pytest.approx(-math.pi, abs=0.05)
    assert np.abs(states[:, 5]).max() < 10.5
    # From standing, as fast as the goal's force has it.
    assert np.abs(np.diff(states[:, 5])).max() < 340 * time_step
    assert states[:, 0].max() < 0.1
    assert math.dist(states[-1, :2], (-6, 0)) < 0.31
    assert np.hypot(*states[-1, 3:5]) < 1e-3
    assert abs(states[-1, 5]) < 1e-6


def test_the_heading_does_not_swing_on_the_way(dut, make_snapshot, walk):
    snapshot = make_snapshot([0, 0, 0.4, 0, 0, 0], [50, 3])
    states = walk(dut, snapshot, 20.0)[100:, 0]
    assert np.abs(states[:, 5]).max() < 1e-3


def test_who_slows_down_does_not_turn_around(dut, make_snapshot, walk):
    snapshot = make_snapshot(
        [0, 0, 0, 1.5, 0, 0], [20, 0.1], speed=0.3, max_speed=1.5
    )
    states = walk(dut, snapshot, 5.0)[:, 0]
    assert np.abs(states[:, 2]).max() < 0.1
    assert states[-1, 3] == pytest.approx(0.3, abs=0.01)


def test_a_turn_rate_dies_away_without_a_goal(dut, make_snapshot, walk):
    snapshot = make_snapshot([0, 0, 0, 0, 0, 5.0], [0, 0])
    snapshot.command[0, Command.HAS_GOAL] = 0
    states = walk(dut, snapshot, 1.0)[:, 0]
    time = 0.05 * np.arange(21)
    np.testing.assert_allclose(states[:, 5], 5 * np.exp(-time / 0.5))
    np.testing.assert_allclose(
        states[:, 2], 2.5 * (1 - np.exp(-time / 0.5)), atol=1e-12
    )


def make_circle(make_snapshot, time_step):
    angle = 2 * math.pi * np.arange(6) / 6 + 0.2 * np.sin(np.arange(6))
    places = 4 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    states = np.zeros((6, 6))
    states[:, :2] = places
    states[:, 2] = angle + math.pi
    return make_snapshot(states, -places, time_step=time_step)


def test_people_who_cross_walk_ahead(dut, make_snapshot, walk):
    states = walk(dut, make_circle(make_snapshot, 0.05), 15.0)
    speed = np.hypot(states[..., 3], states[..., 4])
    aside = np.abs(sideways(states))
    assert aside.max() < 0.3
    assert aside[speed > 0.1].mean() < 0.06 * speed[speed > 0.1].mean()
    goals = -states[0, :, :2]
    assert np.linalg.norm(states[-1, :, :2] - goals, axis=1).max() < 0.4
    assert speed[-1].max() < 1e-2


def test_the_step_hardly_matters(dut, make_snapshot, walk):
    coarse = walk(dut, make_circle(make_snapshot, 0.05), 12.0)
    fine = walk(dut, make_circle(make_snapshot, 0.01), 12.0)[::5]
    assert np.abs(coarse[..., :2] - fine[..., :2]).max() < 0.25
    np.testing.assert_allclose(coarse[-1, :, :2], fine[-1, :, :2], atol=0.1)


def test_turned_by_all_forces_people_keep_farther_apart(make_snapshot, walk):
    def distance(share):
        snapshot = make_snapshot(
            [[-4, 0, 0, 0, 0, 0], [4, 0.3, math.pi, 0, 0, 0]],
            [[4, 0], [-4, 0.3]],
        )
        dut = HeadedSocialForceModel(heading_share=share)
        p = walk(dut, snapshot, 10.0)[..., :2]
        return np.linalg.norm(p[:, 0] - p[:, 1], axis=1).min()

    assert distance(0.0) < 0.4
    assert distance(1.0) > 0.6


def test_a_commanded_turn_leaves_the_way_to_the_forces(dut, make_snapshot):
    snapshot = make_snapshot([0, 0, 0, 1, 0, 0], [9, 0])
    snapshot.command[0, Command.TURN_RATE] = 1.0
    snapshot.command[0, Command.YAW_TARGET] = 2.0
    forces = dut.forces(snapshot)
    np.testing.assert_array_equal(
        dut.advance(snapshot, forces),
        SocialForceModel().advance(snapshot, forces),
    )
