"""A body of a plant, as people see it."""

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.framework import DiagramBuilder
import pytest

from hunav_drake.systems.robot.body_state import AddBodyState, BodyState

INERTIA = SpatialInertia.SolidBoxWithMass(10.0, 0.5, 0.4, 0.3)


def make_plant(*names):
    plant = MultibodyPlant(0.0)
    for name in names:
        plant.AddRigidBody(name, INERTIA)
    plant.Finalize()
    return plant


@pytest.fixture
def robots():
    """Two free bodies, and what people see of the second."""
    builder = DiagramBuilder()
    plant = builder.AddSystem(make_plant("first", "second"))
    body = plant.GetBodyByName("second")
    port = AddBodyState(builder, plant, body, radius=0.4)
    builder.ExportOutput(port, "robot_state")
    return builder.Build(), plant, body


def see(robots, X_WB, V_WB):
    diagram, plant, body = robots
    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    plant.SetFreeBodyPose(plant_context, body, X_WB)
    plant.SetFreeBodySpatialVelocity(plant_context, body, V_WB)
    return diagram.GetOutputPort("robot_state").Eval(context)


@pytest.mark.parametrize("yaw", [-3.0, 0.0, 0.7, 3.1])
@pytest.mark.parametrize("pitch", [0.0, 0.4, -0.4])
def test_people_see_the_shadow_on_the_floor(robots, yaw, pitch):
    X_WB = RigidTransform(RollPitchYaw(0.2, pitch, yaw), [1.0, -2.0, 5.0])
    V_WB = SpatialVelocity(w=[0.1, 0.2, 0.3], v=[0.4, 0.5, 0.6])
    np.testing.assert_allclose(
        see(robots, X_WB, V_WB),
        [1.0, -2.0, yaw, 0.4, 0.5, 0.3, 0.4],
        atol=1e-12,
    )


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2])
def test_a_body_that_looks_up_or_down_has_no_yaw(robots, pitch):
    X_WB = RigidTransform(RollPitchYaw(0.0, pitch, 1.0), [0.0, 0.0, 0.0])
    assert see(robots, X_WB, SpatialVelocity.Zero())[2] == 0.0


def test_the_output_follows_each_input(robots):
    """The ports' prerequisites are declared: nothing stale is seen."""
    diagram, plant, body = robots
    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    port = diagram.GetOutputPort("robot_state")
    for x in (1.0, 2.0):
        plant.SetFreeBodyPose(plant_context, body, RigidTransform([x, 0, 0]))
        assert port.Eval(context)[0] == x
        velocity = SpatialVelocity(w=[0, 0, 0], v=[-x, 0, 0])
        plant.SetFreeBodySpatialVelocity(plant_context, body, velocity)
        assert port.Eval(context)[3] == -x


def test_both_inputs_feed_through():
    dut = BodyState(make_plant("base").GetBodyByName("base").index(), 0.3)
    assert dut.HasDirectFeedthrough(0, 0)
    assert dut.HasDirectFeedthrough(1, 0)
    # A plant's poses do not hang on its inputs, so a robot that reacts to
    # people makes no algebraic loop: see test_own_robot.py.


@pytest.mark.parametrize("radius", [0.0, -1.0, np.inf, np.nan])
def test_a_radius_that_is_none_is_refused(radius):
    plant = make_plant("base")
    with pytest.raises(ValueError, match="radius must be positive"):
        BodyState(plant.GetBodyByName("base").index(), radius)


def test_a_plant_must_be_finalized():
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(0.0))
    body = plant.AddRigidBody("base", INERTIA)
    with pytest.raises(ValueError, match="Finalize"):
        AddBodyState(builder, plant, body, radius=0.3)


def test_a_body_of_another_plant_is_refused():
    builder = DiagramBuilder()
    plant = builder.AddSystem(make_plant("base"))
    other = make_plant("base")
    with pytest.raises(ValueError, match="does not belong to plant"):
        AddBodyState(builder, plant, other.GetBodyByName("base"), radius=0.3)


def test_a_body_is_added_once():
    """Drake would end the interpreter."""
    builder = DiagramBuilder()
    plant = builder.AddSystem(make_plant("base"))
    body = plant.GetBodyByName("base")
    AddBodyState(builder, plant, body, radius=0.3)
    with pytest.raises(ValueError, match="connect its port robot_state"):
        AddBodyState(builder, plant, body, radius=0.3)
