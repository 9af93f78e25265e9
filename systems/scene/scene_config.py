"""Configuration of the overlays of a scene."""

from dataclasses import field
import math
from typing import Literal, NamedTuple, get_args

from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import CONFIG

# goals      the goals of people and robot
# walked     their paths of the last seconds
# plan       the planned path of the robot
# local_costmap, global_costmap
#            the costmaps of the planner
# rings      the boundaries of the intimate, personal and social space of people
#            (0.45, 1.2 and 3.6 m; Hall, "The Hidden Dimension", 1966)
# forces     the forces on people: to goals, from people and from walls
# names      the names of people, their behaviors and activities
# speech     what people say
# reactions  the people who react to the robot
# estimate   the pose that a planner takes for that of its robot
# scan       the hits of the robot's lidar
# clock      the time of the trial
Overlay = Literal[
    "goals",
    "walked",
    "plan",
    "local_costmap",
    "global_costmap",
    "rings",
    "forces",
    "names",
    "speech",
    "reactions",
    "estimate",
    "scan",
    "clock",
]
OVERLAYS: tuple[Overlay, ...] = get_args(Overlay)
SHOWN: tuple[Overlay, ...] = (
    "goals",
    "walked",
    "plan",
    "names",
    "speech",
    "reactions",
    "estimate",
    "clock",
)

# Overlays that a replay contains only if they are shown initially: they are
# large.
COSTMAPS: tuple[Overlay, ...] = ("local_costmap", "global_costmap")

# Overlays that recordings of trials do not contain, nor films of them.
NOT_RECORDED: tuple[Overlay, ...] = (
    *("plan", *COSTMAPS, "forces", "estimate", "scan"),
)

# The radii of the intimate, personal and social space, in meters.
PROXEMIC_RADII = (0.45, 1.2, 3.6)

# The duration of a walked path, in seconds.
WALKED_TIME = 6.0

# The speed below which a person counts as standing, in m/s.
STANDING_SPEED = 0.15


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class SceneConfig:
    """Configuration of live views, replays and films."""

    overlays: list[Overlay] = field(default_factory=lambda: list(SHOWN))
    """Overlays that are shown initially, in addition to people, robot and
    world. The page of a replay and the live view can show and hide each."""


class Rays(NamedTuple):
    """The rays of a lidar.

    Attributes:
        angles: Their directions, in radians.
        begin: (x, y) where they begin, in meters.
        range_max: The distance of a ray that meets nothing, in meters.
        on_robot: Whether all is relative to the robot, and not to W.
    """

    angles: Array
    begin: tuple[float, float] = (0.0, 0.0)
    range_max: float = math.inf
    on_robot: bool = True
