"""Robots from users' files: driving, and messages of faults."""

import math
import re

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest
import yaml

from hunav_drake import HumanConfig, LoadScenario, ScenarioError
from hunav_drake.systems.common.layout import Contact
from hunav_drake.systems.robot import ROBOTS, DriveConfig
from hunav_drake.systems.world.obstacles import Obstacles
from tests.robot_models import ROBOTS as MODELS
from tests.systems.robot.crate import (
    CRATE,
    FOOTPRINT,
    STAGES,
    WITHOUT_MASS,
    write_model,
)
from tests.systems.robot.driven_robots import drive, make_diagram

PMB2 = "package://hunav_drake/systems/robot/models/pmb2.sdf"
WHEELS = {
    "type": "differential",
    "left_wheel": "left_wheel_joint",
    "right_wheel": "right_wheel_joint",
    "wheel_separation": 0.4044,
    "wheel_radius": 0.0985,
    "max_torque": 6.0,
}


TURTLE = {
    "left_wheel": "left_joint",
    "right_wheel": "right_joint",
    "wheel_separation": 0.3,
    "wheel_radius": 0.08,
}


@pytest.fixture
def crate(tmp_path):
    return {
        "type": "urdf",
        "file": write_model(tmp_path, CRATE),
        "base": "chassis",
        "drive": {"type": "omnidirectional", "height": 0.2, "max_force": 150.0},
        # Half its width: people are not kept farther off than it hits them.
        "radius": 0.2,
    }


@pytest.fixture
def stages(tmp_path):
    return {
        "type": "urdf",
        "file": write_model(tmp_path, STAGES),
        "base": "chassis",
        "drive": {
            "type": "omnidirectional",
            "x": "along_x",
            "y": "along_y",
            "yaw": "turn",
        },
    }


def test_pmb2_from_its_file_is_pmb2():
    robot = {"file": PMB2, "base": "base", "drive": WHEELS, "radius": 0.27}
    robot["drive"] = {**WHEELS, "max_wheel_speed": 1 / 0.0985}
    runs = [
        drive(make_diagram(it), (0.4, 0.3), duration=2.0)
        for it in ({"type": "urdf", **robot}, "pmb2")
    ]
    np.testing.assert_array_equal(runs[0].robot, runs[1].robot)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["crate", "stages"])
@pytest.mark.parametrize("start", [(0, 0, 0), (1.0, -2.0, 2.0)])
def test_a_planar_base_drives_along_its_heading(kind, start, request):
    robot = {**request.getfixturevalue(kind), "start": start}
    run = drive(make_diagram(robot), (0.5, 0.4), duration=4.0)
    np.testing.assert_allclose(run.robot[0, :3], start, atol=1e-9)
    _, _, yaw, vx, vy, omega, _ = run.robot[-1]
    assert math.hypot(vx, vy) == pytest.approx(0.5, rel=0.02)
    assert omega == pytest.approx(0.4, rel=0.02)
    assert math.atan2(vy, vx) == pytest.approx(
        math.remainder(yaw, 2 * math.pi), abs=0.01
    )
    # That of a circle of radius v / omega, but for the ramps.
    turned = 0.4 * 4.0 - 0.4 * 0.4 / 2.09 / 2
    assert math.remainder(yaw - start[2], 2 * math.pi) == pytest.approx(
        turned, abs=0.02
    )


@pytest.mark.slow
def test_a_planar_base_pushes_with_its_largest_force(crate):
    person = HumanConfig(pose=(2, 0, math.pi), desired_speed=0.0)
    run = drive(make_diagram(crate, [person]), (0.5, 0), duration=6.0)
    assert run.robot[-1, 3] == pytest.approx(0, abs=0.01)
    # What hits is the front of the box, 0.3 m ahead, not the disc.
    assert run.robot[-1, 0] == pytest.approx(2 - 0.3 - 0.25, abs=0.05)
    assert -run.contacts[-1, 0, Contact.FORCE_X] == pytest.approx(150, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("base", ["base_footprint", "base_link"])
def test_a_base_may_be_fixed_to_what_lies_on_the_floor(tmp_path, base):
    robot = {
        "type": "urdf",
        "file": write_model(tmp_path, FOOTPRINT),
        "base": base,
        "start": (1.0, 2.0, 1.0),
        "drive": TURTLE,
    }
    run = drive(make_diagram(robot), (0.4, 0.0), duration=4.0)
    np.testing.assert_allclose(run.robot[0, :3], [1, 2, 1], atol=1e-9)
    x, y, yaw, *_ = run.robot[-1]
    assert yaw == pytest.approx(1, abs=0.02)
    assert math.atan2(y - 2, x - 1) == pytest.approx(1, abs=0.02)
    assert math.hypot(x - 1, y - 2) == pytest.approx(0.4 * 3.8, abs=0.05)


BOOM = """<robot name="boom"><link name="boom">
  <inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1"
    iyz="0" izz="0.1"/></inertial>
  <collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry>
  </collision></link>{more}</robot>
"""


def with_boom(folder, more=""):
    """A robot whose file is made of two models."""
    write_model(folder, FOOTPRINT)
    (folder / "boom.urdf").write_text(BOOM.format(more=more))
    directives = [
        {"add_model": {"name": name, "file": f"file://{folder}/{file}"}}
        for name, file in (("turtle", "robot.urdf"), ("boom", "boom.urdf"))
    ]
    weld = {"parent": "turtle::base_link", "child": "boom::boom"}
    weld |= {"X_PC": {"translation": [0, 0, 0.3]}}
    file = folder / "robot.dmd.yaml"
    directives.append({"add_weld": weld})
    file.write_text(yaml.safe_dump({"directives": directives}))
    robot = {"type": "urdf", "file": str(file), "base": "base_link"}
    return {**robot, "drive": TURTLE, "radius": 0.2}


@pytest.mark.slow
def test_contacts_of_a_part_from_another_model_count(tmp_path):
    person = HumanConfig(pose=(2, 0, math.pi), desired_speed=0.0)
    dut = make_diagram(with_boom(tmp_path), [person])
    run = drive(dut, (0.4, 0), duration=5.0)
    # Its end is 1 m ahead, and the person 0.25 m wide to each side.
    assert run.robot[-1, 0] == pytest.approx(2 - 1 - 0.25, abs=0.02)
    contact = run.contacts[-1, 0]
    assert contact[Contact.BY_ROBOT] == 1
    assert contact[Contact.FORCE_X] < -10


@pytest.mark.slow
def test_a_motor_of_another_model_is_told(tmp_path):
    more = """<link name="tip"><inertial><mass value="1"/><inertia ixx="0.1"
    ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <joint name="wrist" type="revolute"><parent link="boom"/><child link="tip"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="9" velocity="1"/>
  </joint><transmission name="motor">
    <type>transmission_interface/SimpleTransmission</type>
    <joint name="wrist"/><actuator name="motor"/></transmission>"""
    ((place, message),) = ROBOTS.make(with_boom(tmp_path, more)).find_faults()
    assert place == ("file",)
    assert "has the motor 'motor' in another model, 'boom', than" in message


@pytest.mark.slow
@pytest.mark.parametrize("side", ["left", "right"])
def test_wheels_may_turn_the_other_way(tmp_path, side):
    """As where a wheel is the other one, turned around."""
    head, tail = FOOTPRINT.split(f'<joint name="{side}_joint"')
    turned = tail.replace('axis xyz="0 1 0"', 'axis xyz="0 -1 0"', 1)
    text = f'{head}<joint name="{side}_joint"{turned}'
    robot = {
        "type": "urdf",
        "file": write_model(tmp_path, text),
        "base": "base_link",
        "drive": TURTLE,
    }
    run = drive(make_diagram(robot), (0.3, 0.2), duration=2.0)
    assert run.robot[-1, 5] == pytest.approx(0.2, rel=0.05)
    assert run.robot[-1, 0] == pytest.approx(0.3 * 1.85, abs=0.05)


@pytest.mark.slow
def test_wheels_turn_about_the_y_axis(stages, tmp_path):
    upright = FOOTPRINT.replace('axis xyz="0 1 0"', 'axis xyz="0 0 1"')
    stages |= {
        "file": write_model(tmp_path, upright),
        "base": "base_link",
        "drive": TURTLE,
    }
    ((place, message),) = ROBOTS.make(stages).find_faults()
    assert place == ("drive", "left_wheel")
    assert "must turn about the y axis of 'base_link'" in message


def test_walls_stop_a_box_at_its_front(crate):
    wall = Obstacles.from_shapes([[[1, -3], [1, 3]]], solid=[False])
    run = drive(make_diagram(crate, obstacles=wall), (0.8, 0), duration=4.0)
    assert run.robot[-1, 0] == pytest.approx(0.7, abs=0.005)


def test_motors_that_do_not_drive_hold_their_place(crate):
    diagram = make_diagram(crate)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.get_input_port().FixValue(context, [0.8, 0.5])
    simulator.AdvanceTo(3.0)
    plant = diagram.GetSubsystemByName("plant")
    arm = plant.GetJointByName("shoulder")
    # The arm weighs 2 kg, 0.3 m from its joint.
    angle = arm.get_angle(plant.GetMyContextFromRoot(context))
    assert abs(angle) < 0.002


@pytest.mark.slow
def test_paths_start_at_the_scenario_file(tmp_path, monkeypatch):
    folder = tmp_path / "models"
    folder.mkdir()
    write_model(folder, CRATE)
    robot = {
        "type": "urdf",
        "file": "models/robot.urdf",
        "base": "chassis",
        "drive": "omnidirectional",
    }
    file = tmp_path / "trial.yaml"
    file.write_text(yaml.safe_dump({"robot": robot}))
    monkeypatch.chdir("/")
    scenario = LoadScenario(filename=file)
    assert scenario.robot.file == str(folder / "robot.urdf")
    robot |= {
        "file": "package://mine/robot.urdf",
        "packages": {"mine": "models"},
    }
    file.write_text(yaml.safe_dump({"robot": robot}))
    assert LoadScenario(filename=file).robot.packages == {"mine": str(folder)}


FAULTS = {
    "missing file": (
        {"file": "/nowhere/robot.urdf"},
        "robot.file",
        "there is no file '/nowhere/robot.urdf'; check the path",
    ),
    "missing package": (
        {"file": "package://hunav_drak/robot.urdf"},
        "robot.file",
        "no package 'hunav_drak'; did you mean 'hunav_drake'.*ROS_PACKAGE",
    ),
    "missing folder": (
        {"packages": {"mine": "/nowhere"}},
        "robot.packages.mine",
        "there is no folder '/nowhere'",
    ),
    "unknown body": (
        {"base": "bass"},
        "robot.base",
        "there is no body 'bass' in the model; did you mean 'base'",
    ),
    "wrong base": (
        {"base": "left_wheel"},
        "robot.base",
        "'left_wheel' moves relative to 'base', .*; choose 'base'",
    ),
    "base that hangs on another": (
        {"base": "left_wheel", "drive": "omnidirectional"},
        "robot.base",
        "'left_wheel' is carried by 'base', so no motors.*nothing carries",
    ),
    "unknown joint": (
        {"drive": {**WHEELS, "left_wheel": "left_wheel_join"}},
        "robot.drive.left_wheel",
        "no joint 'left_wheel_join' in the.*did you mean 'left_wheel_joint'",
    ),
    "one joint twice": (
        {"drive": {**WHEELS, "right_wheel": "left_wheel_joint"}},
        "robot.drive.right_wheel",
        "must be another joint than left_wheel",
    ),
    "a joint that does not turn": (
        {"file": PMB2, "drive": {**WHEELS, "left_wheel": "base"}},
        "robot.drive.left_wheel",
        "there is no joint 'base' in the model",
    ),
    "wheels the wrong way around": (
        {
            "drive": {
                **WHEELS,
                "left_wheel": "right_wheel_joint",
                "right_wheel": "left_wheel_joint",
            }
        },
        "robot.drive.left_wheel",
        "must be left of the right one.*swap them",
    ),
    "a joint of another kind": (
        {
            "drive": {
                "type": "omnidirectional",
                "x": "left_wheel_joint",
                "y": "a",
                "yaw": "b",
            }
        },
        "robot.drive.x",
        "must be a prismatic joint, but 'left_wheel_joint' is revolute",
    ),
}


@pytest.mark.parametrize(
    ("change", "path", "words"), FAULTS.values(), ids=FAULTS
)
def test_what_cannot_drive_is_told_before_anything_runs(change, path, words):
    robot = {"type": "urdf", "file": PMB2, "base": "base", "drive": WHEELS}
    with pytest.raises(ScenarioError, match=words) as info:
        LoadScenario(data=yaml.safe_dump({"robot": {**robot, **change}}))
    (fault,) = info.value.faults
    assert fault.path == path
    assert fault.line == 1 or fault.line > 0


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        (WITHOUT_MASS, ("file",), "has no mass"),
        ("<robot>", ("file",), "cannot be read: "),
    ],
)
def test_faulty_files_are_told(crate, tmp_path, text, place, words):
    crate["file"] = write_model(tmp_path, text)
    ((got, message),) = ROBOTS.make(crate).find_faults()
    assert got == place
    assert words in message


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        ({"yaw": ""}, "yaw", "is missing; name all of x, y and yaw"),
        (
            {"x": "along_y", "y": "along_x"},
            "x",
            "must move 'chassis' along x of the world, but 0.1 of 'along_y'",
        ),
    ],
)
def test_wrong_planar_joints_are_told(stages, change, key, words):
    stages["drive"] |= change
    ((place, message),) = ROBOTS.make(stages).find_faults()
    assert place == ("drive", key)
    assert words in message


@pytest.mark.slow
def test_planar_joints_that_turn_with_the_base_are_told(stages, tmp_path):
    """They would be along the world's axes at yaw 0 only."""
    text = STAGES
    for joint, ends in (
        ("turn", '<parent link="world"/><child link="x"/>'),
        ("along_x", '<parent link="x"/><child link="y"/>'),
        ("along_y", '<parent link="y"/><child link="chassis"/>'),
    ):
        head, tail = text.split(f'<joint name="{joint}"')
        tail = re.sub("<parent.*?/><child.*?/>", ends, tail, count=1)
        text = f'{head}<joint name="{joint}"{tail}'
    stages["file"] = write_model(tmp_path, text)
    ((place, message),) = ROBOTS.make(stages).find_faults()
    assert place == ("drive", "x")
    assert "0.1 of 'along_x' changes (x, y, yaw) by [0.0995, 0.00" in message


@pytest.mark.slow
def test_a_start_outside_of_the_limits_of_a_joint_is_told(stages):
    """The robot would be flung back at hundreds of meters per second."""
    stages["start"] = (3.0, -60.0, 0.0)
    ((place, message),) = ROBOTS.make(stages).find_faults()
    assert place == ("start",)
    assert "must have y in [-50, 50], the limits of the model's" in message


@pytest.mark.slow
def test_a_robot_does_not_carry_the_world(tmp_path):
    """Its figure would be a loop, which Drake refuses."""
    text, base, drive = MODELS["turtle.urdf"]
    child = '<child link="rear_caster"/>'
    assert child in text
    (tmp_path / "a.urdf").write_text(
        text.replace(child, '<child link="world"/>')
    )
    robot = {"model": "urdf", "file": str(tmp_path / "a.urdf"), "base": base}
    ((place, message),) = ROBOTS.make(robot | {"drive": drive}).find_faults()
    assert place == ("file",)
    assert "'rear_caster_joint' that carries the world; give it" in message


@pytest.mark.slow
def test_wheels_cannot_drive_what_the_world_carries(stages):
    stages["drive"] = {
        "left_wheel": "turn",
        "right_wheel": "along_x",
        "wheel_separation": 0.4,
        "wheel_radius": 0.1,
    }
    ((place, message),) = ROBOTS.make(stages).find_faults()
    assert place == ("base",)
    assert "is carried by the world, so wheels cannot move it" in message


def test_a_drive_of_ones_own_is_refused():
    with pytest.raises(TypeError, match=r"Hover cannot be a drive: .*register"):

        class Hover(DriveConfig):
            """Drives in the air."""
