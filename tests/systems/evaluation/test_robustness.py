"""Margins to failures, of recordings made by hand."""

import math

import numpy as np
import pytest

from hunav_drake.systems.common.layout import Contact
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.robustness import (
    NO_FAILURE,
    ROBUSTNESS,
    register_robustness,
    robustness_of,
)

TIMES = np.arange(0.0, 10.05, 0.1)


def walking(x, y, vx, vy, radius=0.3):
    """Returns rows of somebody who goes straight."""
    rows = np.zeros((len(TIMES), 7))
    rows[:, 0], rows[:, 1] = x + vx * TIMES, y + vy * TIMES
    rows[:, 3], rows[:, 4], rows[:, 6] = vx, vy, radius
    return rows


def recorded(robot, *people, goal=(20.0, 0.0, 0.0), contacts=None):
    humans = np.stack(people, axis=1) if people else np.zeros((101, 0, 7))
    return Recording(
        contacts=contacts,
        times=TIMES[: len(robot)],
        robot=robot,
        humans=humans,
        goal=goal,
        robot_max_speed=1.0,
    )


def failing(name, recording, duration=60.0):
    return robustness_of(name).failing(recording, duration)


def test_a_robot_that_runs_into_a_person_collides():
    found = failing(
        "collision", recorded(walking(0, 0, 1, 0), walking(5, 0, 0, 0))
    )
    # At 4.4 s they touch; without contacts, less than 2 cm count as one.
    assert math.isclose(found.robustness, -1.0)
    assert math.isclose(found.time, 4.4)
    assert found.person == 0
    assert math.isclose(found.bearing, 0.0, abs_tol=1e-9)
    assert math.isclose(found.closing_speed, 1.0)


def test_a_person_who_runs_into_the_robot_is_no_failure():
    found = failing(
        "collision", recorded(walking(0, 0, 0.2, 0), walking(5, 0, -1, 0))
    )
    assert found.robustness == NO_FAILURE


def test_only_the_first_touch_counts():
    """The person runs in first; later the robot drives faster than he walks."""
    robot, person = walking(0, 0, 0.2, 0), walking(3, 0, -1, 0)
    robot[40:, 3] = 1.0
    person[40:, 3] = 0.0
    found = failing("collision", recorded(robot, person))
    assert found.robustness == NO_FAILURE


def test_the_margin_is_the_gap_of_passing():
    robot, person = walking(0, 0, 1, 0), walking(5, 1.0, -0.2, 0)
    found = failing("collision", recorded(robot, person))
    assert 0.4 - 1e-9 <= found.robustness < 0.42
    assert 0 < found.bearing < math.pi / 2 + 0.2


def test_meetings_between_samples_are_found():
    """They cross at 2 m/s, in the middle of an interval of 0.1 s."""
    robot, person = walking(0, 0, 2.0, 0, 0.05), walking(10.1, 0, -1.9, 0, 0.05)
    found = failing("collision", recorded(robot, person))
    assert math.isclose(found.robustness, -3.9)


def test_contacts_of_bodies_count_where_they_are_known():
    """Bodies are smaller than discs, which overlap before there is one."""
    robot, person = walking(0, 0, 1, 0), walking(5, 0, 0, 0)
    contacts = np.zeros((101, 1, 8))
    near = recorded(robot[:50], person[:50], contacts=contacts[:50])
    assert 0 < failing("collision", near).robustness < 1e-9
    contacts[46:, 0, Contact.BY_ROBOT] = 1.0
    contacts[46:, 0, Contact.RELATIVE_SPEED] = 0.8
    found = failing("collision", recorded(robot, person, contacts=contacts))
    assert found.robustness == -0.8
    assert math.isclose(found.time, 4.6)
    contacts[46:, 0, Contact.BY_PERSON] = 1.0
    both = recorded(robot, person, contacts=contacts)
    assert failing("collision", both).robustness > 0


def test_a_standing_robot_freezes_unless_it_is_at_the_goal():
    robot = walking(0, 0, 0.0, 0)
    assert math.isclose(failing("freeze", recorded(robot)).robustness, -5.0)
    robot[40:, 3] = 1.0
    assert math.isclose(failing("freeze", recorded(robot)).robustness, 1.1)
    goal = (0.5, 0.0, 0.0)
    found = failing("freeze", recorded(walking(0, 0, 0, 0), goal=goal))
    assert found.robustness == 5.0
    found = failing("freeze", recorded(walking(0, 0, 0, 0)))
    assert math.isclose(found.time, 5.1)


def test_one_who_arrives_at_the_instant_of_a_failure_has_a_bearing():
    robot, person = walking(0, 0, 0, 0), walking(0, 2, 0, -0.5)
    person[:51] = np.nan
    person[51:, 1] = 2.0
    found = failing("freeze", recorded(robot, person))
    assert math.isclose(found.time, 5.1)
    assert found.person == 0
    assert math.isclose(found.bearing, math.pi / 2)
    assert math.isclose(found.closing_speed, 0.5)


def test_an_intrusion_lasts_longer_than_two_seconds():
    robot = walking(0, 0, 0.5, 0)
    beside, far = walking(0, 0.9, 0.5, 0), walking(0, 4.0, 0.5, 0)
    found = failing("intrusion", recorded(robot, far, beside))
    assert math.isclose(found.robustness, -8.0)
    assert math.isclose(found.time, 2.1)
    assert found.person == 1
    standing = recorded(walking(0, 0, 0, 0), walking(0, 0.9, 0, 0))
    assert failing("intrusion", standing).robustness == 2.0


@pytest.mark.parametrize("begin", range(0, 50, 7))
def test_just_the_time_that_is_allowed_is_no_failure(begin):
    robot, beside = walking(0, 0, 0.5, 0), walking(0, 0.9, 0.5, 0)
    beside[: begin + 1, 1] = beside[begin + 21 :, 1] = 5.0
    assert failing("intrusion", recorded(robot, beside)).robustness == 0.0
    robot = walking(0, 0, 0.0, 0)
    robot[: begin + 1, 3] = robot[begin + 51 :, 3] = 1.0
    assert failing("freeze", recorded(robot)).robustness == 0.0


def test_of_equal_margins_that_of_the_nearest_person_counts():
    robot = walking(0, 0, 0.5, 0)
    gone = np.full((101, 7), np.nan)
    people = [gone, walking(9, 8, 0, 0), walking(3, 4, 0, 0)]
    for order in [(0, 1, 2), (2, 1, 0)]:
        rows = [people[i] for i in order]
        found = failing("intrusion", recorded(robot, *rows))
        assert (found.robustness, order[found.person]) == (2.0, 2)


def test_a_robot_that_does_not_arrive_is_late_by_the_way_left():
    found = failing("timeout", recorded(walking(0, 0, 1, 0)))
    assert math.isclose(found.robustness, -10.0)
    arrives = recorded(walking(0, 0, 1, 0), goal=(5.0, 0.0, 0.0))
    assert failing("timeout", arrives, 7.0).robustness == pytest.approx(2.2)


def test_without_people_and_goal_nothing_fails():
    alone = recorded(walking(0, 0, 0, 0), goal=None)
    for name in ROBUSTNESS:
        found = failing(name, alone)
        assert found.robustness > 0
        assert found.person == -1
        assert math.isnan(found.bearing)


def test_a_function_of_a_user_is_registered_and_checked():
    try:

        @register_robustness("test_speed", unit="m/s")
        def speed(recording):
            return 0.5 - recording.features.forward_speed

        found = failing("test_speed", recorded(walking(0, 0, 0.7, 0)))
        assert math.isclose(found.robustness, -0.2)
        with pytest.raises(ValueError, match="must take"):
            register_robustness("test_other")(lambda: 0)
        with pytest.raises(ValueError, match="registered already"):
            register_robustness("collision")(lambda recording: 0)
        register_robustness("test_shape")(lambda recording: np.zeros(3))
        with pytest.raises(ValueError, match=r"'test_shape'.*shape"):
            failing("test_shape", recorded(walking(0, 0, 0, 0)))
    finally:
        for name in ("test_speed", "test_shape"):
            ROBUSTNESS.pop(name, None)
    with pytest.raises(ValueError, match="collision"):
        robustness_of("colision")
