"""The memory of a planner with costmaps: immutable values in the Context."""

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
        goal: The last pose (x, y, yaw) of the global plan.
        is_new: Whether the global plan was replaced since the last cycle.
    """

    poses: Array
    goal: tuple[float, float, float]
    is_new: bool


class Control(NamedTuple):
    """The decision of a local controller in one cycle.

    Attributes:
        v: The forward speed, in m/s.
        omega: The turn rate, in rad/s.
        memory: The memory for the next cycle; immutable.
        fault: Why there is no command; empty if there is one.
    """

    v: float
    omega: float
    memory: Any = None
    fault: str = ""


class Sight(NamedTuple):
    """The observation that the local costmap is computed from.

    Attributes:
        cycle: The cycle of the observation; -1 for none.
        robot: The row of the robot.
        humans: The rows of the people.
        marks: The marks of a lidar; None for the ground truth.
    """

    cycle: int = -1
    robot: Array = NO_PATH
    humans: Array = _NOBODY
    marks: Marks | None = None


class Recovery(NamedTuple):
    """The recovery in progress.

    Attributes:
        queue: The remaining recoveries, the current one first.
        since: The cycle when the current one began.
        x: The robot's x then, in W, in meters.
        y: The robot's y then.
        yaw: The heading of the last cycle, in radians.
        turned: The turn since the current one began, in radians.
    """

    queue: tuple[str, ...]
    since: int
    x: float
    y: float
    yaw: float
    turned: float = 0.0


class NavigationMemory(NamedTuple):
    """The memory of navigation between two cycles.

    Attributes:
        goal: The current goal; empty before the first.
        cycle: The number of cycles with this goal.
        path: The global plan, shape (k, 3), rows (x, y, yaw) in W.
        first: The index of its first pose that is not passed yet.
        misses: The distance of its end from the goal, in meters.
        covered: Whether people cover the goal, so that it ends elsewhere.
        planned: The cycle of the last planning; -1 for none.
        is_new: Whether the controller has not used the plan yet.
        sight: The observation that the local costmap is computed from.
        marks: The marks of a lidar on the global costmap.
        near: The robot's position (x, y) at its last progress, and the cycle.
        failing: The first cycle without a command; -1 if there is one.
        retried: Whether it has retried since then.
        recovery: The recovery in progress; None without one.
        rounds: The number of recoveries so far.
        failed: Whether the planner has given up.
        reason: Why it is not simply driving, as text.
        control: The memory of the local controller.
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
