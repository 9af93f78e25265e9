"""Adds the figures of people to a user's SceneGraph."""

from collections.abc import Sequence
from typing import NamedTuple

from pydrake.geometry import Role, SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, InputPort

from hunav_drake.systems.common.checks import check_kind
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.scene.labels import human_label, labels_taken
from hunav_drake.systems.scene.scene import AddKinematics, AddPeople


class FigurePorts(NamedTuple):
    """The ports of `AddFigures` to connect.

    Attributes:
        human_states: Takes n rows (x, y, yaw, vx, vy, omega, radius).
        labels: The label of each person in label images.
        social_signals: Takes n rows of `layout.Signal`, for lively figures.
    """

    human_states: InputPort
    labels: tuple[int, ...]
    social_signals: InputPort | None = None


def AddFigures(
    builder: DiagramBuilder,
    scene_graph: SceneGraph,
    humans: Sequence[HumanConfig],
    *,
    time_step: float = 0.05,
    name: str = "figures",
    lively: bool = False,
) -> FigurePorts:
    """Adds walking figures to a SceneGraph, for its cameras and visualizers.

    They have a perception and an illustration role, but no proximity role: a
    plant in the same SceneGraph does not collide with them.

    Args:
        builder: The builder with the SceneGraph.
        scene_graph: The SceneGraph; it gets the geometry under the source
            `name`.
        humans: The people, in the order of ``human_states``.
        time_step: The period of the states, in seconds.
        name: The name of the system that poses the figures.
        lively: Whether they sit, look aside and gesture by ``social_signals``.

    Raises:
        ValueError: If the SceneGraph is not in the builder, the name is taken,
            or there are more people than labels.
    """
    check_place(builder, scene_graph, name)
    taken = labels_taken(_all_labels(scene_graph))
    labels = tuple(human_label(i, taken) for i in range(len(humans)))
    plant = MultibodyPlant(time_step=0.0)
    plant.set_name(name)
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    joints = AddPeople(plant, humans, labels, lively=lively)
    plant.Finalize()
    inner = DiagramBuilder()
    _, poses = AddKinematics(inner, plant, humans, joints, {}, time_step)
    inner.ExportOutput(poses, "geometry_pose")
    figures = builder.AddNamedSystem(name, inner.Build())
    builder.Connect(
        figures.get_output_port(),
        scene_graph.get_source_pose_port(plant.get_source_id()),
    )
    signals = None
    if figures.HasInputPort("social_signals"):
        signals = figures.GetInputPort("social_signals")
    return FigurePorts(figures.GetInputPort("human_states"), labels, signals)


def check_place(
    builder: DiagramBuilder, scene_graph: SceneGraph, name: str
) -> None:
    """Checks that figures can be added: see `AddFigures`.

    Raises:
        TypeError: If `scene_graph` is not a SceneGraph.
        ValueError: If it is not in the builder, or the name is taken.
    """
    check_kind("scene_graph", scene_graph, SceneGraph, "a SceneGraph")
    if not any(system is scene_graph for system in builder.GetSystems()):
        raise ValueError(
            "scene_graph must be in the same builder as the people, but is"
            " not; add it first, as by AddMultibodyPlantSceneGraph(builder,"
            " ...)"
        )
    if builder.HasSubsystemNamed(name):
        raise ValueError(
            f"the diagram has a system named {name!r} already: give these"
            " people another name"
        )


def _all_labels(scene_graph: SceneGraph) -> list[int]:
    """Returns the labels of all geometry with a perception role."""
    inspector = scene_graph.model_inspector()
    labels = []
    for geometry in inspector.GetAllGeometryIds(Role.kPerception):
        properties = inspector.GetPerceptionProperties(geometry)
        if properties.HasProperty("label", "id"):
            labels.append(int(properties.GetProperty("label", "id")))
    return labels
