"""The robots whose models are in the package."""

import math

import pytest

from hunav_drake.systems.robot import ROBOTS, RobotLimits
from hunav_drake.systems.robot.plant_robot import body_reach
from hunav_drake.systems.robot.robots import PackageRobot
from tests.choices import shipped
from tests.systems.robot.carts import reached
from tests.systems.robot.driven_robots import make_diagram

PRESETS = [
    name for name in shipped(ROBOTS) if issubclass(ROBOTS[name], PackageRobot)
]

# The published mass of each, in kg.
MASSES = {
    "jackal": 16.523 + 4 * 0.477,
    "pmb2": 28.27 + 2 * 1.82,
    "tiago_base": 28.27 + 14.01 + 6.93 + 1.28 + 2 * 1.82,
    "turtlebot3_burger": 1.0,
    "turtlebot3_waffle": 1.8,
}


def commands(limits: RobotLimits):
    """Returns (v, omega) within the limits, and those of the wheels."""
    v, omega = limits.max_speed, limits.max_turn_rate
    back = limits.max_reverse_speed
    return [
        (0.9 * v, 0.0),
        (0.0, 0.7 * omega),
        (0.5 * v, 0.3 * omega),
        (0.3 * v, -0.5 * omega),
        (-0.8 * back, 0.2 * omega),
    ]


@pytest.mark.parametrize(
    "time_step",
    [
        0.05,
        pytest.param(0.02, marks=pytest.mark.slow),
        pytest.param(0.1, marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("name", PRESETS)
def test_each_reaches_its_command(name, time_step):
    config = ROBOTS.make(name)
    diagram = make_diagram(name, time_step=time_step)
    for command in commands(config.limits):
        got = reached(diagram, command, time_step=time_step)
        assert got == pytest.approx(command, rel=0.03, abs=0.015), command


@pytest.mark.parametrize("name", PRESETS)
def test_the_disc_covers_the_body_and_no_more(name):
    config = ROBOTS.make(name)
    reach = body_reach(config.GetModel(), config.GetDrive())
    # (It is an upper bound.)
    assert reach - 1e-3 <= config.radius < reach + 0.01
    assert list(config.find_faults()) == []
    assert list(config.find_doubts()) == []


@pytest.mark.parametrize("name", PRESETS)
def test_each_has_its_mass_and_starts_on_its_wheels(name):
    start = (1.0, -2.0, math.pi / 2)
    diagram = make_diagram({"type": name, "start": start})
    context = diagram.CreateDefaultContext()
    row = diagram.GetOutputPort("robot_state").Eval(context)
    assert row[:3] == pytest.approx(start)
    plant = diagram.GetSubsystemByName("plant")
    own = plant.GetMyContextFromRoot(context)
    model = plant.GetModelInstanceByName(name)
    mass = plant.CalcTotalMass(own, [model])
    assert mass == pytest.approx(MASSES[name], rel=1e-3)
    base = plant.GetBodyByName("base")
    for index in plant.GetJointIndices(model):
        joint = plant.get_joint(index)
        if joint.num_velocities() == 1:
            wheel = plant.EvalBodyPoseInWorld(own, joint.child_body())
            assert wheel.translation()[2] == pytest.approx(
                config_radius(name), abs=1e-3
            )
    assert plant.EvalBodyPoseInWorld(own, base).translation()[2] == 0


def config_radius(name):
    return ROBOTS.make(name).GetDrive().wheel_radius
