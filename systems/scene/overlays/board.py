"""The Meshcat objects of overlays and their paths."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import math

import numpy as np
from pydrake.geometry import Cylinder, Meshcat, Rgba
from pydrake.math import RigidTransform

from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.scene.bounds import (
    Robots,
    by_name,
    figure_of,
    overview_rotation,
    scene_bounds,
)
from hunav_drake.systems.scene.meshes import TriangleMesh, plate, ring
from hunav_drake.systems.scene.overlays.tags import (
    BUBBLE_Z,
    CALM,
    REACTING,
    ROBOT_TAG_Z,
    SPEECH,
    TAG_Z,
    WORDS,
    TagBoard,
    bubble_text,
    tag_lift,
    tag_text,
)
from hunav_drake.systems.scene.palette import (
    FORCE_ARROWS,
    PLAN,
    PROXEMIC_RINGS,
    REACTION,
    RECORDED,
    SCAN,
    accent,
    top_of,
)
from hunav_drake.systems.scene.scene_config import (
    COSTMAPS,
    OVERLAYS,
    PROXEMIC_RADII,
    Overlay,
)
from hunav_drake.systems.world.shapes import World

# The Meshcat paths of figures, and of overlays that belong to no person.
FIGURES = "/drake/visualizer"
PLACE = "/drake/overlays"

# The activities of people on their tags.
ACTIVITIES = ("", "stands", "reacts")

# The numbers of dots of a walked path, a planned path, and a scan.
WALKED_DOTS = 12
PLAN_DOTS = 24
MAX_SCAN_DOTS = 90

# Heights of overlays above the floor, in meters. They differ by overlay and by
# person, because surfaces at the same height would flicker.
_RING_Z, _REACTION_Z, _WALKED_Z = 0.020, 0.026, 0.032
PLAN_Z, _FORCE_Z, SCAN_Z = 0.039, 0.041, 0.2
COSTMAP_Z: dict[Overlay, float] = {
    "global_costmap": 0.012,
    "local_costmap": 0.016,
}
_LIFT, _LEVELS = 0.0005, 12

# Within the floor, where nothing is visible: see `Board.hidden`.
HIDDEN_Z = -0.045


@dataclass(frozen=True)
class Walker:
    """A person or a robot whose walked path is shown.

    Attributes:
        name: The name of the figure.
        row: The row in `human_states`, or the number of the robot.
        height: The height of its path, in meters.
        is_robot: Whether it is a robot.
    """

    name: str
    row: int
    height: float
    is_robot: bool = False


class Board:
    """Draws the objects of overlays and gives their Meshcat paths."""

    def __init__(
        self,
        meshcat: Meshcat,
        world: World,
        humans: Sequence[HumanConfig],
        names: Sequence[str],
        robot: Robots,
        sayings: Sequence[Mapping[float, str]] | None = None,
    ) -> None:
        """Constructs a Board in Meshcat; `names` are those of the figures.

        `sayings` are the texts that each person may say: see `AddScene`.
        """
        self.robots = dict(by_name(robot))
        self.meshcat = meshcat
        self.names = tuple(names)
        self.walkers = [
            Walker(name, i, _WALKED_Z + _LIFT * (i % _LEVELS))
            for i, name in enumerate(names)
        ]
        height = _WALKED_Z + _LIFT * _LEVELS
        self.walkers += [
            Walker(figure_of(it), k, height, is_robot=True)
            for k, it in enumerate(self.robots)
        ]
        # The axes of the overview camera that tags face: right, up, back.
        bounds = scene_bounds(world, humans, robot)
        self.R_WT = overview_rotation(bounds)
        # Where marks are not visible, from any side: in the middle of the slab.
        self.hidden = [*bounds.center, HIDDEN_Z]
        self._humans = tuple(humans)
        self.recorded = tuple(it.track is not None for it in humans)
        self.sayings = tuple(sayings or ())
        self.activities = [*ACTIVITIES, *(WORDS.values() if sayings else ())]
        # The boards that face the camera, each with its height.
        higher = [tag_lift(it.figure.tall) for it in humans]
        self.boards = [
            (self.OfPerson("names", name), TAG_Z + lift)
            for name, lift in zip(names, higher, strict=True)
        ]
        self.boards += [
            (self.OfPerson("speech", name), BUBBLE_Z + lift)
            for name, lift, texts in zip(
                names, higher, self.sayings, strict=False
            )
            if texts
        ]

    def OfPerson(self, overlay: Overlay, name: str) -> str:
        """Returns the path of an overlay that moves with a figure."""
        return f"{FIGURES}/{name}/base/overlay_{overlay}"

    def Frame(self, robot: str) -> str:
        """Returns the path of a frame that moves with a robot.

        Views follow it, and it has the robot's name tag.
        """
        path = f"{PLACE}/overlay_robot"
        return f"{path}/{robot}" if robot else path

    def NameOf(self, robot: str) -> str:
        """Returns the path of the name tag of a robot."""
        return f"{self.Frame(robot)}/overlay_names"

    def OfAll(self, overlay: Overlay, robot: str = "") -> str:
        """Returns the path of an overlay that does not move with a figure.

        `robot` is the name of one of several robots that it belongs to.
        """
        path = f"{PLACE}/overlay_{overlay}"
        return f"{path}/{robot}" if robot else path

    def Walked(self, walker: Walker, dot: int) -> str:
        """Returns the path of a dot on a walked path."""
        return f"{self.OfAll('walked')}/{walker.name}/{dot}"

    def Plan(self, dot: int, robot: str = "") -> str:
        """Returns the path of a dot on the planned path of a robot."""
        return f"{self.OfAll('plan', robot)}/{dot}"

    def Scan(self, dot: int, robot: str = "") -> str:
        """Returns the path of a dot at a hit of the lidar of a robot."""
        return f"{self.OfAll('scan', robot)}/{dot}"

    def Force(self, name: str, kind: int) -> str:
        """Returns the path of an arrow: see `FORCE_ARROWS`."""
        return f"{self.OfPerson('forces', name)}/{kind}"

    def Tag(self, name: str, activity: int) -> str:
        """Returns the path of a name tag, by the place in `activities`."""
        return f"{self.OfPerson('names', name)}/{activity}"

    def Bubble(self, name: str, saying: int) -> str:
        """Returns the path of the bubble of a text, by its place in order."""
        return f"{self.OfPerson('speech', name)}/{saying}"

    def Paths(self, overlay: Overlay) -> list[str]:
        """Returns the paths of an overlay, to show or hide it."""
        alone = ("walked", "plan", "estimate", "scan", "clock", *COSTMAPS)
        if overlay in alone:
            return [self.OfAll(overlay)]
        if overlay == "goals":
            goals = [
                f"{FIGURES}/human_{i}_goal_{k}"
                for i, human in enumerate(self._humans)
                for k in range(len(human.goals))
            ]
            return goals + [
                f"{FIGURES}/{figure_of(name)}_goal"
                for name, robot in self.robots.items()
                if robot.goal is not None
            ]
        if overlay == "speech":
            # (After those of names.)
            return [path for path, _ in self.boards[len(self.names) :]]
        paths = [self.OfPerson(overlay, name) for name in self.names]
        if overlay == "names":
            paths += [self.NameOf(it) for it in self.robots]
        return paths

    def Show(self, overlay: Overlay, visible: bool) -> None:
        """Shows or hides an overlay."""
        for path in self.Paths(overlay):
            self.meshcat.SetProperty(path, "visible", visible)

    def Draw(
        self, shown: Sequence[Overlay], num_scan_dots: Mapping[str, int]
    ) -> None:
        """Redraws all overlays, and hides those that are not `shown`.

        `num_scan_dots` are the numbers of dots of robots by name.
        """
        self.meshcat.Delete(PLACE)
        for i, (human, name) in enumerate(
            zip(self._humans, self.names, strict=True)
        ):
            self._DrawPerson(i, human, name)
        # The page or the publisher turns them to the camera.
        for path, height in self.boards:
            self.meshcat.SetProperty(path, "position", [0.0, 0.0, height])
        for walker in self.walkers:
            radius, color = 0.06, top_of(walker.row)
            if walker.is_robot:
                radius, color = 0.07, accent(walker.row)
            for k in range(WALKED_DOTS):
                self._AddDot(self.Walked(walker, k), radius, color)
        for i, name in enumerate(self.robots):
            for k in range(PLAN_DOTS):
                plan = accent(i) if name else PLAN
                self._AddDot(self.Plan(k, name), 0.045, plan)
            for k in range(num_scan_dots.get(name, 0)):
                self._AddDot(self.Scan(k, name), 0.025, SCAN)
            path = self.NameOf(name)
            tag = TagBoard(
                tag_text(figure_of(name), ""), owner=accent(i) if name else None
            )
            self.meshcat.SetObject(f"{path}/0", tag)
            self.meshcat.SetProperty(path, "position", [0.0, 0.0, ROBOT_TAG_Z])
        # An empty object that tells the page of a replay to show a clock.
        self.meshcat.SetTransform(self.OfAll("clock"), RigidTransform())
        for overlay in OVERLAYS:
            self.Show(overlay, overlay in shown)

    def DrawEstimate(self, robot: str) -> None:
        """Draws the outline and the heading of a robot, to be moved."""
        names = list(self.robots)
        color = accent(names.index(robot)) if robot else PLAN
        radius = self.robots[robot].radius
        tip = [[radius, -0.08], [radius + 0.2, 0.0], [radius, 0.08]]
        place = self.OfAll("estimate", robot)
        band = ring(radius - 0.03, radius, SCAN_Z)
        self._AddMesh(f"{place}/ring", band, color)
        self._AddMesh(f"{place}/heading", plate(tip, SCAN_Z), color)

    def _AddDot(self, path: str, radius: float, color: Rgba) -> None:
        self.meshcat.SetObject(path, Cylinder(radius, 0.003), color)
        self.meshcat.SetProperty(path, "position", self.hidden)

    def _AddMesh(self, path: str, mesh: TriangleMesh, color: Rgba) -> None:
        self.meshcat.SetTriangleMesh(
            path, mesh.vertices.T, mesh.faces.T.astype(np.int32), color
        )

    def _DrawPerson(self, i: int, human: HumanConfig, name: str) -> None:
        lift = _LIFT * (i % _LEVELS)
        for k, (radius, color) in enumerate(
            zip(PROXEMIC_RADII, PROXEMIC_RINGS, strict=True)
        ):
            band = ring(radius - 0.02, radius, _RING_Z + lift, sides=72)
            self._AddMesh(f"{self.OfPerson('rings', name)}/{k}", band, color)
        radius = human.radius
        band = ring(radius, radius + 0.09, _REACTION_Z + lift)
        signs = [REACTION] if human.track is None else [REACTION, RECORDED]
        for k, color in enumerate(signs):
            path = f"{self.OfPerson('reactions', name)}/{k}"
            self._AddMesh(path, band, color)
        for kind, color in enumerate(FORCE_ARROWS):
            height = _FORCE_Z + lift + 0.006 * kind
            self._AddMesh(self.Force(name, kind), _arrow(height), color)
        for k, activity in enumerate(self.activities):
            text = tag_text(human.name, human.behavior_name, activity)
            path = self.Tag(name, k)
            colors = REACTING if activity == "reacts" else CALM
            self.meshcat.SetObject(
                path, TagBoard(text, colors, owner=top_of(i))
            )
        sayings = self.sayings[i].values() if self.sayings else ()
        for k, text in enumerate(sayings):
            path = self.Bubble(name, k)
            bubble = TagBoard(bubble_text(text), SPEECH, owner=top_of(i))
            self.meshcat.SetObject(path, bubble)
            self.meshcat.SetProperty(path, "visible", False)


def force_scale(force: np.ndarray) -> tuple[float, float]:
    """Returns the length (m) and direction (rad) of the arrow of a force.

    An arrow is 0.5 m long per m/s^2, and 2 m at most. The force is a pair (x,
    y), in m/s^2.
    """
    x, y = force
    length = min(0.5 * math.hypot(x, y), 2.0)
    return max(length, 1e-3), math.atan2(y, x)


def _arrow(height: float) -> TriangleMesh:
    """Returns an arrow along +x of length 1."""
    outline = [
        [0.0, -0.022],
        [0.78, -0.022],
        [0.78, -0.07],
        [1.0, 0.0],
        [0.78, 0.07],
        [0.78, 0.022],
        [0.0, 0.022],
    ]
    return plate(outline, height)
