"""What a planner with maps remembers: immutable values in the Context."""

from typing import Any, NamedTuple

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.planning.costmap.marks import Marks
from hunav_drake.systems.planning.planner import NO_PATH

_NOBODY: Array = np.zeros((0, STATE_SIZE))
_NOBODY.setflags(write=False)


class LocalPlan(NamedTuple):
    """The part of the global plan that a local controller follows.

    Attributes:
        poses: Shape (k, 3), k > 0, rows (x, y, yaw) in W; read-only.
        goal: The last pose (x, y, yaw) of the whole plan.
        is_new: Whether the global plan was replaced since the last cycle.
    """

    poses: Array
    goal: tuple[float, float, float]
    is_new: bool


class Control(NamedTuple):
    """What a local controller decides in one cycle.

    Attributes:
        v: The speed forwards, in m/s.
        omega: The turn rate, in rad/s.
        memory: What it wants to know in the next cycle; immutable.
        fault: Why there is no command; nothing if there is one.
    """

    v: float
    omega: float
    memory: Any = None
    fault: str = ""


class Sight(NamedTuple):
    """What the local map is made from: it follows, and is not kept.

    Attributes:
        cycle: When it was seen.
        robot: The row of the robot then.
        humans: Those of the people.
        marks: What a lidar had marked; None for the ground truth.
    """

    cycle: int = -1
    robot: Array = NO_PATH
    humans: Array = _NOBODY
    marks: Marks | None = None


class Recovery(NamedTuple):
    """What is being done to get on.

    Attributes:
        queue: What is left to do, the present first.
        since: The cycle when the present began.
        x: Where the robot was then, in W, in meters.
        y: The same along the other axis.
        yaw: The heading of the last cycle, in radians.
        turned: How far it has turned since the present began, in radians.
    """

    queue: tuple[str, ...]
    since: int
    x: float
    y: float
    yaw: float
    turned: float = 0.0


class NavigationMemory(NamedTuple):
    """What navigation remembers between two cycles.

    Attributes:
        goal: The goal that it is about; empty before the first.
        cycle: How many cycles there were with it.
        path: The global plan, shape (k, 3), rows (x, y, yaw) in W.
        first: The first pose of it that is not dropped yet.
        misses: How far its end is from the goal, in meters.
        covered: Whether people keep it from there.
        planned: The cycle when it was planned; -1 for none.
        is_new: Whether the controller has not seen it yet.
        sight: What the local map is made from.
        marks: What a lidar has marked on the global map.
        near: Where the robot was when it last got on, and in which cycle.
        failing: The cycle since when there is no command; -1 if there is one.
        retried: Whether it tried again since then.
        recovery: What is being done to get on.
        rounds: How many recoveries there were.
        failed: Whether it has given up.
        reason: Why it does not just drive, in words.
        control: What the local controller remembers.
    """

    goal: tuple[float, ...] = ()
    cycle: int = 0
    path: Array = NO_PATH
    first: int = 0
    misses: float = 0.0
    covered: bool = False
    planned: int = -1
    is_new: bool = False
    sight: Sight = Sight()
    marks: Marks | None = None
    near: tuple[float, float, int] = (0.0, 0.0, 0)
    failing: int = -1
    retried: bool = False
    recovery: Recovery | None = None
    rounds: int = 0
    failed: bool = False
    reason: str = ""
    control: Any = None
