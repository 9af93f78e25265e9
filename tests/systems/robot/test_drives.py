"""Drives of carts: skid steer, Ackermann, mecanum, and passive casters."""

import math

from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.common.models import apart
from hunav_drake.systems.robot import ROBOTS, driven_model, plant_model
from hunav_drake.systems.world.obstacles import Obstacles
from tests.systems.robot.carts import (
    CAR,
    FOUR,
    MECANUM,
    RADIUS,
    SIX,
    STEERED,
    cart,
    reached,
    sides,
)
from tests.systems.robot.crate import write_model
from tests.systems.robot.driven_robots import drive, make_diagram

TWO = {"left": (0.0, 0.2), "right": (0.0, -0.2)}
TWO_WHEELS = {
    "left_wheel": "left",
    "right_wheel": "right",
    "wheel_separation": 0.4,
    "wheel_radius": RADIUS,
}
CASTERS = [(0.25, 0.1), (0.25, -0.1), (-0.25, 0.1), (-0.25, -0.1)]

# Its length is 0.5 m, its width 0.4 m, and the inner wheel turns by 0.6.
SHARPEST = 1 / (0.5 / math.tan(0.6) + 0.2)


@pytest.fixture(autouse=True)
def _without_trying(monkeypatch):
    """Saves the process in which a file is tried: these are sound."""
    monkeypatch.setattr(apart, "_is_other", True)


def make(folder, text, wheels, **more):
    return {
        "type": "urdf",
        "file": write_model(folder, text),
        "base": "base",
        "drive": wheels,
        "radius": 0.33,
        **more,
    }


def check(robot, commands, **tolerances):
    """Checks what (v, omega) is reached for each command."""
    diagram = make_diagram(robot)
    for command, expected in commands.items():
        got = reached(diagram, command)
        assert got == pytest.approx(expected, **tolerances), command


def same(*commands):
    return {command: command for command in commands}


@pytest.mark.parametrize(
    "wheels", [FOUR, pytest.param(SIX, marks=pytest.mark.slow)]
)
def test_a_skid_steer_reaches_its_command(wheels, tmp_path):
    robot = make(tmp_path, cart(wheels), sides(wheels))
    commands = same((0.5, 0.0), (0.0, 1.0), (0.3, 1.5), (-0.2, -0.3))
    check(robot, commands, rel=0.03, abs=0.005)


def test_wheels_of_a_skid_steer_must_slip(tmp_path):
    """Else they would need no more speed than the commanded turn."""
    robot = make(tmp_path, cart(FOUR), sides(FOUR))
    diagram = make_diagram(robot)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.get_input_port().FixValue(context, [0.0, 1.0])
    simulator.AdvanceTo(2.0)
    plant = diagram.GetSubsystemByName("plant")
    wheel = plant.GetJointByName("front_right_wheel")
    rate = wheel.get_angular_rate(plant.GetMyContextFromRoot(context))
    # Of equal loads: (x² + y²) / y, with places from the middle.
    lever = (0.25**2 + 0.2**2) / 0.2
    assert rate * RADIUS == pytest.approx(lever, rel=0.05)


def test_a_base_may_be_beside_the_middle_of_the_wheels(tmp_path):
    places = {name: (x, y - 0.1) for name, (x, y) in TWO.items()}
    casters = [(x, y - 0.1) for x, y in CASTERS]
    robot = make(tmp_path, cart(places, casters=casters), TWO_WHEELS)
    check(robot, same((0.5, 0.8), (-0.2, 0.4)), rel=0.03, abs=0.005)


def test_a_car_turns_as_sharply_as_it_can(tmp_path):
    commands = same((0.5, 0.0), (0.5, 0.5), (0.8, -0.8), (-0.2, -0.1)) | {
        (0.3, 1.5): (0.3, 0.3 * SHARPEST),
        (-0.2, -1.0): (-0.2, -0.2 * SHARPEST),
    }
    robot = make(tmp_path, cart(FOUR, steered=STEERED), CAR)
    check(robot, commands, rel=0.03, abs=0.005)


def test_a_car_does_not_turn_on_the_spot(tmp_path):
    robot = make(tmp_path, cart(FOUR, steered=STEERED), CAR)
    run = drive(make_diagram(robot), (0.0, 1.0), duration=3.0)
    assert run.robot[-1, :3] == pytest.approx(run.robot[0, :3], abs=1e-3)


def test_a_lower_limit_of_a_steering_joint_holds(tmp_path):
    text = cart(FOUR, steered=STEERED)
    steering = 'name="front_left_wheel_steering" type="continuous">'
    limit = '<limit lower="-0.2" upper="0.3" effort="99" velocity="9"/>'
    assert steering in text
    limited = steering.replace("continuous", "revolute") + limit
    robot = make(tmp_path, text.replace(steering, limited), CAR)
    _, omega = reached(make_diagram(robot), (0.3, 1.5))
    assert omega == pytest.approx(0.3 / (0.5 / math.tan(0.2) + 0.2), rel=0.03)


def test_mecanum_wheels_turn_as_their_rollers_ask(tmp_path):
    robot = make(tmp_path, cart(FOUR), MECANUM, start=(1.0, 2.0, 1.0))
    check(robot, same((0.5, 0.0), (0.8, -0.8)), rel=0.01, abs=1e-3)
    command = (0.4, 1.0)
    diagram = make_diagram(robot)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.get_input_port().FixValue(context, command)
    simulator.AdvanceTo(2.0)
    plant = diagram.GetSubsystemByName("plant")
    own = plant.GetMyContextFromRoot(context)
    v, omega = command
    for name in FOUR:
        sign = 1 if "left" in name else -1
        rate = plant.GetJointByName(name).get_angular_rate(own)
        expected = (v - sign * (0.25 + 0.2) * omega) / RADIUS
        assert rate == pytest.approx(expected, rel=0.01, abs=0.01)


def push(diagram, context):
    """Returns the sum of forces along x of all contacts, in N."""
    plant = diagram.GetSubsystemByName("plant")
    results = plant.get_contact_results_output_port().Eval(
        plant.GetMyContextFromRoot(context)
    )
    return sum(
        abs(results.point_pair_contact_info(k).contact_force()[0])
        for k in range(results.num_point_pair_contacts())
    )


def test_mecanum_wheels_push_with_their_torque_or_grip(tmp_path):
    wall = Obstacles.from_shapes([[[1, -3], [1, 3]]], solid=[False])
    robot = make(tmp_path, cart(FOUR), {**MECANUM, "max_torque": 0.5})
    diagram = make_diagram(robot, obstacles=wall)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.get_input_port().FixValue(context, [0.5, 0.0])
    simulator.AdvanceTo(3.0)
    pushed = push(diagram, context)
    assert pushed == pytest.approx(4 * 0.5 / RADIUS, rel=0.05)


def test_casters_swivel_and_cylinders_roll_on_their_middle(tmp_path):
    """Tilted by the rounding of a right angle, they would roll on an edge."""
    text = cart(TWO, casters=CASTERS).replace("1.5707963267948966", "1.57")
    robot = make(tmp_path, text, TWO_WHEELS)
    commands = same((0.5, 0.0), (-0.2, 0.5), (0.0, 1.0))
    check(robot, commands, rel=0.02, abs=0.002)


FAULTS = {
    "one joint twice": (
        cart(FOUR),
        {**sides(FOUR), "right_wheel": ["front_left_wheel"]},
        ("drive", "right_wheel"),
        "must be another joint than left_wheel, got 'front_left_wheel'",
    ),
    "an unknown joint among others": (
        cart(FOUR),
        {**sides(FOUR), "left_wheel": ["front_left_wheel", "rear_left"]},
        ("drive", "left_wheel"),
        "no joint 'rear_left' in the model; did you mean 'rear_left_wheel'",
    ),
    "one wheel on the other side": (
        cart(FOUR),
        {
            **sides(FOUR),
            "left_wheel": ["front_left_wheel", "rear_right_wheel"],
            "right_wheel": ["front_right_wheel", "rear_left_wheel"],
        },
        ("drive", "left_wheel"),
        "must be left of the right one",
    ),
    "a wheel that is not steered": (
        cart(FOUR),
        {**CAR, "left_steering": "front_left_wheel"},
        ("drive", "left_steering"),
        "must turn about the z axis of 'base', but the axis of",
    ),
    "steering behind": (
        cart(FOUR, steered=("rear_left_wheel", "rear_right_wheel")),
        {
            **CAR,
            "left_wheel": "front_left_wheel",
            "right_wheel": "front_right_wheel",
            "left_steering": "rear_left_wheel_steering",
            "right_steering": "rear_right_wheel_steering",
        },
        ("drive", "left_steering"),
        "must be ahead of the driven wheels",
    ),
    "one-sided steering": (
        cart(FOUR, steered=STEERED).replace(
            '<joint name="front_left_wheel_steering" type="continuous">',
            '<joint name="front_left_wheel_steering" type="revolute">'
            '<limit lower="0" upper="1" effort="9" velocity="9"/>',
        ),
        CAR,
        ("drive", "left_steering"),
        "must turn to both sides of straight ahead",
    ),
    "front and rear": (
        cart(FOUR),
        {
            **MECANUM,
            "front_left_wheel": "rear_left_wheel",
            "rear_left_wheel": "front_left_wheel",
        },
        ("drive", "front_left_wheel"),
        "must be ahead of rear_left_wheel",
    ),
}


@pytest.mark.parametrize(
    ("text", "wheels", "place", "words"), FAULTS.values(), ids=FAULTS
)
def test_wrong_wheels_are_told(text, wheels, place, words, tmp_path):
    robot = make(tmp_path, text, wheels)
    ((got, message),) = ROBOTS.make(robot).find_faults()
    assert got == place
    assert words in message


def test_what_is_fixed_slides_only_where_it_reaches_the_floor(tmp_path):
    ball = (
        '<link name="ball"><collision><geometry><sphere radius="0.03"/>'
        '</geometry></collision></link><joint name="fixed" type="fixed"><parent'
        ' link="base"/><child link="ball"/><origin xyz="0.25 0 -0.07"/></joint>'
    )
    text = cart(TWO).replace("</robot>", f"{ball}</robot>")
    wheels = {"type": "differential", **TWO_WHEELS}
    diagram = make_diagram(make(tmp_path, text, wheels))
    plant = diagram.GetSubsystemByName("plant")
    inspector = diagram.GetSubsystemByName("scene_graph").model_inspector()
    found = {}
    for name in ("base", "ball"):
        body = plant.GetBodyByName(name)
        (shape,) = plant.GetCollisionGeometriesForBody(body)
        friction = inspector.GetProximityProperties(shape).GetProperty(
            "material", "coulomb_friction"
        )
        found[name] = friction.dynamic_friction()
    assert found == {"base": 1.0, "ball": 0.1}


@pytest.mark.parametrize("omega", [-0.8, 0.8])
def test_an_omnidirectional_robot_turns_on_the_spot(omega, tmp_path):
    planar = {"type": "omnidirectional", "height": 0.11}
    robot = make(tmp_path, cart(FOUR), planar)
    got = reached(make_diagram(robot), (0.0, omega))
    assert got == pytest.approx((0.0, omega), abs=0.05)


def test_a_skid_steer_that_was_held_rests_when_it_is_to():
    wall = Obstacles.from_shapes(
        [[(0.6, -3), (0.7, -3), (0.7, 3), (0.6, 3)]], solid=[True]
    )
    diagram = make_diagram({"type": "jackal"}, obstacles=wall)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    port = diagram.get_input_port()
    port.FixValue(context, [0.5, 0.0])
    simulator.AdvanceTo(5.0)
    port.FixValue(context, [0.0, 0.0])
    simulator.AdvanceTo(7.0)
    assert push(diagram, context) < 10


def test_mecanum_wheels_turn_by_their_places(tmp_path):
    # The base is over the rear axle.
    places = {
        name: (0.1 if "rear" in name else 0.6, y)
        for name, (_, y) in FOUR.items()
    }
    robot = ROBOTS.make(make(tmp_path, cart(places), MECANUM))
    wheels = plant_model.inspect_model(robot.GetModel(), robot.drive).wheels
    arms = driven_model._arms(robot.drive, wheels)
    # The floor moves by omega x r under a wheel; rollers are diagonal.
    for wheel, arm in zip(wheels, arms, strict=True):
        x, y, _ = wheel.place
        roll = (
            1
            if wheel.setting in ("front_left_wheel", "rear_right_wheel")
            else -1
        )
        assert -arm == pytest.approx(-y - roll * x)
