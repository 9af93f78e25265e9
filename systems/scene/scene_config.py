"""What is drawn of a trial besides people, robot and world."""

from dataclasses import field
from typing import Literal, get_args

from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import CONFIG

# goals      where people and robot go
# walked     where they came from, in the last seconds
# plan       what the planner means the robot to follow
# local_costmap, global_costmap
#            what the planner takes places around it, and everywhere, to cost
# rings      the edges of the intimate, personal and social space of people
#            (0.45, 1.2 and 3.6 m; Hall, "The Hidden Dimension", 1966)
# forces     what draws people to goals, and pushes them from people and walls
# names      what people are called, how they behave, and what they do
# reactions  who reacts to the robot
# scan       what the lidar of the robot meets
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
    "reactions",
    "scan",
    "clock",
]
OVERLAYS: tuple[Overlay, ...] = get_args(Overlay)
SHOWN: tuple[Overlay, ...] = (
    "goals",
    "walked",
    "plan",
    "names",
    "reactions",
    "clock",
)

# What a replay holds only if it is shown to begin with: it is large.
COSTMAPS: tuple[Overlay, ...] = ("local_costmap", "global_costmap")

# What recordings of trials do not hold, and films of them do not show.
NOT_RECORDED: tuple[Overlay, ...] = ("plan", *COSTMAPS, "forces", "scan")

# The edges of the intimate, personal and social space, in meters.
PROXEMIC_RADII = (0.45, 1.2, 3.6)

# How long a walked path is seen, in seconds.
WALKED_TIME = 6.0

# Who is slower than this stands, in m/s.
STANDING_SPEED = 0.15


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class SceneConfig:
    """What is seen of a trial, live, in replays and in films."""

    overlays: list[Overlay] = field(default_factory=lambda: list(SHOWN))
    """What is drawn besides people, robot and world, to begin with: the page of
    a replay, and the live view, show and hide each."""
