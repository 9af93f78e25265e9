"""The interface and the register of planners."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import IntEnum
import inspect
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

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
from hunav_drake.systems.sensing.localization_config import (
    LOCALIZATIONS,
    LocalizationConfig,
)
from hunav_drake.systems.sensing.sensor_config import LidarConfig
from hunav_drake.systems.world.obstacles import Obstacles

NO_PATH: Array = np.zeros((0, 3))
NO_PATH.setflags(write=False)


@explain
class PlannerStatus(IntEnum):
    """Status of a planner."""

    IDLE = 0
    """There is no goal."""

    DRIVING = 1
    """On the way to the goal."""

    SLOWED = 2
    """Slower than planned because of an obstacle."""

    BLOCKED = 3
    """Stopped because of an obstacle."""

    ARRIVED = 4
    """At the goal."""

    RECOVERING = 5
    """In a recovery, to make progress again."""

    FAILED = 6
    """The planner has given up; the robot stays at its position."""

    ERROR = 7
    """The planner has raised an error; the robot stays at its position."""


@dataclass(frozen=True, kw_only=True)
class PlanningTask:
    """The constant data of a planner's task.

    Attributes:
        limits: The limits of the robot's speed and acceleration.
        robot_radius: In meters.
        goal_tolerance: The distance at which the goal counts as reached, in
            meters.
        goal_yaw_tolerance: The same for its heading, in radians.
        obstacles: The walls.
        num_humans: The number of rows of people that the planner gets.
        time_step: The time between two updates of the trial, in seconds.
        lidar: The lidar of the planner's scan; None without one.
        on_error: Whether a planner that fails raises a `PlannerError`, or
            stops its robot for good with the status ERROR, while others go on.
        robot_name: The name of one of several robots; empty for a single one.
    """

    limits: RobotLimits
    robot_radius: float
    goal_tolerance: float
    goal_yaw_tolerance: float
    obstacles: Obstacles
    num_humans: int
    time_step: float = 0.05
    lidar: LidarConfig | None = None
    on_error: Literal["raise", "stop"] = "raise"
    robot_name: str = ""


@explain
@checked_dataclass(kw_only=True, config=CONFIG)
class PlannerConfig(ABC):
    """Base class of planner configurations.

    A planner whose decision is a pure function derives from `Planner`. Any
    other system can be a planner, too: derive a class from this one that makes
    it.
    """

    period: Annotated[StrictFloat, within(0, 10, "s", low_open=True)] = 0.05
    """Time between two commands, in seconds; a multiple of the trial's time
    step."""

    sees: Annotated[PerceptionConfig, PERCEPTIONS] = field(
        default_factory=PERCEPTIONS.make
    )
    """What the planner knows of people: `everything`, `visible` (in view),
    `detector` (in view, with errors), or `lidar` (only its scan)."""

    localization: Annotated[LocalizationConfig, LOCALIZATIONS] = field(
        default_factory=LOCALIZATIONS.make
    )
    """What the planner knows of the robot's pose: `exact`, `odometry` (an error
    that grows), or `gauss_markov` (an error that stays small)."""

    def reaction_time(self, task: PlanningTask) -> float:
        """Returns the time from a decision until the next one takes effect.

        A robot that reaches its goal or its heading in less time overshoots.
        """
        return self.period + task.time_step

    def find_faults(
        self, obstacles: Obstacles, start: Array, goal: Array
    ) -> Iterator[tuple[tuple[str, ...], str]]:
        """Finds faults that keep the planner from driving, before a run.

        `start` and `goal` are poses (x, y, yaw) in W.

        Yields:
            The path of a fault, relative to the planner, and its description.
        """
        yield from ()

    @abstractmethod
    def MakeSystem(self, task: PlanningTask) -> Any:
        """Makes the planner: a LeafSystem or a Diagram with these ports.

        Inputs: ``robot_state`` takes the row (x, y, yaw, vx, vy, omega, radius)
        of the robot, ``human_states`` such rows of the people, as far as it
        perceives them, ``goal`` (x, y, yaw), not connected or not finite if
        there is no goal; all in W, in SI units. An optional input ``scan``
        takes the distances that ``task.lidar`` measures, in meters. Outputs:
        ``velocity_command`` gives (v, omega), in m/s and rad/s, ``status`` a
        `PlannerStatus`, and ``path``, abstract, the planned path: an array of
        shape (k, 2) or (k, 3), rows (x, y) or (x, y, yaw). Optional outputs
        ``local_costmap`` and ``global_costmap``, abstract, give a `Costmap`
        each, for Meshcat to draw.
        """

    def AddToBuilder(
        self, builder: Any, task: PlanningTask, *, name: str = "planner"
    ) -> Any:
        """Adds the planner to a DiagramBuilder and returns it.

        Raises:
            TypeError: If it lacks a port: see `MakeSystem`.
            ValueError: If the period is not a multiple of the time step.
        """
        # Imported here, so that reading a scenario does not load Drake.
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
    """A planner's observation in one cycle; the arrays are read-only.

    Attributes:
        robot: The row (x, y, yaw, vx, vy, omega, radius) of the robot.
        humans: Shape (n, 7): such rows of the people. People who are absent or
            not seen are placed far away: see `layout.OUTSIDE`. No rows with
            lidar perception.
        goal: (x, y, yaw), in meters and radians.
        scan: The distances that ``task.lidar`` measures, in meters; None if the
            planner does not ask for them. `scan_points` converts them to
            points.
        time: The simulated time, in seconds.
    """

    robot: Array
    humans: Array
    goal: Array
    scan: Array | None = None
    time: float = 0.0


class Plan(NamedTuple):
    """A planner's decision in one cycle.

    Attributes:
        v: The forward speed, in m/s.
        omega: The turn rate, in rad/s.
        status: The status of the planner.
        memory: The memory for the next cycle; immutable.
        path: The planned path, shape (k, 2) or (k, 3), rows (x, y) or (x, y,
            yaw) in W.
        reason: Why it is not simply driving, as text. It is stored with the
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
    """Base class of `Planner`, without the system that it makes."""

    initial_memory: ClassVar[Any] = None
    """The memory before the first cycle, and while there is no goal. With None,
    decisions depend on the observation alone: the planner gives no memory and
    no path, and a trial is faster by about 50 us per step."""

    scan_size: ClassVar[int | None] = 0
    """The number of lidar distances it needs; None for those of the task's
    lidar, 0 for no port ``scan``, except with lidar perception."""

    decides_by: ClassVar[str] = "plan"
    """The method that its author writes; errors name the line in it."""

    cycle_limit: (
        Annotated[StrictFloat, within(0, 3600, "s", low_open=True)] | None
    ) = None
    """Maximum wall-clock time of a cycle, in seconds; None for no limit. A
    trial whose planner exceeds it ends with an error, and so depends on the
    machine; nothing else does."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "plan" in vars(cls):
            label = f"{cls.__qualname__}.plan()"
            check_arguments(vars(cls)["plan"], label, "self")

    @abstractmethod
    def plan(self, task: PlanningTask, view: View, memory: Any) -> Plan:
        """Returns the decision of one cycle from the last cycle's memory."""


def asked_scan_size(planner: PlannerConfig) -> int | None:
    """Returns the number of lidar distances that a planner needs.

    None for those of the task's lidar, 0 for none.
    """
    size: int | None = getattr(planner, "scan_size", 0)
    return None if size == 0 and planner.sees.by_lidar else size


def check_arguments(function: Any, label: str, *first: str) -> None:
    """Checks that a function takes the arguments of a planner.

    `label` is its name in the message, `first` are arguments before the usual
    ones.

    Raises:
        TypeError: If it does not take (task, view, memory) or is no function.
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
    home={
        "dwb": ".dwb.dwb",
        "scl": ".dwb.scl",
        "external": ".external",
        "mppi": ".mppi.mppi",
        "pursuit": ".pursuit",
        "bridge": ".ros2.bridge",
        "orca": ".social.orca",
        "sfm": ".social.sfm",
        "sfw": ".social.sfw",
        "stand": ".stand",
    },
)

register_planner = PLANNERS.register
