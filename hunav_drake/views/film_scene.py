"""The scene of a recorded trial, rendered without a browser."""

from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    LightParameter,
    MakeRenderEngineVtk,
    RenderCameraCore,
    RenderEngineVtkParams,
    Role,
)
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder
from pydrake.systems.sensors import CameraInfo

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.scene import AddScene, SceneInputs
from hunav_drake.systems.scene.bounds import (
    Bounds,
    port_of,
    scene_bounds,
    view_axes,
)
from hunav_drake.systems.scene.palette import FLOOR
from hunav_drake.systems.scene.surroundings import ShowCut
from hunav_drake.views.camera import (
    Camera,
    View,
    follow_camera,
    overview_camera,
    sun_camera,
    top_camera,
)
from hunav_drake.views.recorded_trial import RecordedTrial
from hunav_drake.views.replay import LIGHT_FROM, view_bounds

# The renderers: of all with shadows, of what moves, and without the sun.
_RENDERER, _MOVING, _SUNLESS = "film", "moving", "sunless"
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

# How far shadows begin behind what casts them, and the height of all that
# casts them, in meters.
_SUN_SLACK, _TALLEST = 0.05, 2.5


@dataclass(frozen=True)
class _Still:
    """All that stands still before a camera that does.

    Attributes:
        camera: The camera.
        image: The picture.
        dark: The picture without the sun.
        far: The depth of each pixel, in meters.
        floor: Whether a pixel shows the floor.
        sun: A camera where the sun is.
        sun_pixels: Where it sees what a pixel shows, in its picture, flat.
        sun_depth: How far from it that is, in meters.
    """

    camera: Camera
    image: np.ndarray
    dark: np.ndarray
    far: Array
    floor: Mask
    sun: Camera
    sun_pixels: NDArray[np.int32]
    sun_depth: NDArray[np.float32]


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
        single: bool = False,
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
            single: Whether one picture is taken only: it is drawn whole.
        """
        self._trial = trial
        self._view = view
        self._size = size
        self._bounds = view_bounds(trial.world, trial.humans, trial.robots)
        self._whole = scene_bounds(trial.world, trial.humans, trial.robots)
        self._shadows = shadows
        # Several steps per frame, if frames are too far apart for a gait.
        self._parts = max(math.ceil(step / 0.1), 1)
        self._step = step / self._parts
        self._run_up = math.ceil(_RUN_UP / self._step)
        self._start = start - self._run_up * self._step
        self._advanced, self._next = 0, 0
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
        add = scene.scene_graph.AddRenderer
        add(_RENDERER, _MakeRenderer(self._bounds, shadows))
        stands = view != "follow" and not single
        if stands:
            # Edges of figures blend with what is mostly behind them.
            floor = [FLOOR[0].r(), FLOOR[0].g(), FLOOR[0].b()]
            add(_MOVING, _MakeRenderer(self._bounds, False, floor))
            add(_SUNLESS, _MakeRenderer(self._bounds, False, sun=0.0))
        self._frame = scene.scene_graph.world_frame_id()
        self._graph, self._plant = scene.scene_graph, scene.plant
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
        self._Advance(0)
        # A camera that stands sees the same floor and world all the time.
        self._still: _Still | None = None
        if stands:
            self._still = self._DrawStill()

    def Take(self, number: int | None = None) -> Shot:
        """Returns the next picture, or a later one, by its number from 0."""
        self._next = self._next if number is None else number
        k = self._run_up + self._next * self._parts
        self._next += 1
        for step in range(self._advanced + 1, k + 1):
            self._Advance(step)
        time = self._start + k * self._step
        humans, robots = self._trial.States(time)
        if self._still is None:
            camera = self._Camera(robots[0])
            context = self._WithoutAbsent(humans)
            image = self._Color(context, camera, _RENDERER)
            far = self._Depth(context, camera, _RENDERER)
            floor = _shows_floor(far, camera.FloorDepth())
        else:
            camera = self._still.camera
            image, floor = self._AddMoving(self._still)
        return Shot(image, floor, camera, humans, robots, time)

    def _WithoutAbsent(self, humans: Array) -> Context:
        """Returns the Context, without figures far away of who is absent.

        The sun's shadows are drawn as far as there are figures.
        """
        root: Context = self._simulator.get_context()
        absent = {
            human.name
            for human, row in zip(self._trial.humans, humans, strict=True)
            if np.isnan(row[0])
        }
        if not absent:
            return root
        root = root.Clone()
        graph, source = self._graph, self._plant.get_source_id()
        inspector = graph.model_inspector()
        inside = graph.GetMyMutableContextFromRoot(root)
        for frame in inspector.FramesForSource(source):
            if inspector.GetName(frame).rpartition("::")[0] in absent:
                graph.RemoveRole(inside, source, frame, Role.kPerception)
        return root

    def _DrawStill(self) -> "_Still":
        """Draws all that stands still, and takes it out of the scene."""
        camera = self._Camera(np.zeros(0))
        graph, source = self._graph, self._plant.get_source_id()
        root = self._simulator.get_mutable_context()
        without = root.Clone()
        frames = graph.model_inspector().FramesForSource(source)
        for context, gone in (
            (without, [it for it in frames if it != self._frame]),
            (root, [self._frame]),
        ):
            inside = graph.GetMyMutableContextFromRoot(context)
            for frame in gone:
                graph.RemoveRole(inside, source, frame, Role.kPerception)
        far = self._Depth(without, camera, _RENDERER)
        whole = self._whole
        sun = sun_camera(whole, -_to_sun(self._bounds), height=_TALLEST)
        # Where the sun sees what each pixel shows, and how far from it.
        points = camera.Unproject(np.where(np.isfinite(far), far, 0.0))
        pixels, depth = sun.Project(points.reshape(-1, 3))
        places = np.floor(np.nan_to_num(pixels - 0.5, nan=-1.0)).astype(int)
        outside = np.any(places < 0, axis=1)
        outside |= np.any(places >= np.array(sun.size) - 1, axis=1)
        index = places[:, 1] * sun.size[0] + places[:, 0]
        # (What it does not see is in no shadow.)
        index[outside], depth[outside] = 0, -np.inf
        return _Still(
            camera=camera,
            image=self._Color(without, camera, _RENDERER),
            dark=self._Color(without, camera, _SUNLESS),
            far=far,
            floor=_shows_floor(far, camera.FloorDepth()),
            sun=sun,
            sun_pixels=index.astype(np.int32),
            sun_depth=(depth - _SUN_SLACK).astype(np.float32),
        )

    def _AddMoving(self, still: "_Still") -> tuple[np.ndarray, Mask]:
        """Returns the picture with all that moves, and where floor is seen."""
        context = self._simulator.get_context()
        image, floor = still.image.copy(), still.floor.copy()
        if self._shadows:
            nearest = self._Depth(context, still.sun, _MOVING).ravel()
            row = still.sun.size[0]
            around = (0, 1, row, row + 1)
            cast = np.isfinite(nearest)
            for step in around[1:]:
                cast[:-step] |= np.isfinite(nearest[step:])
            maybe = np.flatnonzero(cast[still.sun_pixels])
            places, depth = still.sun_pixels[maybe], still.sun_depth[maybe]
            share = np.mean(
                [nearest[places + step] < depth for step in around], axis=0
            )[:, None]
            lit, dark = (it.reshape(-1, 3) for it in (image, still.dark))
            mixed = lit[maybe] * (1.0 - share) + dark[maybe] * share
            lit[maybe] = np.rint(mixed).astype(np.uint8)
        near = self._Depth(context, still.camera, _MOVING)
        seen = near < still.far
        # The part with all that moves; Drake asks for the middle in it.
        ends = []
        for axis, pixels in enumerate(seen.shape):
            (some,) = np.nonzero(seen.any(axis=1 - axis))
            middle = [(pixels - 1) // 2 - 1, pixels // 2]
            ends.append(np.append(some, middle))
        top, left = (int(it.min()) for it in ends)
        bottom, right = (int(it.max()) + 1 for it in ends)
        here, box = np.s_[top:bottom, left:right], (left, top, right, bottom)
        moving = self._Color(context, still.camera, _MOVING, box)
        image[here][seen[here]] = moving[seen[here]]
        floor[seen] = False
        return image, floor

    def _Color(
        self,
        context: Context,
        camera: Camera,
        renderer: str,
        box: tuple[int, int, int, int] | None = None,
    ) -> np.ndarray:
        """Returns the picture, or a part: left, top, right and bottom."""
        query = self._diagram.GetOutputPort("query").Eval(context)
        core = _core(camera, renderer, box or (0, 0, *camera.size))
        shown = ColorRenderCamera(core)
        data = query.RenderColorImage(shown, self._frame, camera.X_WC).data
        return np.array(data[..., :3])

    def _Depth(self, context: Context, camera: Camera, renderer: str) -> Array:
        """Returns the depth of each pixel, in meters; infinite if empty."""
        query = self._diagram.GetOutputPort("query").Eval(context)
        core = _core(camera, renderer, (0, 0, *camera.size))
        span = core.clipping()
        shown = DepthRenderCamera(
            core, DepthRange(span.near(), 0.999 * span.far())
        )
        data = query.RenderDepthImage(shown, self._frame, camera.X_WC).data
        return np.array(data[..., 0])

    def _Advance(self, k: int) -> None:
        """Advances to the k-th step."""
        self._advanced = k
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


def _core(
    camera: Camera, renderer: str, box: tuple[int, int, int, int]
) -> RenderCameraCore:
    left, top, right, bottom = box
    f, (x, y) = camera.focal_length, (it / 2 - 0.5 for it in camera.size)
    info = CameraInfo(right - left, bottom - top, f, f, x - left, y - top)
    span = ClippingRange(*camera.clipping)
    return RenderCameraCore(renderer, info, span, RigidTransform())


def _shows_floor(far: Array, floor: Array) -> Mask:
    """Returns whether pixels show the floor, by depths of it and of all."""
    slack = _FLOOR_SLACK + 0.001 * np.where(np.isfinite(far), far, 0.0)
    with np.errstate(invalid="ignore"):
        shows: Mask = np.abs(far - floor) < slack
    return shows


def _to_sun(bounds: Bounds) -> Array:
    """Returns the direction of the sun in W, not of length 1."""
    right, ahead = view_axes(bounds)
    direction: Array = np.array(LIGHT_FROM) @ [right, ahead, [0.0, 0.0, 1.0]]
    return direction


def _MakeRenderer(
    bounds: Bounds,
    shadows: bool,
    background: Sequence[float] = _BACKGROUND,
    sun: float = _SUN,
) -> Any:
    right, _ = view_axes(bounds)
    light = LightParameter(
        type="directional",
        frame="world",
        direction=-_to_sun(bounds),
        intensity=sun,
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
            default_clear_color=list(background),
            lights=[light, *lamps],
            cast_shadows=shadows,
            shadow_map_size=2048,
        )
    )
