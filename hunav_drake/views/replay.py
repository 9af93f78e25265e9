"""Shows a trial in Meshcat, and writes its replay.

A run is recorded by the visualizer of the scene:

    meshcat = StartMeshcatLocal()
    SetView(meshcat, scenario.world, scenario.humans, scenario.robot)
    scene = AddScene(builder, ..., meshcat=meshcat)
    ...
    with RecordReplay(scene.visualizer):
        simulator.AdvanceTo(20.0)
    SaveReplay(meshcat, "replay.html")
"""

import base64
from collections.abc import Sequence
from dataclasses import astuple
import gzip
from importlib.resources import files
import itertools
import json
import math
import os
from pathlib import Path

import numpy as np
from pydrake.geometry import Meshcat, MeshcatParams

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.files import atomic_write
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.scene.bounds import (
    Bounds,
    Robots,
    by_name,
    overview_rotation,
    scene_bounds,
    view_axes,
)
from hunav_drake.systems.scene.overlays.viewer import RecordReplay
from hunav_drake.systems.world.shapes import World

__all__ = [
    "RecordReplay",
    "SaveReplay",
    "SetCamera",
    "SetLight",
    "SetView",
    "StartMeshcatLocal",
]

# A stretch that is marked below the time line: what is told where the mouse is
# on it, begin and end in seconds, and its color, as "#d55e00".
Mark = tuple[str, float, float, str]

# What happened: what is told of it, its time in seconds, and its kind, which
# gives it its color: "contact", "entry", "reaction" or "stop".
Event = tuple[str, float, str]

# The field of view of the camera, that of a long lens.
FIELD_OF_VIEW = math.radians(32.0)

# The usual ratio of width to height of a window; a narrower one cuts off the
# sides.
_ASPECT = 1.5

# The visible margin around the outermost walls, people and goals, and the
# height of people, in meters.
_MARGIN = 0.3
_HEIGHT = 1.8

# The visible margin around the places of people and robot, in meters.
_AROUND = 2.5

# Sides of the world that are nearer than this to them are visible, too, in m.
_HARDLY = 1.5

# The direction of the light relative to the camera: left, behind, above.
LIGHT_FROM = (-0.45, -0.55, 1.0)


def StartMeshcatLocal(port: int | None = None) -> Meshcat:
    """Starts a Meshcat that only this computer can reach.

    The default port is the first free one from 7000 on.
    """
    return Meshcat(MeshcatParams(host="localhost", port=port))


def SetView(
    meshcat: Meshcat,
    world: World,
    humans: Sequence[HumanConfig] = (),
    robot: Robots = None,
    *,
    aspect: float = _ASPECT,
) -> None:
    """Sets camera, light and background for a good view of a trial.

    A replay file keeps the view. Several robots are given by their names.
    `aspect` is the ratio of width to height of
    the window.
    """
    bounds = view_bounds(world, humans, robot)
    SetCamera(meshcat, bounds, aspect=aspect)
    SetLight(meshcat, scene_bounds(world, humans, robot, margin=_MARGIN))
    meshcat.SetProperty("/Background", "top_color", [0.97, 0.975, 0.98])
    meshcat.SetProperty("/Background", "bottom_color", [0.90, 0.91, 0.925])
    for clutter in ("/Grid", "/Axes"):
        meshcat.SetProperty(clutter, "visible", False)


def SetCamera(
    meshcat: Meshcat, bounds: Bounds, *, aspect: float = _ASPECT
) -> None:
    """Points the camera at a rectangle of floor, from above at an angle.

    The longer side of the rectangle is along the width of the screen.
    """
    p_WC, p_WT = camera_pose(bounds, aspect)
    distance = float(np.linalg.norm(p_WC - p_WT))
    meshcat.SetCamera(
        Meshcat.PerspectiveCamera(
            fov=math.degrees(FIELD_OF_VIEW),
            aspect=aspect,
            # Near and far planes close to the scene, because the depth buffer
            # must separate marks on the floor from the floor.
            near=distance / 100,
            far=distance * 20,
        )
    )
    meshcat.SetCameraPose(p_WC, p_WT)


def SetLight(meshcat: Meshcat, bounds: Bounds) -> None:
    """Lights a rectangle of floor evenly, with shadows.

    Meshcat's lamps are near the origin; a world may be elsewhere and larger.
    They are replaced by its spot light, so far away that it acts as a sun.
    """
    center = np.array([*bounds.center, 0.0])
    reach = math.hypot(*bounds.size) / 2 + 2.0
    distance = 5.0 * reach
    right, ahead = view_axes(bounds)
    to_light = np.array(LIGHT_FROM) @ [right, ahead, [0.0, 0.0, 1.0]]
    position = center + distance * to_light / np.linalg.norm(to_light)

    for lamp in ("PointLightNegativeX", "PointLightPositiveX"):
        meshcat.SetProperty(f"/Lights/{lamp}", "visible", False)
    meshcat.SetProperty("/Lights/AmbientLight/<object>", "intensity", 1.1)
    meshcat.SetProperty("/Lights/FillLight/<object>", "intensity", 0.5)
    fill = 10.0 * right - 10.0 * ahead + [0.0, 0.0, 6.0]
    meshcat.SetProperty("/Lights/FillLight", "position", fill.tolist())

    sun = "/Lights/SpotLight/<object>"
    meshcat.SetProperty(sun, "position", position.tolist())
    for name, value in {
        "intensity": 2.7,
        "decay": 0.0,
        "angle": math.atan(reach / distance),
        "penumbra": 0.0,
        "shadow.mapSize.width": 4096.0,
        "shadow.mapSize.height": 4096.0,
        "shadow.camera.near": distance - 2 * reach,
        "shadow.camera.far": distance + 2 * reach,
        "shadow.bias": -0.0005,
        "shadow.normalBias": 0.02,
        # The target of the lamp is not a node of the scene that could be moved;
        # three.js reads its place from this matrix, with y up.
        "target.matrixWorld.elements.12": center[0],
        "target.matrixWorld.elements.13": center[2],
        "target.matrixWorld.elements.14": -center[1],
    }.items():
        meshcat.SetProperty(sun, name, float(value))
    meshcat.SetProperty(sun, "castShadow", True)
    meshcat.SetProperty("/Lights/SpotLight", "visible", True)


def SaveReplay(
    meshcat: Meshcat,
    filename: str | os.PathLike[str],
    *,
    marks: Sequence[Sequence[Mark]] = (),
    events: Sequence[Event] = (),
) -> Path:
    """Writes the scene of a Meshcat, with its recording, as one web page.

    The page needs neither a server nor a network. It has check boxes for the
    overlays, a choice of views, and pause, restart, speed and time. It unpacks
    itself in any recent browser. It is written atomically: after an
    interruption the previous file remains.

    Args:
        meshcat: The Meshcat.
        filename: The file to write, in an existing folder.
        marks: Rows of stretches to mark below the time line.
        events: What happened, to jump to it.

    Returns:
        The absolute path of the file.
    """
    path = Path(filename).resolve()
    page = with_panel(meshcat.StaticHtml(), marks, events)
    # Motion takes much text: a compressed page is a fifth as large.
    packed = base64.b64encode(gzip.compress(page.encode(), 4, mtime=0))
    loader = _part("packed.html")
    before, after = loader.split("PACKED_PAGE")
    html = before + packed.decode() + after
    with atomic_write(path) as file:
        file.write(html.encode())
    return path


def with_panel(
    html: str,
    marks: Sequence[Sequence[Mark]] = (),
    events: Sequence[Event] = (),
) -> str:
    """Returns a page of Meshcat with the controls of a replay."""
    # The last one: a script before may contain this tag.
    before, after = html.rsplit("</body>", 1)
    # No text may end the script.
    panel = _part("panel.html")
    for name, told in (("MARKED_TIMES", marks), ("EVENT_TIMES", events)):
        text = json.dumps(told).replace("<", "\\u003c")
        panel = panel.replace(name, text)
    return f"{before}{panel}</body>{after}"


def _part(name: str) -> str:
    return (files("hunav_drake.views") / name).read_text("utf-8")


def view_bounds(
    world: World, humans: Sequence[HumanConfig] = (), robot: Robots = None
) -> Bounds:
    """Returns the visible part of a world: the area of people and robot.

    It contains their starts and goals and a margin within the world, and its
    walls where these are hardly farther; without people and robot, it is the
    whole world.
    """
    whole = scene_bounds(world, humans, robot, margin=_MARGIN)
    if not humans and not by_name(robot):
        return whole
    part = scene_bounds(World(), humans, robot, margin=_AROUND)
    sides = zip(astuple(whole), astuple(part), (1, 1, -1, -1), strict=True)
    return Bounds(
        *(
            outer if sign * (inner - outer) < _HARDLY else inner
            for outer, inner, sign in sides
        )
    )


def camera_pose(bounds: Bounds, aspect: float = _ASPECT) -> tuple[Array, Array]:
    """Returns the places of the camera and its target, p_WC and p_WT, in m.

    The camera is as close as possible with everything over the rectangle, up to
    the height of a person, in the picture.
    """
    # Camera axes in W: to the right, up in the picture, and backwards.
    right, up, back = overview_rotation(bounds).matrix().T
    _, ahead = view_axes(bounds)
    xs, ys = (bounds.x_min, bounds.x_max), (bounds.y_min, bounds.y_max)
    corners = np.array([*itertools.product(xs, ys, (0.0, _HEIGHT))])
    tan_up = math.tan(FIELD_OF_VIEW / 2)
    tan_right = aspect * tan_up
    p_WT = np.array([*bounds.center, 0.0])
    # Closer objects look larger: move the target along the floor until the room
    # above equals that below.
    for _ in range(20):
        p_TQ = corners - p_WT
        distance = np.max(
            p_TQ @ back
            + np.maximum(
                np.abs(p_TQ @ right) / tan_right, np.abs(p_TQ @ up) / tan_up
            )
        )
        height = (p_TQ @ up) / (distance - p_TQ @ back)
        p_WT = p_WT + ahead * distance * (height.max() + height.min()) / 2
    return p_WT + distance * back, p_WT
