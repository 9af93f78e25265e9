"""How figures hold themselves: sitting, looking, gesturing."""

import math

import numpy as np
import pytest

from hunav_drake.systems.common.layout import (
    SIGNAL_SIZE,
    SILENT,
    Activity,
    Gesture,
    Posture,
    Signal,
)
from hunav_drake.systems.people import manners as mut
from hunav_drake.systems.people.figure_config import WHEELED, adult_figures
from hunav_drake.systems.people.gait import (
    FIGURE_SIZE,
    FOOTREST,
    HIP_HEIGHT,
    LEFT_SHOULDER,
    RIGHT_SHOULDER,
    SEAT,
    initial_gait,
    pose_figures,
)

DT = 0.05
NO_ROBOTS = np.zeros(0)


def people(*rows):
    """Returns `human_states` of people (x, y, yaw) who stand."""
    return np.array([[*row, 0, 0, 0, 0.35] for row in rows], float).ravel()


def shown(n, **more):
    """Returns the signals of n people; the first shows something."""
    signals = np.tile(SILENT, (n, 1))
    for name, value in more.items():
        signals[0, Signal[name]] = value
    return signals.ravel()


def after(seconds, signals, states, robots=NO_ROBOTS, start=None):
    n = len(signals) // SIGNAL_SIZE
    manners = mut.initial_manners(np.arange(n) + 1) if start is None else start
    for _ in range(round(seconds / DT)):
        manners = mut.advance_manners(manners, signals, states, robots, DT)
    return manners


def figures(manners, states, bodies=None):
    n = len(states) // 7
    bodies = adult_figures(n) if bodies is None else bodies
    walking = pose_figures(initial_gait(np.arange(n) + 1), states, bodies)
    return mut.hold_figures(walking, manners, bodies), walking


def test_silent_people_walk_as_before():
    states = people((0, 0, 0), (3, 0, 1))
    held, walking = figures(after(3.0, shown(2), states), states)
    np.testing.assert_allclose(held[:, :FIGURE_SIZE], walking, atol=1e-12)
    np.testing.assert_array_equal(held[:, [mut.LEAN, mut.HEAD]], 0.0)


def test_a_person_sits_down_in_a_second_and_stands_up_in_another():
    states = people((0, 0, 0))
    signals = shown(1, POSTURE=Posture.SEATED)
    heights = [
        figures(after(t, signals, states), states)[0][0, HIP_HEIGHT]
        for t in (0.0, 0.5, 1.0, 5.0)
    ]
    assert heights[0] == pytest.approx(0.88)
    assert heights[0] > heights[1] > heights[2]
    # A seat is 0.45 m high.
    assert heights[2] == heights[3] == pytest.approx(0.54, abs=0.01)
    seated = after(2.0, signals, states)
    stands = after(1.0, shown(1), states, start=seated)
    assert figures(stands, states)[0][0, HIP_HEIGHT] == pytest.approx(0.88)


def test_who_lies_is_on_the_back_above_the_bed():
    states = people((0, 0, 0))
    lying = after(2.0, shown(1, POSTURE=Posture.LYING), states)
    q = figures(lying, states)[0][0]
    assert q[mut.LEAN] == pytest.approx(-math.pi / 2)
    assert 0.6 < q[HIP_HEIGHT] < 0.7
    # Whoever is in a wheelchair stays in it.
    wheeled = adult_figures(1)
    wheeled[0, WHEELED] = 1.0
    moved = figures(lying, states, wheeled)[0][0]
    assert moved[HIP_HEIGHT] == SEAT + FOOTREST
    assert moved[mut.LEAN] == 0
    sits = figures(after(0.0, shown(1), states), states, wheeled)[0][0]
    assert sits[HIP_HEIGHT] == SEAT + FOOTREST
    # Forearms rest on the bed, too.
    assert q[mut.LEFT_ELBOW] == q[mut.RIGHT_ELBOW] == 0.0


@pytest.mark.parametrize(
    ("gaze", "turn"),
    [
        (-1, 0.0),
        (0, 0.0),
        (1, math.pi / 4),
        (2, -math.pi / 4),
        # (Behind: as far as the neck turns.)
        (3, 1.2),
    ],
)
def test_the_head_turns_to_what_is_looked_at(gaze, turn):
    states = people((1, 1, 0), (2, 2, 0), (2, 0, 0))
    robots = np.array([-1, 1.01, 0, 0, 0, 0, 0.3])
    turned = after(1.0, shown(3, GAZE=gaze), states, robots)
    head = figures(turned, states)[0][0, mut.HEAD]
    assert head == pytest.approx(turn, abs=1e-9)
    # Not at once.
    first = after(DT, shown(3, GAZE=gaze), states, robots)
    assert abs(figures(first, states)[0][0, mut.HEAD]) <= 4.0 * DT + 1e-12


def test_the_head_turns_to_a_point_and_likewise_in_any_direction():
    for yaw in (-3.0, 0.4, 2.9):
        x, y = math.cos(yaw + 0.8), math.sin(yaw + 0.8)
        signals = shown(1, GAZE=-2, GAZE_X=5 + x, GAZE_Y=-7 + y)
        states = people((5, -7, yaw))
        turned = figures(after(1.0, signals, states), states)[0]
        assert turned[0, mut.HEAD] == pytest.approx(0.8)


@pytest.mark.parametrize(
    ("more", "arm", "least"),
    [
        ({"GESTURE": Gesture.WAVE}, RIGHT_SHOULDER, 2.0),
        ({"GESTURE": Gesture.POINT}, RIGHT_SHOULDER, 1.3),
        ({"GESTURE": Gesture.BECKON}, mut.RIGHT_ELBOW, 0.8),
        ({"GESTURE": Gesture.YOU_FIRST}, RIGHT_SHOULDER, 0.8),
        ({"UTTERANCE": 77.0}, mut.LEFT_ELBOW, 0.7),
        ({"ACTIVITY": Activity.USE}, mut.RIGHT_ELBOW, 1.3),
    ],
)
def test_arms_show_gestures_talk_and_use(more, arm, least):
    states = people((0, 0, 0))
    busy = figures(after(2.0, shown(1, **more), states), states)[0][0]
    calm = figures(after(2.0, shown(1), states), states)[0][0]
    assert busy[arm] > least > calm[arm]


def test_hands_of_who_works_at_a_desk_are_on_it():
    states = people((0, 0, 0))
    posture = Posture.SEATED
    works = shown(1, POSTURE=posture, ACTIVITY=Activity.USE)
    rests = shown(1, POSTURE=posture, ACTIVITY=Activity.SIT)
    one, other = (
        figures(after(3.0, it, states), states)[0][0] for it in (works, rests)
    )
    for q, height in ((one, 0.75), (other, 0.55)):
        upper, below = q[LEFT_SHOULDER], q[LEFT_SHOULDER] + q[mut.LEFT_ELBOW]
        hand = q[HIP_HEIGHT] + 0.515
        hand -= 0.275 * math.cos(upper) + 0.28 * math.cos(below)
        assert hand == pytest.approx(height, abs=0.1)


def test_the_next_state_follows_from_the_arguments_alone():
    states = people((0, 0, 0), (1, 1, 1))
    signals = shown(2, UTTERANCE=5.0)
    manners = after(0.7, signals, states)
    before = manners.copy()
    one, other = (
        mut.advance_manners(manners, signals, states, NO_ROBOTS, DT)
        for _ in range(2)
    )
    np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(manners, before)
