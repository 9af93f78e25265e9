"""Contacts of a robot with a free person, against closed forms.

In trials, motors hold a body on the way of its person; here they are off. The
robot is a sliding disc of 50 kg, the person has 75 kg.
"""

import math

import numpy as np
from pydrake.geometry import (
    AddContactMaterial,
    Cylinder,
    ProximityProperties,
    RoleAssign,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import (
    CoulombFriction,
    DiscreteContactApproximation,
    MultibodyPlant,
)
from pydrake.multibody.tree import PlanarJoint, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
import pytest

from hunav_drake.systems.common.layout import RADIUS, Contact
from hunav_drake.systems.evaluation.encounters import find_encounters
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.robot.body_state import AddBodyState
from hunav_drake.systems.robot.plant_contacts import PlantContacts
from hunav_drake.systems.robot.plant_people import (
    PEOPLE,
    AddPeople,
    people_states,
)

MASSES = 50.0, 75.0
REDUCED = MASSES[0] * MASSES[1] / sum(MASSES)
SIZE, HEIGHT = 0.3, 1.7
# Of both bodies in series, in N/m.
STIFFNESS = 25e3


def make_plant(step, *, stiffness=None):
    """Returns a builder with a plant of a robot at 0 and a person at 1 m."""
    builder = DiagramBuilder()
    scene_graph = builder.AddNamedSystem("scene_graph", SceneGraph())
    plant = builder.AddNamedSystem("plant", MultibodyPlant(step))
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    plant.set_discrete_contact_approximation(
        DiscreteContactApproximation.kLagged
    )
    plant.SetUseSampledOutputPorts(False)
    inertia = SpatialInertia.SolidCylinderWithMass(
        MASSES[0], SIZE, HEIGHT, [0, 0, 1]
    )
    robot = plant.AddRigidBody("robot", inertia)
    plant.AddJoint(
        PlanarJoint("slide", plant.world_frame(), robot.body_frame())
    )
    plant.RegisterCollisionGeometry(
        robot,
        RigidTransform([0, 0, HEIGHT / 2]),
        Cylinder(SIZE, HEIGHT),
        "shell",
        CoulombFriction(0.0, 0.0),
    )
    bodies = AddPeople(plant, [SIZE], np.array([[1.0, 0.0]]))
    plant.Finalize()
    for body in (robot, plant.get_body(bodies[0])):
        (shape,) = plant.GetCollisionGeometriesForBody(body)
        if stiffness:
            # (Two springs in series.)
            properties = ProximityProperties()
            AddContactMaterial(
                dissipation=0.0,
                point_stiffness=2 * stiffness,
                friction=CoulombFriction(0.0, 0.0),
                properties=properties,
            )
            scene_graph.AssignRole(
                plant.get_source_id(), shape, properties, RoleAssign.kReplace
            )
    builder.Connect(
        plant.get_geometry_pose_output_port(),
        scene_graph.get_source_pose_port(plant.get_source_id()),
    )
    builder.Connect(
        scene_graph.get_query_output_port(),
        plant.get_geometry_query_input_port(),
    )
    return builder, plant, robot, bodies


def bump(
    robot_speed,
    person_speed=0.0,
    *,
    step,
    offset=0.0,
    stiffness=None,
    held=False,
):
    """Lets a robot and a person meet, and records each step of the plant.

    Args:
        robot_speed: That of the robot along x, in m/s.
        person_speed: That of the person, towards it.
        step: The step of the plant, in seconds.
        offset: How far the person is beside the robot's way, in meters.
        stiffness: The stiffness of the contact in N/m; by default Drake's.
        held: Whether motors hold the person in its place.
    """
    builder, plant, robot, bodies = make_plant(step, stiffness=stiffness)
    people = plant.GetModelInstanceByName(PEOPLE)
    contacts = builder.AddSystem(
        PlantContacts(
            bodies, [SIZE], [robot.index()], time_step=step, plant_step=step
        )
    )
    robot_state = AddBodyState(builder, plant, robot, radius=SIZE)
    for output, taker in (
        (
            plant.get_contact_results_output_port(),
            contacts.get_contact_results_input_port(),
        ),
        (robot_state, contacts.get_robot_state_input_port()),
        (
            plant.get_state_output_port(people),
            contacts.get_people_state_input_port(),
        ),
    ):
        builder.Connect(output, taker)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    own = plant.GetMyMutableContextFromRoot(context)
    plant.get_body(bodies[0]).SetMass(own, MASSES[1])
    plant.SetPositions(own, people, [1.0, offset])
    plant.SetVelocities(own, people, [-person_speed, 0.0])
    plant.GetJointByName("slide").set_translational_velocity(
        own, [robot_speed, 0.0]
    )
    if held:
        desired = plant.get_desired_state_input_port(people)
        desired.FixValue(own, [1.0, offset, 0.0, 0.0])
    outputs = (
        robot_state,
        plant.get_state_output_port(people),
        contacts.get_contacts_output_port(),
    )
    rows = []
    times = np.arange(round(2.0 / step) + 1) * step
    for time in times:
        simulator.AdvanceTo(time)
        rows.append(
            [
                port.Eval(port.get_system().GetMyContextFromRoot(context))
                for port in outputs
            ]
        )
    robot_rows, states, sums = map(np.array, zip(*rows, strict=True))
    humans = np.array([people_states(state) for state in states])
    humans[..., RADIUS] = SIZE
    return Recording(
        times=times,
        robot=robot_rows,
        humans=humans,
        contacts=sums[:, None],
        contact_forces_known=True,
    )


def last_row(run):
    """Returns the contact with the person at the end."""
    return run.contacts[-1, 0]


@pytest.mark.parametrize("step", [0.01, 0.005, 0.002, 0.001])
def test_the_impulse_is_that_of_a_plastic_push(step):
    run = bump(0.5, step=step)
    expected = REDUCED * 0.5
    print(
        f"J = {last_row(run)[Contact.IMPULSE]:.2f} N s, mu v = {expected:.2f}"
    )
    assert last_row(run)[Contact.IMPULSE] == pytest.approx(expected, rel=0.05)
    assert last_row(run)[Contact.RELATIVE_SPEED] == pytest.approx(0.5)


def test_a_person_who_is_held_is_pushed_harder():
    free, held = (
        last_row(bump(0.5, step=0.005, held=held))[Contact.IMPULSE]
        for held in (False, True)
    )
    print(f"{held:.1f} N s if held, {free:.1f} N s if free")
    # The robot bounces off, and does not only stop.
    assert MASSES[0] * 0.5 < held < 2 * MASSES[0] * 0.5
    assert free == pytest.approx(REDUCED * 0.5, rel=0.05)


def test_the_impulse_is_what_the_person_has_got():
    run = bump(0.5, step=0.005)
    speeds = run.humans[-1, 0, 3:5]
    np.testing.assert_allclose(
        last_row(run)[Contact.IMPULSE], MASSES[1] * np.hypot(*speeds), rtol=1e-6
    )
    lost = MASSES[0] * (0.5 - run.robot[-1, 3])
    np.testing.assert_allclose(last_row(run)[Contact.IMPULSE], lost, rtol=1e-6)


@pytest.mark.parametrize("step", [0.01, 0.005])
def test_only_the_speed_along_the_normal_counts(step):
    run = bump(0.5, step=step, offset=0.3)
    # The line between them is turned by asin(0.3 / 0.6).
    speed = 0.5 * math.cos(math.radians(30))
    found = last_row(run)[Contact.RELATIVE_SPEED]
    print(f"v_n = {found:.4f} of {speed:.4f} m/s")
    assert found == pytest.approx(0.433, abs=5e-3)
    expected = REDUCED * speed
    assert last_row(run)[Contact.IMPULSE] == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("step", [0.01, 0.002])
def test_the_share_of_the_fault_is_that_of_the_speed(step):
    run = bump(0.5, 1.0, step=step)
    assert last_row(run)[Contact.BY_PERSON] == 1
    assert last_row(run)[Contact.BY_ROBOT] == 0
    assert last_row(run)[Contact.RELATIVE_SPEED] == pytest.approx(1.5)
    found = find_encounters(run).events()
    touch = found[(found["kind"] == "entry") & (found["zone"] == "touch")]
    assert touch["fault"].tolist() == ["person"]
    assert touch["share"].tolist() == pytest.approx([1 / 3])
    # They meet in the middle of what is left between them.
    assert touch["time"].tolist() == pytest.approx([0.4 / 1.5])


@pytest.mark.parametrize("step", [0.002, 0.0005])
def test_the_peak_is_that_of_a_spring(step):
    run = bump(0.5, step=step, stiffness=STIFFNESS)
    expected = 0.5 * math.sqrt(STIFFNESS * REDUCED)
    print(f"{last_row(run)[Contact.PEAK_FORCE]:.0f} N of {expected:.0f} N")
    assert last_row(run)[Contact.PEAK_FORCE] == pytest.approx(
        expected, rel=0.05
    )
    # Elastic: twice the impulse of a plastic push, in half a period.
    assert last_row(run)[Contact.IMPULSE] == pytest.approx(
        2 * REDUCED * 0.5, rel=0.05
    )
    forces = run.contacts[:, 0, Contact.FORCE_X]
    lasts = np.count_nonzero(forces) * step
    assert lasts == pytest.approx(
        math.pi * math.sqrt(REDUCED / STIFFNESS), rel=0.05
    )
