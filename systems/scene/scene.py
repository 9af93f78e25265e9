"""Builds the scene: world, people and robot."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
import math
import re
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Rgba, SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Joint
from pydrake.systems.framework import (
    Diagram,
    DiagramBuilder,
    InputPort,
    OutputPort,
)
from pydrake.systems.rendering import MultibodyPositionToGeometryPose

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import check_time_step
from hunav_drake.systems.people.figure_config import Figures, Held, figure_rows
from hunav_drake.systems.people.gait import FIGURE_SIZE
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.names import people_ids, people_names
from hunav_drake.systems.robot.robot_config import RobotConfig
from hunav_drake.systems.scene.bounds import (
    Robots,
    by_name,
    figure_of,
    scene_bounds,
)
from hunav_drake.systems.scene.human_body import AddHumanBody
from hunav_drake.systems.scene.labels import human_label
from hunav_drake.systems.scene.palette import HAIR_STYLES, accent, clothes
from hunav_drake.systems.scene.robot_body import AddRobotBody
from hunav_drake.systems.scene.scene_config import Rays, SceneConfig
from hunav_drake.systems.scene.scene_kinematics import SceneKinematics
from hunav_drake.systems.scene.surroundings import (
    AddFloor,
    AddGoalMarks,
    AddWorld,
)
from hunav_drake.systems.world.shapes import World

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat

    from hunav_drake.systems.scene.overlays.viewer import MeshcatViewer

# The margin of the floor beyond everything on it, in meters.
FLOOR_MARGIN = 0.6

# The approximate time between displayed or recorded frames, in seconds.
FRAME_PERIOD = 0.1


# What people hold by default, by their behaviors.
_HOLDS: dict[str, Held] = {"distracted": "telephone"}


@dataclass(frozen=True)
class ScenePorts:
    """The ports and parts of a scene from `AddScene`.

    Attributes:
        system: The scene, which has additional inputs with Meshcat.
        human_states: The input for the states of the people, size 7n.
        robot_state: The input for the state of the robot, size 7; None without
            a robot, or with several.
        query_object: The output of the scene's QueryObject, for cameras and
            sensors.
        scene_graph: The SceneGraph, to add renderers to.
        plant: The plant of the drawn bodies. It is not part of the diagram and
            has no mass: it only holds frames and geometry.
        human_names: The model instance of each person in the plant.
        visualizer: The system that records, and that publishes to Meshcat; None
            without Meshcat.
    """

    system: Diagram
    human_states: InputPort
    robot_state: InputPort | None
    query_object: OutputPort
    scene_graph: SceneGraph
    plant: MultibodyPlant
    human_names: tuple[str, ...]
    visualizer: "MeshcatViewer | None"


@dataclass(frozen=True, kw_only=True)
class SceneInputs:
    """What a scene shows, and by which further inputs.

    Attributes:
        scan_angles: The rays of a lidar, or their angles relative to the
            robot's heading, in radians; with Meshcat, an input "scan" takes
            their distances. Of several robots, such ones by their names.
        sayings: If people show each other what they do, for each person the
            texts that it may say, by their `text_code`; there may be none. An
            input "social_signals" takes n rows of `layout.Signal`: figures sit,
            look aside and gesture, and bubbles tell what they say.
        drawn: Whether there is geometry. Where nobody looks, a scene without it
            is made faster, and has the same state.
    """

    scan_angles: Rays | Array | Mapping[str, Rays | Array] | None = None
    sayings: Sequence[Mapping[float, str]] | None = None
    drawn: bool = True


def AddScene(
    builder: DiagramBuilder,
    world: World,
    humans: Sequence[HumanConfig] = (),
    robot: Robots = None,
    *,
    time_step: float = 0.05,
    meshcat: "Meshcat | None" = None,
    config: SceneConfig | None = None,
    inputs: SceneInputs | None = None,
) -> ScenePorts:
    """Adds the scene to a builder as one diagram named "scene".

    .. pydrake_system::

        name: scene
        input_ports:
        - human_states
        - robot_state (of several robots, NAME_robot_state for each)
        - social_signals (only with `SceneInputs.sayings`)
        output_ports:
        - query

    It contains the systems "kinematics" (SceneKinematics), "geometry_poses",
    "scene_graph", and with Meshcat "meshcat_visualizer" (MeshcatViewer) and
    "overlays" (OverlayPublisher). The inputs of "overlays" become inputs of the
    scene; connect those that should be drawn. The geometry belongs to the model
    instances "robot", or the names of several robots, and one per person: the
    person's name, with "_" for
    characters other than letters and digits, and a number if that is taken.
    Without Meshcat nothing is published, and a step only updates the gait.

    Args:
        builder: The builder to add the scene to.
        world: The walls.
        humans: The people, in the order of `human_states`.
        robot: The robot; several ones by their names; None without a robot.
        time_step: The period of the states, in seconds.
        meshcat: The Meshcat to show the scene in.
        config: The additional drawings.
        inputs: What else the scene shows, by further inputs.

    Raises:
        ValueError: If the builder has a system named "scene" already, or the
            time step is not positive.
    """
    if builder.HasSubsystemNamed("scene"):
        raise ValueError(
            'AddScene: the builder has a system named "scene" already; a'
            " diagram holds one scene."
        )
    check_time_step(time_step)
    inputs = inputs or SceneInputs()
    inner = DiagramBuilder()
    scene_graph = inner.AddNamedSystem("scene_graph", SceneGraph())
    plant = MultibodyPlant(time_step=0.0)
    if inputs.drawn:
        plant.RegisterAsSourceForSceneGraph(scene_graph)
        bounds = scene_bounds(world, humans, robot, margin=FLOOR_MARGIN)
        AddFloor(plant, bounds, world)
        AddWorld(plant, world)
        AddGoalMarks(plant, humans, robot)
    robots = by_name(robot)
    human_names = figure_names(humans, robots)
    joints = AddPeople(
        plant,
        humans,
        [human_label(i) for i in range(len(humans))],
        apart=True,
        names=human_names,
        lively=inputs.sayings is not None,
    )
    robot_joints = {
        name: _AddRobot(plant, figure_of(name), it, accent(k))
        for k, (name, it) in enumerate(robots.items())
    }
    if not inputs.drawn:
        # Only now: before, its bodies would get geometry.
        plant.RegisterAsSourceForSceneGraph(scene_graph)
    plant.Finalize()

    kinematics, poses = AddKinematics(
        inner, plant, humans, joints, robot_joints, time_step
    )
    inner.Connect(
        poses, scene_graph.get_source_pose_port(plant.get_source_id())
    )
    for port in kinematics.get_robot_state_input_ports():
        inner.ExportInput(port, port.get_name())
    visualizer = None
    if meshcat is not None:
        period = frame_period(time_step)
        from hunav_drake.systems.scene.overlays.board import Board
        from hunav_drake.systems.scene.overlays.publisher import (
            AddOverlayPublisher,
        )
        from hunav_drake.systems.scene.overlays.viewer import MeshcatViewer

        visualizer = inner.AddNamedSystem(
            "meshcat_visualizer",
            MeshcatViewer(plant, scene_graph, meshcat, period=period),
        )
        inner.Connect(
            kinematics.get_positions_output_port(),
            visualizer.get_positions_input_port(),
        )
        AddOverlayPublisher(
            inner,
            Board(meshcat, world, humans, human_names, robots, inputs.sayings),
            (config or SceneConfig()).overlays,
            period=period,
            is_due=visualizer.is_due,
            is_recording=visualizer.is_recording,
            rays=_rays_by_name(inputs.scan_angles),
        )
    inner.ExportOutput(scene_graph.get_query_output_port(), "query")

    scene = builder.AddNamedSystem("scene", inner.Build())
    return ScenePorts(
        system=scene,
        human_states=scene.GetInputPort("human_states"),
        robot_state=scene.GetInputPort("robot_state")
        if scene.HasInputPort("robot_state")
        else None,
        query_object=scene.GetOutputPort("query"),
        scene_graph=scene_graph,
        plant=plant,
        human_names=human_names,
        visualizer=visualizer,
    )


def _rays_by_name(
    rays: Rays | Array | Mapping[str, Rays | Array] | None,
) -> dict[str, Rays]:
    named = rays if isinstance(rays, Mapping) else {"": rays}
    return {
        name: it if isinstance(it, Rays) else Rays(np.asarray(it))
        for name, it in named.items()
        if it is not None
    }


def AddPeople(
    plant: MultibodyPlant,
    humans: Sequence[HumanConfig],
    labels: Sequence[int],
    *,
    apart: bool = False,
    names: Sequence[str] | None = None,
    lively: bool = False,
) -> list[list[Joint]]:
    """Adds the figures of people to a plant; returns the joints of each.

    `labels` are those in label images; `apart` is whether discs differ in
    height, and `lively` as for `AddHumanBody`; `names` are by default the
    `figure_names`.
    """
    return [
        AddHumanBody(
            plant,
            name,
            radius=human.radius,
            clothes=clothes(i, human.figure),
            figure=replace(
                human.figure,
                hair=human.figure.hair or HAIR_STYLES[i % len(HAIR_STYLES)],
                holds=human.figure.holds or _HOLDS.get(human.behavior_name),
            ),
            label=labels[i],
            level=i if apart else 0,
            lively=lively,
        )
        for i, (name, human) in enumerate(
            zip(names or figure_names(humans), humans, strict=True)
        )
    ]


def AddKinematics(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    humans: Sequence[HumanConfig],
    joints: Sequence[Sequence[Joint]],
    robot_joints: Mapping[str, Sequence[Joint]],
    time_step: float,
) -> tuple[SceneKinematics, OutputPort]:
    """Adds what poses the figures of a plant; exports "human_states".

    Returns the kinematics, and the port with the poses of the geometry.
    """
    rows = [joint_positions(it) for it in joints]
    kinematics = builder.AddNamedSystem(
        "kinematics",
        SceneKinematics(
            np.array(rows) if rows else np.zeros((0, FIGURE_SIZE)),
            {name: joint_positions(j) for name, j in robot_joints.items()},
            num_positions=plant.num_positions(),
            default_positions=plant.GetDefaultPositions(),
            time_step=time_step,
            figures=Figures(
                figure_rows([it.figure for it in humans]),
                ids=people_ids(humans),
            ),
        ),
    )
    poses = builder.AddNamedSystem(
        "geometry_poses", MultibodyPositionToGeometryPose(plant)
    )
    builder.Connect(
        kinematics.get_positions_output_port(), poses.get_input_port()
    )
    builder.ExportInput(
        kinematics.get_human_states_input_port(), "human_states"
    )
    if kinematics.HasInputPort("social_signals"):
        builder.ExportInput(
            kinematics.GetInputPort("social_signals"), "social_signals"
        )
    return kinematics, poses.get_output_port()


def _AddRobot(
    plant: MultibodyPlant, name: str, robot: RobotConfig, color: Rgba
) -> Sequence[Joint]:
    """Adds the figure of a robot; returns the joints of x, y and yaw."""
    own: Sequence[Joint] | None = robot.AddFigure(plant, name)
    if own is not None:
        return own
    return [AddRobotBody(plant, name, radius=robot.radius, accent=color)]


def frame_period(time_step: float) -> float:
    """Returns the time between frames, a power of two of time steps, in s.

    It is the one nearest to `FRAME_PERIOD`.

    Drake computes the k-th time of an event as k times its period. Only for
    powers of two are these exactly times of steps, too; an ulp apart, the frame
    would show the state of the next step.
    """
    doublings = round(math.log2(FRAME_PERIOD / time_step))
    return time_step * 2.0 ** max(doublings, 0)


def joint_positions(joints: Sequence[Joint]) -> NDArray[np.int64]:
    """Returns the indices of some joints' positions in those of a plant."""
    return np.concatenate(
        [j.position_start() + np.arange(j.num_positions()) for j in joints]
    )


def figure_names(
    humans: Sequence[HumanConfig], robots: Iterable[str] = ()
) -> tuple[str, ...]:
    """Returns a valid and unique name for the figure of each person.

    `robots` are the names of several robots.
    """
    taken = {"robot", "WorldModelInstance", "DefaultModelInstance", *robots}
    names = []
    for i, human_name in enumerate(people_names(humans)):
        plain = re.sub(r"\W+", "_", human_name, flags=re.ASCII).strip("_")
        stem = plain or f"human_{i + 1}"
        name, number = stem, 2
        while name in taken:
            name, number = f"{stem}_{number}", number + 1
        taken.add(name)
        names.append(name)
    return tuple(names)
