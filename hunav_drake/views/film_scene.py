"""The scene of a recorded trial, rendered without a browser."""

from dataclasses import dataclass
import math
from typing import Any

import numpy as np
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    LightParameter,
    MakeRenderEngineVtk,
    RenderCameraCore,
    RenderEngineVtkParams,
)
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import CameraInfo

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.scene import AddScene, SceneInputs
from hunav_drake.systems.scene.bounds import Bounds, port_of, view_axes
from hunav_drake.systems.scene.surroundings import ShowCut
from hunav_drake.views.camera import (
    Camera,
    View,
    follow_camera,
    overview_camera,
    top_camera,
)
from hunav_drake.views.recorded_trial import RecordedTrial
from hunav_drake.views.replay import FIELD_OF_VIEW, LIGHT_FROM, view_bounds

_RENDERER = "film"
_BACKGROUND = [0.945, 0.95, 0.96]

# The intensities of the sun and of the light at the camera.
_SUN, _LAMP = 0.62, 0.60

# The intensity of the lamps to the left and the right, and their distance, in
# meters: so large that they do not light the floor.
_SIDES, _FAR = 0.28, 300.0

# The time that people walk before the first picture, in seconds, so that their
# gait fits their speed.
_RUN_UP = 1.0

# The tolerance of depth at which a pixel shows the floor, in meters.
_FLOOR_SLACK = 0.03


@dataclass(frozen=True)
class Shot:
    """One picture.

    Attributes:
        image: Shape (height, width, 3), 8 bits.
        floor: Shape (height, width): whether a pixel shows the floor.
        camera: The camera.
        humans: Shape (n, 7): the states of people.
        robots: Shape (m, 7): the states of the robots.
        time: In seconds, on the clock of the recording.
    """

    image: np.ndarray
    floor: Mask
    camera: Camera
    humans: Array
    robots: Array
    time: float


class FilmScene:
    """Takes pictures of a recorded trial, one after the other."""

    def __init__(
        self,
        trial: RecordedTrial,
        view: View,
        size: tuple[int, int],
        *,
        start: float,
        step: float,
        shadows: bool = True,
    ) -> None:
        """Constructs a FilmScene.

        Args:
            trial: The trial.
            view: The view of the camera.
            size: Width and height of a picture, in pixels.
            start: The time of the first picture, on the clock of the
                recording, in seconds.
            step: The time between two pictures, on that clock.
            shadows: Whether figures cast shadows.
        """
        self._trial = trial
        self._view = view
        self._size = size
        self._bounds = view_bounds(trial.world, trial.humans, trial.robots)
        # Several steps per frame, if frames are too far apart for a gait.
        self._parts = max(math.ceil(step / 0.1), 1)
        self._step = step / self._parts
        self._run_up = math.ceil(_RUN_UP / self._step)
        self._start = start - self._run_up * self._step
        self._pictures = 0
        builder = DiagramBuilder()
        scene = AddScene(
            builder,
            trial.world,
            trial.humans,
            trial.robots,
            time_step=self._step,
            inputs=SceneInputs(sayings=trial.sayings),
        )
        ShowCut(scene.plant, scene.scene_graph)
        scene.scene_graph.AddRenderer(
            _RENDERER, _MakeRenderer(self._bounds, shadows)
        )
        self._frame = scene.scene_graph.world_frame_id()
        builder.ExportInput(scene.human_states, "human_states")
        self._ports = [port_of(it, "robot_state") for it in trial.robots]
        for port in self._ports:
            builder.ExportInput(scene.system.GetInputPort(port), port)
        if scene.system.HasInputPort("social_signals"):
            builder.ExportInput(
                scene.system.GetInputPort("social_signals"), "social_signals"
            )
        builder.ExportOutput(scene.query_object, "query")
        self._diagram = builder.Build()
        self._simulator = Simulator(self._diagram)
        for k in range(self._run_up + 1):
            self._Advance(k)

    def Take(self) -> Shot:
        """Returns the next picture."""
        k = self._run_up + self._pictures * self._parts
        if self._pictures:
            for i in range(self._parts):
                self._Advance(k - self._parts + i + 1)
        self._pictures += 1
        time = self._start + k * self._step
        humans, robots = self._trial.States(time)
        camera = self._Camera(robots[0])
        core = RenderCameraCore(
            _RENDERER,
            CameraInfo(*self._size, FIELD_OF_VIEW),
            ClippingRange(0.1, 2000.0),
            RigidTransform(),
        )
        context = self._simulator.get_context()
        query = self._diagram.GetOutputPort("query").Eval(context)
        color = query.RenderColorImage(
            ColorRenderCamera(core), self._frame, camera.X_WC
        )
        depth = query.RenderDepthImage(
            DepthRenderCamera(core, DepthRange(0.1, 1999.0)),
            self._frame,
            camera.X_WC,
        )
        far = np.asarray(depth.data)[..., 0]
        slack = _FLOOR_SLACK + 0.001 * np.where(np.isfinite(far), far, 0.0)
        with np.errstate(invalid="ignore"):
            floor = np.abs(far - camera.FloorDepth()) < slack
        image = np.array(color.data[..., :3])
        return Shot(image, floor, camera, humans, robots, time)

    def _Advance(self, k: int) -> None:
        """Advances to the k-th step."""
        humans, robots = self._trial.States(self._start + k * self._step)
        context = self._simulator.get_mutable_context()
        fix = self._diagram.GetInputPort
        fix("human_states").FixValue(context, humans.ravel())
        if self._diagram.HasInputPort("social_signals"):
            signals = self._trial.Signals(self._start + k * self._step)
            fix("social_signals").FixValue(context, signals.ravel())
        for port, robot in zip(self._ports, robots, strict=True):
            fix(port).FixValue(context, robot)
        self._simulator.AdvanceTo(k * self._step)

    def _Camera(self, robot: Array) -> Camera:
        if self._view == "top":
            return top_camera(self._bounds, self._size)
        if self._view == "follow":
            return follow_camera(self._bounds, robot, self._size)
        return overview_camera(self._bounds, self._size)


def _MakeRenderer(bounds: Bounds, shadows: bool) -> Any:
    right, ahead = view_axes(bounds)
    axes = np.array([right, ahead, [0.0, 0.0, 1.0]])
    sun = LightParameter(
        type="directional",
        frame="world",
        direction=-np.array(LIGHT_FROM) @ axes,
        intensity=_SUN,
    )
    middle = np.array([*bounds.center, 0.5])
    # Lamps, unlike suns, cast no shadows.
    lamps = [
        LightParameter(
            type="point",
            frame=frame,
            position=position,
            attenuation_values=[1.0, 0.0, 0.0],
            intensity=intensity,
        )
        for frame, position, intensity in (
            ("camera", np.zeros(3), _LAMP),
            ("world", middle - _FAR * right, _SIDES),
            ("world", middle + _FAR * right, _SIDES),
        )
    ]
    return MakeRenderEngineVtk(
        RenderEngineVtkParams(
            default_clear_color=_BACKGROUND,
            lights=[sun, *lamps],
            cast_shadows=shadows,
            shadow_map_size=2048,
        )
    )
