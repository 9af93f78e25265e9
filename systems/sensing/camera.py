"""Cameras rendered by Drake."""

import math

import numpy as np
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    FrameId,
    LightParameter,
    MakeRenderEngineVtk,
    RenderCameraCore,
    RenderEngineVtkParams,
    SceneGraph,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort
from pydrake.systems.sensors import CameraInfo, RgbdSensor

from hunav_drake.systems.sensing.sensor_parameters import CameraParameters

# The renderer of all cameras of a SceneGraph.
RENDERER = "hunav_drake"

# The sky, a light gray blue: (red, green, blue), each in [0, 1].
_SKY = (0.86, 0.90, 0.94)

# Lights from above and from the sides: their directions in W and intensities.
_LIGHTS = (
    ([0.2, 0.3, -1.0], 0.45),
    ([1.0, 0.5, -0.3], 0.75),
    ([-1.0, 0.6, -0.3], 0.65),
    ([0.1, -1.0, -0.3], 0.7),
)


def MakeCamera(
    config: CameraParameters, scene_graph: SceneGraph, parent_frame: FrameId
) -> Diagram:
    """Makes a camera.

    .. pydrake_system::

        name: camera
        input_ports:
        - query_object
        output_ports:
        - color_image
        - depth_image
        - label_image

    It contains Drake's RgbdSensor with these ports, rendered by VTK without a
    display. An image is rendered only when its port is evaluated. Port
    ``color_image`` gives an ImageRgba8U, ``depth_image`` an ImageDepth32F: the
    distance from the plane of the camera, in meters, 0 below `range_min`,
    infinity beyond `range_max`. Port ``label_image`` gives an ImageLabel16I:
    `human_label(i)` for person i, else the label that Drake gives to a body of
    a plant (its index, 0 for the world), and RenderLabel.kEmpty for the
    background.

    It has no state.

    Args:
        config: The camera.
        scene_graph: The rendered SceneGraph; it gets a renderer named
            `RENDERER`, if it has none of this name. No Context of it may exist
            yet.
        parent_frame: The frame of the mount: that of a robot's base, with z up,
            or of the world.
    """
    if not scene_graph.HasRenderer(RENDERER):
        lights = [
            LightParameter(
                type="directional",
                frame="world",
                direction=direction,
                intensity=intensity,
            )
            for direction, intensity in _LIGHTS
        ]
        renderer = MakeRenderEngineVtk(
            RenderEngineVtkParams(default_clear_color=_SKY, lights=lights)
        )
        scene_graph.AddRenderer(RENDERER, renderer)
    core = RenderCameraCore(
        RENDERER,
        CameraInfo(*config.image_size, config.field_of_view_y),
        ClippingRange(0.5 * config.range_min, 2.0 * config.range_max),
        RigidTransform(),
    )
    depth_range = DepthRange(config.range_min, config.range_max)
    builder = DiagramBuilder()
    sensor = builder.AddNamedSystem(
        "rgbd_sensor",
        RgbdSensor(
            parent_frame,
            camera_pose(config),
            ColorRenderCamera(core),
            DepthRenderCamera(core, depth_range),
        ),
    )
    builder.ExportInput(sensor.query_object_input_port(), "query_object")
    for port, name in (
        (sensor.color_image_output_port(), "color_image"),
        (sensor.depth_image_32F_output_port(), "depth_image"),
        (sensor.label_image_output_port(), "label_image"),
    ):
        builder.ExportOutput(port, name)
    diagram = builder.Build()
    diagram.set_name("camera")
    return diagram


def camera_pose(config: CameraParameters) -> RigidTransform:
    """Returns the pose X_PC of a camera C in its parent frame P.

    As in Drake, the camera looks along its z axis; x points to the right of the
    image, y down.
    """
    x, y, yaw = config.pose
    # The columns are the axes of a camera that looks along x.
    ahead = RotationMatrix(
        np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    )
    turn = RotationMatrix.MakeZRotation(yaw)
    tilt = RotationMatrix.MakeYRotation(config.pitch)
    return RigidTransform(turn @ tilt @ ahead, [x, y, config.height])


def focal_length(config: CameraParameters) -> float:
    """Returns the focal length of a camera, in pixels."""
    return 0.5 * config.image_size[1] / math.tan(0.5 * config.field_of_view_y)


def AddCamera(
    builder: DiagramBuilder,
    config: CameraParameters,
    scene_graph: SceneGraph,
    *,
    parent_frame: FrameId | None = None,
    query_object: OutputPort | None = None,
    name: str = "camera",
) -> Diagram:
    """Adds a camera to a builder and connects it to the geometry.

    Args:
        builder: The builder with the SceneGraph, or with a diagram that has it.
        config: The camera.
        scene_graph: The rendered SceneGraph; see `MakeCamera`.
        parent_frame: The frame of the mount; the world by default.
        query_object: The query port; by default that of the SceneGraph. A
            diagram that contains it exports another.
        name: The name of the system.

    Returns:
        The camera: see `MakeCamera` for its ports.

    Raises:
        ValueError: If the name is taken.
    """
    # Drake would abort the process when the diagram is built.
    if builder.HasSubsystemNamed(name):
        raise ValueError(
            f"the diagram has a system named {name!r} already: give the camera"
            " another name"
        )
    if parent_frame is None:
        parent_frame = scene_graph.world_frame_id()
    camera = builder.AddNamedSystem(
        name, MakeCamera(config, scene_graph, parent_frame)
    )
    builder.Connect(
        query_object or scene_graph.get_query_output_port(),
        camera.GetInputPort("query_object"),
    )
    return camera
