from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.people import gait as mut
from hunav_drake.systems.people.figure_config import adult_figures

DT = 0.05
ADULT = adult_figures(1)


def walker(speed: float, yaw: float = 0.0, direction: float | None = None):
    way = yaw if direction is None else direction
    return np.array(
        [1.0, 2.0, yaw, speed * np.cos(way), speed * np.sin(way), 0.0, 0.35]
    )


def standing(*phases: float) -> np.ndarray:
    gait = mut.initial_gait(np.arange(len(phases)) + 1).reshape(
        -1, mut.GAIT_SIZE
    )
    gait[:, mut.PHASE] = phases
    return gait.ravel()


def come(state: np.ndarray, seconds: float) -> None:
    """Moves people on as fast as they say they move."""
    rows = state.reshape(-1, 7)
    rows[:, :2] += seconds * rows[:, 3:5]


def walk_gait(
    state: np.ndarray, steps: int, start: np.ndarray | None = None
) -> np.ndarray:
    gait = standing(*len(state[::7]) * [0.0]) if start is None else start
    state = state.copy()
    for _ in range(steps):
        gait = mut.advance_gait(gait, state, DT)
        come(state, DT)
    return gait


def soles(q: np.ndarray) -> np.ndarray:
    """Heel and toe of both feet: how far ahead and how high, shape (4, 2)."""
    points = []
    for hip, knee in (
        (q[mut.LEFT_HIP], q[mut.LEFT_KNEE]),
        (q[mut.RIGHT_HIP], q[mut.RIGHT_KNEE]),
    ):
        shin = hip - knee
        for ahead in (-mut.HEEL, mut.TOE):
            x = (
                mut.THIGH * np.sin(hip)
                + mut.SHIN * np.sin(shin)
                + ahead * np.cos(shin)
            )
            z = (
                q[mut.HIP_HEIGHT]
                - mut.THIGH * np.cos(hip)
                - mut.SHIN * np.cos(shin)
                + ahead * np.sin(shin)
            )
            points.append((x, z))
    return np.array(points)


def test_a_person_who_stands_stays_upright_with_legs_together():
    still = walker(0.0, yaw=1.0)
    gait = walk_gait(still, 100, standing(0.7))
    np.testing.assert_array_equal(gait, [0.7, 0.0, *still[:2]])
    (q,) = mut.pose_figures(gait, still, ADULT)
    np.testing.assert_array_equal(q[:3], still[:3])
    assert q[mut.HIP_HEIGHT] == pytest.approx(mut.THIGH + mut.SHIN)
    np.testing.assert_array_equal(q[mut.LEFT_HIP :], 0.0)


def test_a_person_who_stops_at_once_puts_the_feet_together():
    gait = walk_gait(walker(1.2), 40)
    stopped = walk_gait(walker(0.0), 40, gait)
    (q,) = mut.pose_figures(stopped, walker(0.0), ADULT)
    assert np.abs(q[mut.LEFT_HIP :]).max() < 0.02


def test_a_person_who_does_not_come_forward_does_not_step():
    """Some who stand keep their velocity, in the profile of HuNavSim."""
    walking = walk_gait(walker(1.2), 40)
    gait = walking
    for _ in range(60):
        gait = mut.advance_gait(gait, walker(1.2), DT)
    assert walking[mut.PACE] == pytest.approx(1.2, abs=1e-3)
    assert gait[mut.PACE] == pytest.approx(0.0, abs=1e-3)


def test_who_is_put_elsewhere_steps_no_faster():
    gait = mut.advance_gait(standing(0.0), walker(0.4), DT)
    far = walker(0.4)
    far[0] += 50.0
    assert mut.advance_gait(gait, far, DT)[mut.PACE] < 0.4


@pytest.mark.parametrize("speed", [0.3, 0.7, 1.2, 2.0])
def test_the_stride_is_that_of_people_of_this_speed(speed):
    gait = walk_gait(walker(speed), 200)
    after = walk_gait(walker(speed), 201)
    turns = ((after[0] - gait[0]) % (2 * np.pi)) / (2 * np.pi)
    assert speed * DT / turns == pytest.approx(mut.STRIDE * np.sqrt(speed))


def test_faster_people_swing_their_legs_wider():
    swings = []
    for speed in (0.2, 0.6, 1.0, 1.5):
        state = walker(speed)
        gait = walk_gait(state, 200)
        angles = []
        for _ in range(60):
            gait = mut.advance_gait(gait, state, DT)
            come(state, DT)
            angles.append(mut.pose_figures(gait, state, ADULT)[0, mut.LEFT_HIP])
        swings.append(np.ptp(angles))
    assert np.all(np.diff(swings) > 0)


def test_a_person_who_steps_back_turns_the_stride_back():
    ahead = walk_gait(walker(0.5, yaw=0.4), 10)
    back = walk_gait(walker(0.5, yaw=0.4, direction=0.4 + np.pi), 10)
    assert back[1] == pytest.approx(-ahead[1])
    assert back[0] == pytest.approx((2 * np.pi - ahead[0]) % (2 * np.pi))


@given(st.floats(0, 2 * np.pi), st.floats(-3.0, 3.0))
def test_one_foot_is_on_the_floor_and_none_below(phase, pace):
    (q,) = mut.pose_figures(np.array([phase, pace, 0, 0]), walker(0.0), ADULT)
    assert soles(q)[:, 1].min() == pytest.approx(0.0, abs=1e-12)
    assert 0.7 < q[mut.HIP_HEIGHT] < 1.0


def test_the_foot_that_bears_the_weight_hardly_slips():
    speed, step = 1.2, 0.001
    gait = walk_gait(walker(speed), 200)
    slips = []
    previous = None
    state = walker(speed)
    for _ in range(2000):
        gait = mut.advance_gait(gait, state, step)
        feet = soles(mut.pose_figures(gait, state, ADULT)[0])
        come(state, step)
        foot = int(np.argmin(feet[:, 1])) // 2
        x = feet[2 * foot : 2 * foot + 2, 0].mean()
        if previous and previous[0] == foot:
            slips.append((x - previous[1]) / step + speed)
        previous = (foot, x)
    assert abs(np.mean(slips)) < 0.25 * speed


def test_arms_swing_against_the_legs():
    (q,) = mut.pose_figures(
        np.array([np.pi / 2, 1.2, 0, 0]), walker(1.2), ADULT
    )
    assert q[mut.LEFT_HIP] > 0.2 > -0.2 > q[mut.RIGHT_HIP]
    assert q[mut.LEFT_SHOULDER] < -0.2 < 0.2 < q[mut.RIGHT_SHOULDER]


def test_people_do_not_disturb_each_other():
    states = [walker(0.0), walker(0.8, 2.0), walker(1.5, -1.0)]
    together = walk_gait(np.concatenate(states), 30)
    alone = [walk_gait(state, 30) for state in states]
    np.testing.assert_array_equal(together, np.concatenate(alone))


# Speeds below 1 um/s drown in the rounding of positions.
@given(st.floats(-np.pi, np.pi), st.just(0.0) | st.floats(1e-6, 2.0))
def test_steps_do_not_depend_on_the_direction_of_the_walk(yaw, speed):
    np.testing.assert_allclose(
        walk_gait(walker(speed, yaw), 20)[: mut.LAST_X],
        walk_gait(walker(speed), 20)[: mut.LAST_X],
        atol=1e-9,
    )
