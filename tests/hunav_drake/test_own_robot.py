"""A robot of one's own, in a MultibodyPlant, meets people."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PrismaticJoint, RevoluteJoint, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
import pytest

from hunav_drake import AddHumans, HumanConfig
from hunav_drake.systems.robot.body_state import AddBodyState

RADIUS = 0.25
SPEED = 0.8
# Powers of two: the plant's steps and the people's meet to the last bit.
PLANT_STEP = 1 / 64
CROWD_STEP = 1 / 16


def make_cart():
    """A box of 30 kg that motors push along x and y and turn."""
    plant = MultibodyPlant(time_step=PLANT_STEP)
    previous = plant.world_body()
    bodies = [
        plant.AddRigidBody("x_stage", SpatialInertia.Zero()),
        plant.AddRigidBody("y_stage", SpatialInertia.Zero()),
        plant.AddRigidBody(
            "base", SpatialInertia.SolidBoxWithMass(30.0, 0.4, 0.3, 0.5)
        ),
    ]
    kinds = [
        (PrismaticJoint, "x", [1, 0, 0]),
        (PrismaticJoint, "y", [0, 1, 0]),
        (RevoluteJoint, "yaw", [0, 0, 1]),
    ]
    for body, (kind, name, axis) in zip(bodies, kinds, strict=True):
        joint = plant.AddJoint(
            kind(
                name=name,
                frame_on_parent=previous.body_frame(),
                frame_on_child=body.body_frame(),
                axis=axis,
            )
        )
        plant.AddJointActuator(name, joint)
        previous = body
    plant.Finalize()
    plant.set_name("cart")
    return plant


class CarefulDriver(LeafSystem):
    """Drives the cart along x, and brakes before people.

    Motor forces hang on the people, who see the cart: a loop through both.
    """

    def __init__(self, num_humans):
        super().__init__()
        self._cart = self.DeclareVectorInputPort("cart", 6)
        self._people = self.DeclareVectorInputPort("people", 7 * num_humans)
        self.DeclareVectorOutputPort("forces", 3, self._CalcForces)

    def _CalcForces(self, context, output):
        cart = self._cart.Eval(context)
        people = self._people.Eval(context).reshape(-1, 7)
        ahead = people[:, 0] > cart[0]
        distance = np.hypot(*(people[:, :2] - cart[:2]).T)
        near = (ahead & (distance < 0.9)).any()
        speed = 0.0 if near else SPEED
        output.SetFromVector(
            [
                120.0 * (speed - cart[3]),
                -200.0 * cart[1] - 150.0 * cart[4],
                -40.0 * cart[2] - 20.0 * cart[5],
            ]
        )


def make_oncoming_people():
    """Three people who come towards the cart, one beside the other."""
    return [
        HumanConfig(
            pose=[8, y, np.pi], goals=[[-4, y]], desired_speed=1.0, radius=0.25
        )
        for y in (-2.5, 0.3, 2.5)
    ]


def make_meeting(*, unseen=False):
    builder = DiagramBuilder()
    plant = builder.AddSystem(make_cart())
    robot_state = AddBodyState(
        builder, plant, plant.GetBodyByName("base"), radius=RADIUS
    )
    people = make_oncoming_people()
    humans = AddHumans(
        builder, people, num_robots=0 if unseen else 1, time_step=CROWD_STEP
    )
    if not unseen:
        builder.Connect(robot_state, humans.robot_states)
    driver = builder.AddNamedSystem("driver", CarefulDriver(len(people)))
    builder.Connect(plant.get_state_output_port(), driver.get_input_port(0))
    builder.Connect(humans.human_states, driver.get_input_port(1))
    builder.Connect(driver.get_output_port(), plant.get_actuation_input_port())
    builder.ExportOutput(robot_state, "robot_state")
    builder.ExportOutput(humans.human_states, "human_states")
    return builder.Build()


def record_crowd_steps(diagram, end, context=None):
    """The robot and the people at each step of the crowd, and the Context."""
    simulator = (
        Simulator(diagram) if context is None else Simulator(diagram, context)
    )
    context = simulator.get_context()
    first = round(context.get_time() / CROWD_STEP)
    rows = []
    for k in range(first, round(end / CROWD_STEP) + 1):
        # Even a step of no length would do the update that is due now.
        if k > first:
            simulator.AdvanceTo(k * CROWD_STEP)
        rows.append(
            [
                diagram.GetOutputPort(name).Eval(context).copy()
                for name in ("robot_state", "human_states")
            ]
        )
    robot, people = (np.array(column) for column in zip(*rows, strict=True))
    return robot, people.reshape(len(people), -1, 7), context


@pytest.fixture(scope="module")
def meeting():
    diagram = make_meeting()
    return diagram, *record_crowd_steps(diagram, 12.0)


def test_the_cart_and_the_people_pass_each_other(meeting):
    _, robot, people, _ = meeting
    assert robot[-1, 0] > 5.0
    assert (people[-1, :, 0] < -3.0).all()
    gaps = np.hypot(*(people[:, :, :2] - robot[:, None, :2]).T) - 2 * RADIUS
    print(f"smallest gap between cart and people: {gaps.min():.2f} m")
    assert gaps.min() > 0.0


def test_people_leave_their_line_for_the_cart_alone(meeting):
    _, _, people, _ = meeting
    _, blind, _ = record_crowd_steps(make_meeting(unseen=True), 12.0)
    swerve = abs(people[:, 1, 1] - 0.3).max()
    without = abs(blind[:, 1, 1] - 0.3).max()
    print(f"swerve: {swerve:.2f} m, without the cart: {without:.2f} m")
    assert swerve > 0.2
    assert without < 0.05


def test_people_see_what_the_plant_does(meeting):
    _, robot, _, _ = meeting
    assert (robot[:, 6] == RADIUS).all()
    # The speed is the derivative of the position, by the plant's steps.
    dx = np.diff(robot[:, 0]) / CROWD_STEP
    mean_v = (robot[1:, 3] + robot[:-1, 3]) / 2
    np.testing.assert_allclose(dx, mean_v, atol=0.05)


def test_a_clone_goes_on_as_the_whole(meeting):
    diagram, robot, people, _ = meeting
    _, _, halfway = record_crowd_steps(diagram, 5.0)
    fork_robot, fork_people, _ = record_crowd_steps(
        diagram, 12.0, halfway.Clone()
    )
    start = round(5.0 / CROWD_STEP)
    np.testing.assert_array_equal(fork_robot, robot[start:])
    np.testing.assert_array_equal(fork_people, people[start:])
