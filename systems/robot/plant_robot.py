"""A robot in a MultibodyPlant with people that it collides with."""

import itertools
import math
from typing import NamedTuple

import numpy as np
from pydrake.geometry import (
    Capsule,
    CollisionFilterDeclaration,
    Cylinder,
    GeometrySet,
    SceneGraph,
    Sphere,
)
from pydrake.multibody.plant import (
    ContactModel,
    DiscreteContactApproximation,
    MultibodyPlant,
)
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import Diagram, DiagramBuilder

from hunav_drake.systems.robot.body_state import BodyState
from hunav_drake.systems.robot.driven_model import (
    AddDrivenModel,
    DrivenModel,
    make_motor_speeds,
)
from hunav_drake.systems.robot.drives import DriveConfig, PlanarBase
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


def AddPlantRobot(
    builder: DiagramBuilder,
    config: RobotConfig,
    body: Body,
    task: RobotTask,
    name: str,
) -> Diagram:
    """Adds a robot, people and walls as bodies of a plant.

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

    The builder gets the systems "plant" and "scene_graph", and the robot, a
    diagram of "driver" (`RobotDriver`), "state" (`BodyState`), "people"
    (`PeopleDriver`) and "contacts" (`PlantContacts`). All ports are connected
    except ``velocity_command`` and ``human_states``. Without people, there are
    no ports for them.

    Args:
        builder: A DiagramBuilder.
        config: The robot.
        body: The simulated body.
        task: The data of the world and the people.
        name: The name of the robot's system.

    Returns:
        The system of the robot.

    Raises:
        ModelFault: If the model cannot be driven.
        ValueError: If there is a system "plant" or "scene_graph" already.
    """
    for taken in ("plant", "scene_graph", name):
        if builder.HasSubsystemNamed(taken):
            raise ValueError(
                f"the diagram has a system named {taken!r} already, and the"
                f" robot {type(config).__name__} needs this name"
            )
    step = plant_step(task.time_step, body.max_step)
    scene_graph = builder.AddNamedSystem("scene_graph", SceneGraph())
    plant = builder.AddNamedSystem("plant", MultibodyPlant(step))
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    plant.set_discrete_contact_approximation(
        DiscreteContactApproximation.kLagged
    )
    plant.set_contact_model(ContactModel.kPoint)
    # So that its outputs are functions of the Context alone.
    plant.SetUseSampledOutputPorts(False)
    drive = body.drive
    model = AddDrivenModel(plant, body.model, drive, config.start)
    AddFloorAndWalls(plant, task.obstacles, config.start[:2])
    people = AddPeople(plant, task.humans, task.starts) if task.humans else ()
    _FilterCollisions(plant, scene_graph, model.instance)
    plant.Finalize()

    inner = DiagramBuilder()
    driver = inner.AddNamedSystem(
        "driver",
        RobotDriver(
            config.limits,
            *make_motor_speeds(plant, model, drive),
            period=step,
            needs_heading=isinstance(drive, PlanarBase),
        ),
    )
    state = inner.AddNamedSystem(
        "state", BodyState(model.base.index(), config.radius)
    )
    contacts = inner.AddNamedSystem(
        "contacts",
        PlantContacts(
            people,
            task.humans,
            time_step=task.time_step,
            plant_step=step,
            reach=_reach(plant, scene_graph, model),
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
    if people:
        people_driver = inner.AddNamedSystem(
            "people",
            PeopleDriver(
                len(people), time_step=task.time_step, plant_step=step
            ),
        )
        inputs += [
            people_driver.get_human_states_input_port(),
            contacts.get_contact_results_input_port(),
            contacts.get_people_state_input_port(),
        ]
        inner.ExportOutput(
            people_driver.get_desired_state_output_port(),
            "desired_people_state",
        )
    for port in inputs:
        inner.ExportInput(port, port.get_name())
    for port in outputs:
        inner.ExportOutput(port, port.get_name())
    robot = builder.AddNamedSystem(name, inner.Build())
    _Connect(builder, plant, scene_graph, robot, model)
    return robot


def _Connect(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    robot: Diagram,
    model: DrivenModel,
) -> None:
    pairs = [
        (
            plant.get_geometry_pose_output_port(),
            scene_graph.get_source_pose_port(plant.get_source_id()),
        ),
        (
            scene_graph.get_query_output_port(),
            plant.get_geometry_query_input_port(),
        ),
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
    if plant.HasModelInstanceNamed(PEOPLE):
        people = plant.GetModelInstanceByName(PEOPLE)
        pairs += [
            (
                robot.GetOutputPort("desired_people_state"),
                plant.get_desired_state_input_port(people),
            ),
            (
                plant.get_contact_results_output_port(),
                robot.GetInputPort("contact_results"),
            ),
            (
                plant.get_state_output_port(people),
                robot.GetInputPort("people_state"),
            ),
        ]
    for output, taker in pairs:
        builder.Connect(output, taker)


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
    joints = map(plant.get_joint, plant.GetJointIndices(model.instance))
    moving = {j.index() for j in joints if j.num_velocities() in range(1, 6)}
    if moving - {joint.index() for joint in model.motors}:
        return math.inf
    inspector = scene_graph.model_inspector()
    context = plant.CreateDefaultContext()
    base = model.base.body_frame()
    reach = 0.0
    for index in plant.GetBodyIndices(model.instance):
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


def _FilterCollisions(
    plant: MultibodyPlant, scene_graph: SceneGraph, robot: ModelInstanceIndex
) -> None:
    """Keeps only the contacts of the robot with everything else."""

    def shapes(instance: ModelInstanceIndex) -> GeometrySet:
        bodies = map(plant.get_body, plant.GetBodyIndices(instance))
        return GeometrySet(
            [
                shape
                for body in bodies
                for shape in plant.GetCollisionGeometriesForBody(body)
            ]
        )

    without = CollisionFilterDeclaration()
    without.ExcludeWithin(shapes(robot))
    if plant.HasModelInstanceNamed(PEOPLE):
        people = shapes(plant.GetModelInstanceByName(PEOPLE))
        world = GeometrySet(
            plant.GetCollisionGeometriesForBody(plant.world_body())
        )
        without.ExcludeWithin(people)
        without.ExcludeBetween(people, world)
    scene_graph.collision_filter_manager().Apply(without)
