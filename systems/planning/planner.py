"""The interface of local planners, and the register of planners."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, ClassVar, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.robot.robot_config import RobotLimits
from hunav_drake.systems.world.obstacles import Obstacles

Array = NDArray[np.float64]


class PlannerStatus(IntEnum):
    """What a planner is doing."""

    # There is no goal.
    IDLE = 0
    # On the way to the goal.
    DRIVING = 1
    # Slower than it would be, for something in the way.
    SLOWED = 2
    # At a stop, for something in the way.
    BLOCKED = 3
    # At the goal.
    ARRIVED = 4


@dataclass(frozen=True, kw_only=True)
class PlanningTask:
    """What stays constant while a planner drives a robot.

    Attributes:
        limits: How fast the robot moves.
        robot_radius: In meters.
        goal_tolerance: The distance at which the goal counts as reached, m.
        goal_yaw_tolerance: The same for its heading, in radians.
        obstacles: The walls.
        period: The time between two commands, in seconds.
    """

    limits: RobotLimits
    robot_radius: float
    goal_tolerance: float
    goal_yaw_tolerance: float
    obstacles: Obstacles
    period: float


class Plan(NamedTuple):
    """What a planner decides in one cycle.

    Attributes:
        v: The speed forwards, in m/s.
        omega: The turn rate, in rad/s.
        status: What it is doing.
        memory: What it wants to know in the next cycle.
    """

    v: float
    omega: float
    status: PlannerStatus
    memory: tuple[float, ...] = ()


@runtime_checkable
class Planner(Protocol):
    """A local planner: a pydantic dataclass of parameters, and one function.

    The function must be pure: whatever it wants to remember goes through
    ``memory``, which lives in the Context.
    """

    # The number of floats that it remembers; they start as zeros.
    memory_size: ClassVar[int]

    def plan(
        self,
        task: PlanningTask,
        robot: Array,
        humans: Array,
        goal: Array,
        memory: Array,
    ) -> Plan:
        """Decides the command of one cycle.

        Args:
            task: What does not change.
            robot: The row (x, y, yaw, vx, vy, omega, radius) of the robot.
            humans: Shape (n, 7): such rows of the people.
            goal: (x, y, yaw), in meters and radians.
            memory: What the last cycle remembered, shape (memory_size,).
        """
        ...


# The planners by name; each is the dataclass of its parameters.
PLANNERS = Registry(
    "planner",
    needs=("plan", "memory_size"),
    home="hunav_drake.systems.planning.planners",
)


def register_planner[T](name: str) -> Callable[[type[T]], type[T]]:
    """Returns a decorator that makes a planner known by a name.

    A class replaces one that was defined in the same place, as when a cell of
    a notebook is run again.

    Raises:
        ValueError: If the name is taken.
        TypeError: If the class lacks ``plan`` or ``memory_size``.
    """
    return PLANNERS.register(name)


def make_planner(name: str, parameters: Mapping[str, Any]) -> Planner:
    """Returns the planner of a name, with some of its parameters set.

    Raises:
        ValueError: If there is no such planner or parameter, or if a value is
            outside its range.
    """
    planner: Planner = PLANNERS.make(name, parameters)
    return planner
