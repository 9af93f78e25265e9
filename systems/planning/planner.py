"""The interface of planners, and the register of planners."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import IntEnum
import inspect
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import StrictFloat
from pydantic.dataclasses import dataclass as checked_dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.common.schema import CONFIG, within
from hunav_drake.systems.planning.perception import (
    PERCEPTIONS,
    PerceptionConfig,
)
from hunav_drake.systems.robot.robot_config import RobotLimits
from hunav_drake.systems.sensing.sensor_config import LidarConfig
from hunav_drake.systems.world.obstacles import Obstacles

NO_PATH: Array = np.zeros((0, 3))
NO_PATH.setflags(write=False)


@explain
class PlannerStatus(IntEnum):
    """What a planner is doing."""

    IDLE = 0
    """There is no goal."""

    DRIVING = 1
    """On the way to the goal."""

    SLOWED = 2
    """Slower than it would be, for something in the way."""

    BLOCKED = 3
    """At a stop, for something in the way."""

    ARRIVED = 4
    """At the goal."""

    RECOVERING = 5
    """Doing something else for a while, to get on again."""

    FAILED = 6
    """It has given up, and stays where it is."""


@dataclass(frozen=True, kw_only=True)
class PlanningTask:
    """What stays constant while a planner drives a robot.

    Attributes:
        limits: How fast the robot moves.
        robot_radius: In meters.
        goal_tolerance: The distance at which the goal counts as reached, m.
        goal_yaw_tolerance: The same for its heading, in radians.
        obstacles: The walls.
        num_humans: How many rows of people the planner gets.
        time_step: The time between two updates of the trial, in seconds.
        lidar: What measures the scan that the planner gets; None without one.
    """

    limits: RobotLimits
    robot_radius: float
    goal_tolerance: float
    goal_yaw_tolerance: float
    obstacles: Obstacles
    num_humans: int
    time_step: float = 0.05
    lidar: LidarConfig | None = None


@explain
@checked_dataclass(kw_only=True, config=CONFIG)
class PlannerConfig(ABC):
    """What all planners have; which one it is, a derived class tells.

    One whose decision is a pure function derives from `Planner`. Any other
    system is a planner, too: a class that derives from this one makes it.
    """

    period: Annotated[StrictFloat, within(0, 10, "s", low_open=True)] = 0.05
    """The time between two commands, in seconds: a multiple of the step."""

    sees: Annotated[PerceptionConfig, PERCEPTIONS] = field(
        default_factory=PERCEPTIONS.make
    )
    """Whom the planner sees: everything, visible, or lidar for nobody but what
    a lidar meets."""

    def reaction_time(self, task: PlanningTask) -> float:
        """Returns the time from a decision until the next one is in effect.

        A robot that would come to its goal, or turn to where it is to face,
        within less, would be carried beyond it.
        """
        return self.period + task.time_step

    def find_faults(
        self, obstacles: Obstacles, start: Array, goal: Array
    ) -> Iterator[tuple[tuple[str, ...], str]]:
        """Looks for what keeps it from driving, before anything runs.

        Args:
            obstacles: The walls.
            start: Where the robot starts, (x, y, yaw) in W.
            goal: Where it is to go, likewise.

        Yields:
            The place of a fault, counted from the planner, and what it is.
        """
        yield from ()

    @abstractmethod
    def MakeSystem(self, task: PlanningTask) -> Any:
        """Makes the planner: a LeafSystem or a Diagram with these ports.

        Inputs: ``robot_state`` takes the row (x, y, yaw, vx, vy, omega,
        radius) of the robot, ``human_states`` such rows of the people whom it
        may see, ``goal`` (x, y, yaw), which is not connected if there is no
        goal; all in W, in SI units. It may have an input ``scan``, which takes
        the distances that ``task.lidar`` measures, in meters. Outputs:
        ``velocity_command`` gives (v, omega), in m/s and rad/s, ``status`` a
        `PlannerStatus`, and ``path``, which is abstract, what it means to
        follow: an array of shape (k, 2) or (k, 3), rows (x, y) or
        (x, y, yaw). It may have outputs ``local_costmap`` and
        ``global_costmap``, abstract, a `Costmap` each, for Meshcat to draw.

        Args:
            task: What it is to know of the robot and the world.
        """

    def AddToBuilder(
        self, builder: Any, task: PlanningTask, *, name: str = "planner"
    ) -> Any:
        """Adds the planner to a builder, and returns it.

        Args:
            builder: A DiagramBuilder.
            task: What it is to know of the robot and the world.
            name: What the system is called.

        Raises:
            TypeError: If it lacks a port: see `MakeSystem`.
            ValueError: If the period is not a multiple of the time step.
        """
        # Reading a scenario does without Drake.
        from hunav_drake.systems.common.ports import CheckPorts

        system = self.MakeSystem(task)
        CheckPorts(
            system,
            f"the planner {type(self).__name__}",
            inputs={
                "robot_state": STATE_SIZE,
                "human_states": task.num_humans * STATE_SIZE,
                "goal": 3,
            },
            outputs={"velocity_command": 2, "status": 1, "path": None},
        )
        return builder.AddNamedSystem(name, system)


class View(NamedTuple):
    """What a planner sees in one cycle; the arrays are read-only.

    Attributes:
        robot: The row (x, y, yaw, vx, vy, omega, radius) of the robot.
        humans: Shape (n, 7): such rows of the people. Those who are outside,
            if people come and go, or not seen are far away: see
            `layout.OUTSIDE`. None for who sees by the lidar alone.
        goal: (x, y, yaw), in meters and radians.
        scan: The distances that ``task.lidar`` measures, in meters; None if
            the planner does not ask for them. `scan_points` makes points.
    """

    robot: Array
    humans: Array
    goal: Array
    scan: Array | None = None


class Plan(NamedTuple):
    """What a planner decides in one cycle.

    Attributes:
        v: The speed forwards, in m/s.
        omega: The turn rate, in rad/s.
        status: What it is doing.
        memory: What it wants to know in the next cycle; immutable.
        path: What it means to follow, shape (k, 2) or (k, 3), rows (x, y) or
            (x, y, yaw) in W.
        reason: Why it does not just drive, in words. It is kept with the
            memory, and so needs an `initial_memory`.
    """

    v: float
    omega: float
    status: PlannerStatus
    memory: Any = None
    path: Array = NO_PATH
    reason: str = ""


@explain
@checked_dataclass(kw_only=True, config=CONFIG)
class PurePlanner(PlannerConfig):
    """What `Planner` has, but for the system that it makes."""

    initial_memory: ClassVar[Any] = None
    """What it remembers before the first cycle, and while there is no goal.
    With None, it decides by what it sees alone: it gives no memory and no path,
    and a trial is faster by some 50 us per step."""

    scan_size: ClassVar[int | None] = 0
    """How many distances of a lidar it asks for; None for as many as the lidar
    of its task has, 0 for no port ``scan`` unless it sees by the lidar."""

    decides_by: ClassVar[str] = "plan"
    """The method that its author writes; what it raises is told with its place.
    """

    cycle_limit: (
        Annotated[StrictFloat, within(0, 3600, "s", low_open=True)] | None
    ) = None
    """How long a cycle may take, in seconds of the wall clock; None for as long
    as it takes. A trial whose planner takes longer ends there, so that it
    depends on the machine; nothing else does."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "plan" in vars(cls):
            label = f"{cls.__qualname__}.plan()"
            check_arguments(vars(cls)["plan"], label, "self")

    @abstractmethod
    def plan(self, task: PlanningTask, view: View, memory: Any) -> Plan:
        """Decides the command of one cycle.

        Args:
            task: What does not change.
            view: What it sees now.
            memory: What the last cycle remembered.
        """


def asked_scan_size(planner: PlannerConfig) -> int | None:
    """Returns how many distances of a lidar a planner asks for.

    None is for as many as the lidar has, 0 for none.
    """
    size: int | None = getattr(planner, "scan_size", 0)
    return None if size == 0 and planner.sees.by_lidar else size


def check_arguments(function: Any, label: str, *first: str) -> None:
    """Checks that a function takes what a planner is called with.

    Args:
        function: The function.
        label: What it is called in the message.
        first: Arguments before the usual ones.

    Raises:
        TypeError: If it does not take (task, view, memory), or is none.
    """
    names = (*first, "task", "view", "memory")
    usual = ", ".join(names)
    if isinstance(function, staticmethod | classmethod):
        raise TypeError(
            f"{label} must be a plain method ({usual}), got a"
            f" {type(function).__name__}"
        )
    if not callable(function):
        raise TypeError(
            f"{label} must be a function ({usual}), got {function!r:.80}"
        )
    try:
        signature = inspect.signature(function)
    except ValueError:
        return
    try:
        signature.bind(*names)
    except TypeError as error:
        raise TypeError(
            f"{label} must take ({usual}), got {signature}"
        ) from error


# The planners by name.
PLANNERS = Registry(
    "planner",
    PlannerConfig,
    default="pursuit",
    home="hunav_drake.systems.planning.planners",
)

register_planner = PLANNERS.register
