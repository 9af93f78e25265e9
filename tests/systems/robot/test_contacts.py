"""How contacts are counted, and charged."""

import math

import numpy as np
import pytest

from hunav_drake import HumanConfig
from hunav_drake.systems.common.layout import CONTACT_PAUSE, Contact
from hunav_drake.systems.people import SocialForceParameters
from hunav_drake.systems.robot.contact_rows import (
    MEMORY_SIZE,
    PERSON_SPEED,
    ROBOT_SPEED,
    count_contacts,
)
from hunav_drake.systems.robot.discs import closing_speeds, gaps
from tests.systems.robot.driven_robots import drive, make_diagram

STEP = 0.05


def count(memory, touching, speeds, bearing=0.7, *, body=0.2, **options):
    """Counts contacts with a person at 0.55 m, at approach speeds."""
    v, u = speeds
    c, s = np.cos(bearing), np.sin(bearing)
    robot = np.array([0, 0, 0, v * c, v * s, 0, 0.3])
    people = np.array([[0.55 * c, 0.55 * s, 0, -u * c, -u * s, 0, 0.35]])
    return count_contacts(
        memory,
        np.array([touching]),
        options.get("forces", np.empty((0, 2))),
        gaps(robot, people, np.array([body])),
        closing_speeds(robot, people),
        options.get("duration", STEP),
    )


def contact(robot_speed, person_speed):
    memory = np.zeros((1, MEMORY_SIZE))
    return count(memory, True, (robot_speed, person_speed))[0]


@pytest.mark.parametrize(
    ("v", "u", "by_robot", "by_person"),
    [
        (0.5, 0.2, 1, 0),
        (0.2, 0.5, 0, 1),
        (0.3, 0.3, 1, 1),
        (0.5, -0.1, 1, 0),
        (-0.1, 0.5, 0, 1),
        # Grazing: the two close in, however slowly.
        (2e-6, 0.0, 1, 0),
        (0.5, -0.499, 1, 0),
        # They stand in each other, or part already.
        (0.0, 0.0, 1, 1),
        (-0.3, -0.1, 1, 1),
    ],
)
def test_who_closes_in_faster_is_charged(v, u, by_robot, by_person):
    row = contact(v, u)
    assert row[Contact.LASTS] == 1
    assert row[Contact.BY_ROBOT] == by_robot
    assert row[Contact.BY_PERSON] == by_person
    assert row[Contact.RELATIVE_SPEED] == pytest.approx(max(v + u, 0))


def test_the_speed_before_counts_though_the_contact_stops_it():
    memory = np.zeros((1, MEMORY_SIZE))
    memory[0, [ROBOT_SPEED, PERSON_SPEED]] = 0.2, 1.3
    row = count(memory, True, (0.2, 0.0))[0]
    assert row[Contact.BY_PERSON] == 1
    assert row[Contact.BY_ROBOT] == 0
    assert row[Contact.RELATIVE_SPEED] == pytest.approx(1.5)


def test_who_stays_near_is_in_the_same_contact():
    memory = np.zeros((1, MEMORY_SIZE))
    for touches in [True] + [False] * 20 + [True]:
        # 1 cm apart.
        memory = count(memory, touches, (0.5, 0.0), body=0.24)
        assert memory[0, Contact.LASTS] == 1
    assert memory[0, Contact.BY_ROBOT] == 1


@pytest.mark.parametrize("pause", [0.05, 0.2, 0.3])
def test_a_pause_parts_two_contacts(pause):
    memory = np.zeros((1, MEMORY_SIZE))
    steps = round(pause / STEP)
    for touches in [True] * 3 + [False] * steps + [True]:
        memory = count(memory, touches, (0.5, 0.0))
    expected = 1 if pause < CONTACT_PAUSE else 2
    assert memory[0, Contact.BY_ROBOT] == expected


def test_forces_add_up_and_the_peak_is_of_a_contact():
    memory = np.zeros((2, MEMORY_SIZE))
    forces = [[3, 4], [0, 10], [0, 0], [0, 1]]
    touches = [True, True, False, True]
    rows = []
    for force, touching in zip(forces, touches, strict=True):
        memory = count_contacts(
            memory,
            np.array([touching, False]),
            np.array([force, [0, 0]], dtype=float),
            np.array([0.05, 0.05]),
            np.array([[0.5, -0.5], [0.0, 0.0]]),
            # A pause of one step is long enough.
            0.3,
        )
        rows.append(memory[0])
    rows = np.array(rows)
    np.testing.assert_allclose(rows[:, Contact.PEAK_FORCE], [5, 10, 10, 1])
    np.testing.assert_allclose(
        rows[:, Contact.IMPULSE], 0.3 * np.array([5, 15, 15, 16])
    )
    assert rows[-1, Contact.BY_ROBOT] == 2
    # And not of anybody else.
    assert not memory[1, : Contact.BY_PERSON + 1].any()


@pytest.mark.parametrize("model", ["differential_drive", "pmb2"])
def test_a_robot_that_drives_into_somebody_is_charged(model):
    # (With HuNavSim's weights, no force moves it off the robot.)
    stander = HumanConfig(
        pose=(1.5, 0, math.pi),
        desired_speed=0.0,
        forces=SocialForceParameters(),
    )
    run = drive(make_diagram(model, [stander]), (0.5, 0), duration=4.0)
    row = run.contacts[-1, 0]
    assert row[Contact.BY_ROBOT] == 1
    assert row[Contact.BY_PERSON] == 0
    assert row[Contact.LASTS] == 1
    assert row[Contact.RELATIVE_SPEED] == pytest.approx(0.5, rel=0.1)
    assert (row[Contact.PEAK_FORCE] > 0) == (model == "pmb2")
    # It stops the one and not the other, and nobody is run over.
    distance = np.hypot(*(run.people[:, 0, :2] - run.robot[:, :2]).T)
    overlap = run.robot[0, 6] + 0.25 - distance.min()
    print(f"{model}: {1e3 * overlap:.1f} mm of overlap")
    assert overlap < 0.01
    stopped = abs(run.robot[-1, 3]) < 0.01
    assert stopped == (model == "pmb2")


@pytest.mark.parametrize("model", ["differential_drive", "pmb2"])
def test_who_runs_into_a_robot_is_charged(model):
    walker = HumanConfig(
        pose=(2, 0.01, math.pi), goals=[(-3, 0)], desired_speed=1.3
    )
    run = drive(make_diagram(model, [walker]), (0, 0), duration=4.0)
    row = run.contacts[-1, 0]
    assert row[Contact.BY_PERSON] == 1
    assert row[Contact.BY_ROBOT] == 0


@pytest.mark.parametrize("model", ["differential_drive", "pmb2"])
def test_who_passes_touches_nobody(model):
    walker = HumanConfig(
        pose=(2, 1.2, math.pi), goals=[(-3, 1.2)], desired_speed=1.3
    )
    run = drive(make_diagram(model, [walker]), (0, 0), duration=3.0)
    assert not run.contacts[..., : Contact.BY_PERSON + 1].any()
