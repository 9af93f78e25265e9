"""A robot in a MultibodyPlant with people that it collides with."""

from collections.abc import Iterable, Sequence
import itertools
import math
from typing import NamedTuple

import numpy as np
from pydrake.geometry import (
    Capsule,
    CollisionFilterDeclaration,
    Cylinder,
    Ellipsoid,
    GeometryId,
    GeometrySet,
    ProximityProperties,
    RoleAssign,
    SceneGraph,
    Sphere,
)
from pydrake.multibody.plant import (
    ContactModel,
    CoulombFriction,
    DiscreteContactApproximation,
    MultibodyPlant,
)
from pydrake.multibody.tree import BodyIndex, RevoluteJoint
from pydrake.systems.framework import (
    Diagram,
    DiagramBuilder,
    InputPort,
    OutputPort,
)

from hunav_drake.systems.robot.body_state import BodyState
from hunav_drake.systems.robot.driven_model import (
    AddDrivenModel,
    DrivenModel,
    make_motor_states,
)
from hunav_drake.systems.robot.drives import (
    DifferentialWheels,
    DriveConfig,
    MecanumWheels,
    PlanarBase,
)
from hunav_drake.systems.robot.plant_contacts import PlantContacts
from hunav_drake.systems.robot.plant_model import ModelSource
from hunav_drake.systems.robot.plant_people import (
    PEOPLE,
    AddPeople,
    PeopleDriver,
)
from hunav_drake.systems.robot.plant_walls import AddFloorAndWalls
from hunav_drake.systems.robot.robot_config import RobotConfig, RobotTask
from hunav_drake.systems.robot.robot_driver import RobotDriver

# The friction that Drake's parser takes where a file gives none, and that of a
# caster that slides.
_UNSTATED, _SLIDING = 1.0, CoulombFriction(0.1, 0.1)

# How far above the floor a support may be, in meters.
_SUPPORT = 0.02

# How fast a skid steer corrects its velocity, in 1/s.
_GAIN = 5.0

# The number of corners of the prism that replaces a cylinder.
_CORNERS = 64


class Body(NamedTuple):
    """The simulated body of a robot.

    Attributes:
        model: The source of the model.
        drive: The drive of the robot.
        max_step: The maximum step of the plant, in seconds.
    """

    model: ModelSource
    drive: DriveConfig
    max_step: float


def plant_step(time_step: float, longest: float) -> float:
    """Returns the time between two steps of a plant, in seconds.

    It is the time step of the trial, or a half, a quarter ... of it, up to
    `longest`: only then do the steps of both coincide to the last bit.
    """
    step = time_step
    while step > longest * (1 + 1e-9):
        step /= 2
    return step


def AddPlantRobots(
    builder: DiagramBuilder,
    robots: Sequence[tuple[str, RobotConfig, Body]],
    task: RobotTask,
) -> list[Diagram]:
    """Adds robots, people and walls as bodies of a plant.

    .. pydrake_system::

        name: robot
        input_ports:
        - velocity_command
        - human_states
        - body_poses
        - body_spatial_velocities
        - contact_results
        - people_state
        output_ports:
        - robot_state
        - contacts
        - desired_state
        - desired_people_state

    The builder gets the systems "plant" and "scene_graph", and each robot, a
    diagram of "driver" (`RobotDriver`), "state" (`BodyState`) and "contacts"
    (`PlantContacts`). The first one has "people" (`PeopleDriver`), too, and the
    ports ``human_states`` and ``desired_people_state``: it moves the bodies of
    people, and those of kinematic robots, whose states are the last rows. All
    ports are connected except ``velocity_command`` and ``human_states``.
    Without such bodies, there are no ports for them.

    Args:
        builder: A DiagramBuilder.
        robots: The name of each robot's system, the robot, and its body.
        task: The data of the world, the people, and the kinematic robots.

    Returns:
        The systems of the robots, in order.

    Raises:
        ModelFault: If a model cannot be driven.
        ValueError: If there is a system "plant" or "scene_graph" already.
    """
    for taken in ("plant", "scene_graph", *(name for name, _, _ in robots)):
        if builder.HasSubsystemNamed(taken):
            raise ValueError(
                f"the diagram has a system named {taken!r} already, and the"
                f" robot {type(robots[0][1]).__name__} needs this name"
            )
    step = plant_step(task.time_step, min(body.max_step for *_, body in robots))
    scene_graph = builder.AddNamedSystem("scene_graph", SceneGraph())
    plant = builder.AddNamedSystem("plant", MultibodyPlant(step))
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    plant.set_discrete_contact_approximation(
        DiscreteContactApproximation.kLagged
    )
    plant.set_contact_model(ContactModel.kPoint)
    # So that its outputs are functions of the Context alone.
    plant.SetUseSampledOutputPorts(False)
    models = []
    for name, config, body in robots:
        models.append(
            AddDrivenModel(plant, body.model, body.drive, config.start)
        )
        if len(robots) > 1:
            plant.RenameModelInstance(models[-1].instance, name)
    floor = AddFloorAndWalls(plant, task.obstacles, robots[0][1].start[:2])
    people = _People(plant, task)
    plant.Finalize()
    for model in models:
        _MendShapes(plant, scene_graph, model)
    _FilterCollisions(plant, scene_graph, models, floor)
    pairs = [
        (
            plant.get_geometry_pose_output_port(),
            scene_graph.get_source_pose_port(plant.get_source_id()),
        ),
        (
            scene_graph.get_query_output_port(),
            plant.get_geometry_query_input_port(),
        ),
    ]
    added: list[Diagram] = []
    for (name, config, body), model in zip(robots, models, strict=True):
        inner = _MakeRobot(
            *(plant, scene_graph, model, config, body, task, people),
            moves_people=bool(people.bodies) and not added,
        )
        added.append(builder.AddNamedSystem(name, inner))
        pairs += _pairs(plant, added[-1], model)
    for output, taker in pairs:
        builder.Connect(output, taker)
    return added


class _People:
    """The bodies of people, then those of kinematic robots."""

    def __init__(self, plant: MultibodyPlant, task: RobotTask) -> None:
        self.num_people = len(task.humans)
        self.radii = [human.contact_radius for human in task.humans]
        self.radii += [robot.radius for robot in task.robots]
        starts = np.array([robot.start[:2] for robot in task.robots])
        starts = np.vstack([task.starts, starts.reshape(-1, 2)])
        self.bodies = AddPeople(plant, self.radii, starts) if self.radii else ()


def _MakeRobot(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    model: DrivenModel,
    config: RobotConfig,
    body: Body,
    task: RobotTask,
    people: _People,
    *,
    moves_people: bool,
) -> Diagram:
    """Makes the systems of a robot in a finalized plant."""
    step = plant.time_step()
    skids = isinstance(body.drive, DifferentialWheels) and body.drive.skids
    inner = DiagramBuilder()
    driver = inner.AddNamedSystem(
        "driver",
        RobotDriver(
            config.limits,
            make_motor_states(plant, model, body.drive),
            period=step,
            needs_heading=isinstance(body.drive, MecanumWheels | PlanarBase),
            gain=_GAIN if skids else 0.0,
        ),
    )
    state = inner.AddNamedSystem(
        "state", BodyState(model.base.index(), config.radius)
    )
    contacts = inner.AddNamedSystem(
        "contacts",
        PlantContacts(
            people.bodies[: people.num_people],
            people.radii[: people.num_people],
            model.bodies,
            time_step=task.time_step,
            plant_step=step,
            reach=_reach(plant, scene_graph, model),
            num_bodies=len(people.bodies),
        ),
    )
    robot_state = state.get_robot_state_output_port()
    if heading := driver.get_robot_state_input_port():
        inner.Connect(robot_state, heading)
    inner.Connect(robot_state, contacts.get_robot_state_input_port())
    inputs = [
        driver.get_velocity_command_input_port(),
        state.get_body_poses_input_port(),
        state.get_body_spatial_velocities_input_port(),
    ]
    outputs = [robot_state, contacts.get_contacts_output_port()]
    inner.ExportOutput(driver.get_desired_state_output_port(), "desired_state")
    if moves_people:
        people_driver = inner.AddNamedSystem(
            "people",
            PeopleDriver(
                len(people.bodies), time_step=task.time_step, plant_step=step
            ),
        )
        inputs.append(people_driver.get_human_states_input_port())
        inner.ExportOutput(
            people_driver.get_desired_state_output_port(),
            "desired_people_state",
        )
    if people.bodies:
        inputs += [
            contacts.get_contact_results_input_port(),
            contacts.get_people_state_input_port(),
        ]
    for port in inputs:
        inner.ExportInput(port, port.get_name())
    for port in outputs:
        inner.ExportOutput(port, port.get_name())
    return inner.Build()


def _pairs(
    plant: MultibodyPlant, robot: Diagram, model: DrivenModel
) -> list[tuple[OutputPort, InputPort]]:
    """Returns the ports of a robot and its plant that are to be connected."""
    pairs = [
        (
            robot.GetOutputPort("desired_state"),
            plant.get_desired_state_input_port(model.instance),
        ),
        (plant.get_body_poses_output_port(), robot.GetInputPort("body_poses")),
        (
            plant.get_body_spatial_velocities_output_port(),
            robot.GetInputPort("body_spatial_velocities"),
        ),
    ]
    if not plant.HasModelInstanceNamed(PEOPLE):
        return pairs
    people = plant.GetModelInstanceByName(PEOPLE)
    pairs += [
        (
            plant.get_contact_results_output_port(),
            robot.GetInputPort("contact_results"),
        ),
        (
            plant.get_state_output_port(people),
            robot.GetInputPort("people_state"),
        ),
    ]
    if robot.HasOutputPort("desired_people_state"):
        desired = plant.get_desired_state_input_port(people)
        pairs.append((robot.GetOutputPort("desired_people_state"), desired))
    return pairs


def body_reach(
    source: ModelSource,
    drive: DriveConfig,
    start: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> float:
    """Returns the reach of a robot's shapes from its base, in meters.

    It is an upper bound in the plane: spheres and capsules count with their
    radius, cylinders with prisms and others with boxes around them. It is
    infinite if it may change in a trial, as with an arm. `start` is the pose
    (x, y, yaw) in W.

    Raises:
        ModelFault: If the model cannot be driven.
    """
    scene_graph = SceneGraph()
    plant = MultibodyPlant(0.01)
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    model = AddDrivenModel(plant, source, drive, start)
    plant.Finalize()
    return _reach(plant, scene_graph, model)


def _reach(
    plant: MultibodyPlant, scene_graph: SceneGraph, model: DrivenModel
) -> float:
    """Returns the reach of a robot in a plant: see `body_reach`."""
    moving = {j.index() for j in model.joints if j.num_velocities()}
    if moving - {joint.index() for joint in model.motors}:
        return math.inf
    inspector = scene_graph.model_inspector()
    context = plant.CreateDefaultContext()
    base = model.base.body_frame()
    reach = 0.0
    for index in model.bodies:
        body = plant.get_body(index)
        X_BL = plant.CalcRelativeTransform(context, base, body.body_frame())
        for geometry in plant.GetCollisionGeometriesForBody(body):
            X_BG = X_BL @ inspector.GetPoseInFrame(geometry)
            shape = inspector.GetShape(geometry)
            radius = 0.0
            if isinstance(shape, Sphere | Capsule):
                radius = shape.radius()
                half = 0.0 if isinstance(shape, Sphere) else shape.length() / 2
                points = np.array([[0, 0, -half], [0, 0, half]])
            elif isinstance(shape, Cylinder):
                angles = np.arange(0, 2 * math.pi, 2 * math.pi / _CORNERS)
                ring = shape.radius() / math.cos(math.pi / _CORNERS)
                points = np.array(
                    [
                        [ring * math.cos(a), ring * math.sin(a), z]
                        for a, z in itertools.product(
                            angles, (-shape.length() / 2, shape.length() / 2)
                        )
                    ]
                )
            else:
                box = inspector.GetObbInGeometryFrame(geometry)
                if box is None:
                    return math.inf
                corners = list(itertools.product([-1, 1], repeat=3))
                points = (box.pose() @ (corners * box.half_width()).T).T
            x, y, _ = X_BG @ points.T
            reach = max(reach, radius + float(np.hypot(x, y).max()))
    return reach


def _MendShapes(
    plant: MultibodyPlant, scene_graph: SceneGraph, model: DrivenModel
) -> None:
    """Makes wheels roll, and supports slide, as they do on real floors.

    Cylinders that roll become ellipsoids: the one point at which Drake lets a
    cylinder touch the floor is at one of its ends, and that of a wheel is in
    its middle. What is fixed to a base on wheels, and reaches down to the
    floor, gets a low friction, unless the file gives one: in files of robots it
    is a caster's stand-in.
    """
    source = plant.get_source_id()
    inspector = scene_graph.model_inspector()
    context = plant.CreateDefaultContext()
    for joint in model.joints:
        if not isinstance(joint, RevoluteJoint):
            continue
        wheel = joint.child_body()
        R_BW, R_BC = (
            plant.CalcRelativeRotationMatrix(
                context, model.base.body_frame(), frame
            )
            for frame in (joint.frame_on_parent(), wheel.body_frame())
        )
        axis = R_BW.multiply(joint.revolute_axis())
        for geometry in plant.GetCollisionGeometriesForBody(wheel):
            shape = inspector.GetShape(geometry)
            along = R_BC.multiply(
                inspector.GetPoseInFrame(geometry).rotation().matrix()[:, 2]
            )
            flat = abs(axis[2]) < 0.1 and abs((axis * along).sum()) > 0.99
            if isinstance(shape, Cylinder) and flat:
                r, half = shape.radius(), shape.length() / 2
                scene_graph.ChangeShape(source, geometry, Ellipsoid(r, r, half))
    for body in plant.GetBodiesWeldedTo(model.base) if model.wheels else ():
        for geometry in plant.GetCollisionGeometriesForBody(body):
            box = inspector.GetObbInGeometryFrame(geometry)
            if box is None:
                continue
            X_WL = plant.EvalBodyPoseInWorld(context, body)
            X_WO = X_WL @ inspector.GetPoseInFrame(geometry) @ box.pose()
            up = np.abs(X_WO.rotation().matrix()[2])
            lowest = X_WO.translation()[2] - (up * box.half_width()).sum()
            if lowest > _SUPPORT:
                continue
            properties = inspector.GetProximityProperties(geometry)
            found = properties.GetProperty("material", "coulomb_friction")
            if found.static_friction() == _UNSTATED:
                properties = ProximityProperties(properties)
                properties.UpdateProperty(
                    "material", "coulomb_friction", _SLIDING
                )
                scene_graph.AssignRole(
                    source, geometry, properties, RoleAssign.kReplace
                )


def _FilterCollisions(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    robots: Sequence[DrivenModel],
    floor: GeometryId,
) -> None:
    """Keeps only the contacts of each robot with everything else."""
    world = GeometrySet(plant.GetCollisionGeometriesForBody(plant.world_body()))

    def shapes(bodies: Iterable[BodyIndex]) -> GeometrySet:
        return GeometrySet(
            [
                shape
                for body in map(plant.get_body, bodies)
                for shape in plant.GetCollisionGeometriesForBody(body)
            ]
        )

    without = CollisionFilterDeclaration()
    for robot in robots:
        without.ExcludeWithin(shapes(robot.bodies))
        if robot.floats:
            without.ExcludeBetween(shapes(robot.bodies), GeometrySet([floor]))
    if plant.HasModelInstanceNamed(PEOPLE):
        instance = plant.GetModelInstanceByName(PEOPLE)
        people = shapes(plant.GetBodyIndices(instance))
        without.ExcludeWithin(people)
        without.ExcludeBetween(people, world)
    scene_graph.collision_filter_manager().Apply(without)
