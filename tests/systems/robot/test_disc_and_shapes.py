"""Models whose shapes are smaller than the disc that people keep off."""

import math
import warnings

import numpy as np
import pytest

from hunav_drake import CheckScenario, HumanConfig, LoadScenario, Scenario
from hunav_drake.systems.common.layout import Contact
from hunav_drake.systems.robot import ROBOTS
from hunav_drake.systems.robot.plant_robot import body_reach
from tests.systems.robot.driven_robots import drive, make_diagram

BURGER = """
<robot name="burger"><link name="base">
  <inertial><origin xyz="0 0 0.1"/><mass value="1.0"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>
  </inertial>
  <collision><origin xyz="0 0 0.1"/>
    <geometry>{shape}</geometry></collision>
</link></robot>
"""
CYLINDER = '<cylinder radius="0.11" length="0.18"/>'


@pytest.fixture
def burger(tmp_path):
    """Returns the data of a robot of a shape and with a disc of a radius."""

    def make(radius, shape=CYLINDER):
        file = tmp_path / "burger.urdf"
        file.write_text(BURGER.format(shape=shape))
        return {
            "type": "urdf",
            "file": str(file),
            "base": "base",
            "radius": radius,
            "drive": {"type": "omnidirectional", "max_force": 400.0},
        }

    return make


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "reach"),
    [
        (CYLINDER, 0.11),
        ('<sphere radius="0.1"/>', 0.1),
        ('<box size="0.6 0.8 0.1"/>', 0.5),
    ],
)
def test_the_reach_is_that_of_the_shapes(burger, shape, reach):
    robot = ROBOTS.make(burger(0.2, shape))
    reached = body_reach(robot.GetModel(), robot.GetDrive())
    assert reached == pytest.approx(reach, rel=0.01)


def test_no_shape_of_pmb2_reaches_beyond_its_disc():
    robot = ROBOTS.make("pmb2")
    reached = body_reach(robot.GetModel(), robot.GetDrive())
    assert reached == pytest.approx(robot.radius, abs=5e-4)


@pytest.mark.slow
@pytest.mark.parametrize("radius", [0.105, 0.11, 0.129, 0.131, 0.3])
def test_a_disc_2_cm_larger_than_the_model_is_a_warning(burger, radius):
    scenario = Scenario(robot={**burger(radius), "goal": (3, 0, 0)})
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        CheckScenario(scenario)
    told = [str(it.message) for it in caught if "radius" in str(it.message)]
    assert bool(told) == (radius > 0.13)
    if told:
        assert "0.11 m" in told[0]
        assert "robot.radius" in told[0]


def test_a_file_is_warned_of_too():
    with pytest.warns(UserWarning, match=r"robot\.radius"):
        LoadScenario(data="robot: {type: pmb2, radius: 0.35}")


@pytest.mark.parametrize("disc", [0.11, 0.3])
def test_who_is_pushed_by_the_disc_is_in_a_contact(burger, disc):
    """With a force on the robot where its shape is as large, else without."""
    stander = HumanConfig(pose=(1.0, 0.02, math.pi), desired_speed=0.0)
    run = drive(make_diagram(burger(disc), [stander]), (0.4, 0), duration=4.0)
    row = run.contacts[-1, 0]
    assert row[Contact.BY_ROBOT] == 1
    assert row[Contact.BY_PERSON] == 0
    assert row[Contact.RELATIVE_SPEED] == pytest.approx(0.4, abs=0.12)
    moved = np.hypot(*(run.people[-1, 0, :2] - run.people[0, 0, :2]))
    assert (row[Contact.PEAK_FORCE] > 0) == (disc < 0.2)
    if disc > 0.2:
        assert moved > 0.1


@pytest.mark.parametrize("disc", [0.11, 0.3])
def test_who_runs_into_the_disc_is_charged(burger, disc):
    walker = HumanConfig(
        pose=(2, 0.01, math.pi), goals=[(-3, 0)], behavior="distracted"
    )
    run = drive(make_diagram(burger(disc), [walker]), (0, 0), duration=4.0)
    gap = np.hypot(*(run.people[:, 0, :2] - run.robot[:, :2]).T) - disc - 0.25
    row = run.contacts[-1, 0]
    assert (row[Contact.BY_PERSON] > 0) == (gap.min() < 0)
    assert row[Contact.BY_ROBOT] == 0
