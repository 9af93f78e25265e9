"""Contacts are counted, and charged, however bodies are kept apart."""

import itertools
import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import HumanConfig
from hunav_drake.systems.common.layout import Contact
from tests.systems.robot.driven_robots import drive, make_diagram

STEP = 0.05
PMB2_RADIUS = 0.27
# Starts of a person who crosses the path of a robot at 0.8 m/s, and is hit by
# its front, or runs into its front or side.
STARTS = [
    (x, -1.25 * (x - 2.8) - late)
    for x, late in itertools.product((2.8, 3.1, 3.4), (3.3, 3.6, 3.8))
]


def cross(start, model="differential_drive", *, keep_apart=True, every=STEP):
    """Returns the result of a blind robot and a distracted person."""
    walker = HumanConfig(
        pose=(*start, math.pi / 2),
        goals=[(start[0], 5)],
        behavior="distracted",
        desired_speed=1.0,
    )
    robot = {"type": model, "radius": PMB2_RADIUS, "limits": {}}
    diagram = make_diagram(robot, [walker], keep_apart=keep_apart)
    return drive(diagram, (0.8, 0), duration=7.0, every=every)


def begin(run):
    """Returns when the first contact begins, and both counts at the end."""
    rows = run.contacts[:, 0]
    first = int(np.argmax(rows[:, Contact.LASTS] > 0))
    return run.times[first], tuple(rows[-1, Contact.BY_ROBOT :].astype(int))


@pytest.fixture(scope="module")
def grid():
    """When contacts begin, and whose they are, without keeping bodies apart."""
    found = []
    for start in STARTS:
        run = cross(start, keep_apart=False)
        gap = np.hypot(*(run.people[:, 0, :2] - run.robot[:, :2]).T) - 0.52
        assert gap.min() < -0.01
        found.append((*begin(run), run.times[int(np.argmax(gap < 0))]))
    return found


def test_all_of_a_grid_of_collisions_count(grid):
    assert [sum(counts) for _, counts, _ in grid] == [1] * 9
    for time, _, overlap in grid:
        assert abs(time - overlap) <= STEP + 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("model", ["differential_drive", "pmb2"])
def test_bodies_kept_apart_are_in_the_same_contacts(grid, model):
    for start, (time, counts, _) in zip(STARTS, grid, strict=True):
        found = begin(cross(start, model))
        print(start, model, found, time, counts)
        assert found[1] == counts
        assert abs(found[0] - time) <= STEP + 1e-9


@pytest.mark.parametrize("step", [0.1, 0.05])
@pytest.mark.parametrize("model", ["differential_drive", "pmb2"])
@pytest.mark.parametrize("speed", [0.3, 0.5, 0.8])
def test_who_runs_into_a_robot_from_behind_is_charged(speed, model, step):
    """A person at 1.2 m/s, and a robot that drives away from there."""
    walker = HumanConfig(
        pose=(-1.5, 0.1, 0),
        goals=[(40, 0.1)],
        desired_speed=1.2,
        max_speed=1.2,
        # (The person does not feel the robot.)
        forces={"social_factor": 0.0},
    )
    robot = {"type": model, "radius": PMB2_RADIUS, "limits": {}}
    diagram = make_diagram(robot, [walker], time_step=step)
    run = drive(diagram, (speed, 0), duration=4.0, every=step)
    time, counts = begin(run)
    assert counts == (0, 1)
    row = run.contacts[int(np.argmax(run.times == time)), 0]
    assert row[Contact.RELATIVE_SPEED] == pytest.approx(1.2 - speed, abs=0.06)
    gap = np.hypot(*(run.people[:, 0, :2] - run.robot[:, :2]).T) - 0.52
    assert gap.min() < 1e-3
    # And pushes a robot that bodies stop.
    assert (run.contacts[-1, 0, Contact.IMPULSE] > 1) == (model == "pmb2")


def test_who_is_pushed_into_a_robot_by_others_is_charged():
    """Though the one next to the robot stood still."""
    humans = [
        HumanConfig(pose=(0.53, 0, 0), desired_speed=0.0),
        HumanConfig(pose=(1.04, 0, math.pi), goals=[(-5, 0)]),
    ]
    robot = {"type": "differential_drive", "radius": PMB2_RADIUS}
    diagram = make_diagram(robot, humans)
    context = diagram.CreateDefaultContext()
    crowd = diagram.GetSubsystemByName("humans").GetSubsystemByName("crowd")
    states = np.zeros((2, 6))
    states[:, 0] = 0.53, 1.04
    states[1, 3] = -1.5
    crowd.SetStates(crowd.GetMyMutableContextFromRoot(context), states)
    run = drive(diagram, (0, 0), duration=2 * STEP, context=context)
    last = run.contacts[-1]
    np.testing.assert_array_equal(last[:, Contact.BY_ROBOT :], [[0, 1], [0, 0]])


@pytest.mark.parametrize("seconds", [0.0, 0.5])
def test_who_stands_in_the_robot_at_the_start_is_in_a_contact(seconds):
    stander = HumanConfig(pose=(0.3, 0, 0), desired_speed=0.0)
    diagram = make_diagram({"type": "differential_drive"}, [stander])
    run = drive(diagram, (0, 0), duration=seconds + 2 * STEP)
    assert run.contacts[-1, 0, Contact.BY_ROBOT :].tolist() == [1, 1]


def test_contexts_do_not_share_contacts_and_a_clone_goes_on():
    start = STARTS[0]
    robot = {"type": "differential_drive", "radius": PMB2_RADIUS}
    walker = HumanConfig(
        pose=(*start, math.pi / 2),
        goals=[(start[0], 5)],
        behavior="distracted",
        desired_speed=1.0,
    )
    diagram = make_diagram(robot, [walker])
    whole = drive(diagram, (0.8, 0), duration=5.0)
    for pause in (3.2, 3.3, 3.35, 3.4):
        first = Simulator(diagram)
        drive(
            diagram,
            (0.8, 0),
            duration=pause,
            context=first.get_mutable_context(),
        )
        clone = first.get_context().Clone()
        # What happens elsewhere in between.
        drive(diagram, (0, 0), duration=1.0)
        rest = drive(diagram, (0.8, 0), duration=5.0, context=clone)
        np.testing.assert_array_equal(rest.contacts[-1], whole.contacts[-1])
