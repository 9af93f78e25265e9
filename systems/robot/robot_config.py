"""The configuration of robots: body, limits, start and goal."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
import dataclasses
from dataclasses import field
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.layout import CONTACT_SIZE, STATE_SIZE
from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.common.schema import (
    CONFIG,
    BodyRadius,
    Pose,
    PositiveSpeed,
    Speed,
    within,
)
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.world.obstacles import Obstacles

Acceleration = Annotated[StrictFloat, within(0, 100, "m/s^2", low_open=True)]
TurnRate = Annotated[StrictFloat, within(0, 100, "rad/s", low_open=True)]
TurnAcceleration = Annotated[
    StrictFloat, within(0, 1e3, "rad/s^2", low_open=True)
]
Tolerance = Annotated[StrictFloat, within(0, 10, "m", low_open=True)]
YawTolerance = Annotated[StrictFloat, within(0, 10, "rad", low_open=True)]

# The body of a figure that carries cameras: see `RobotConfig.AddFigure`.
MOUNT = "hunav_mount"


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class RobotLimits:
    """Limits of a robot's motion. The defaults are those of PAL's PMB2."""

    max_speed: PositiveSpeed = 1.0
    """Maximum forward speed, in m/s."""

    max_reverse_speed: Speed = 0.2
    """Maximum backward speed, in m/s."""

    max_acceleration: Acceleration = 1.0
    """Maximum linear acceleration, in m/s^2."""

    max_turn_rate: TurnRate = 2.09
    """Maximum turn rate, in rad/s."""

    max_turn_acceleration: TurnAcceleration = 2.09
    """Maximum angular acceleration, in rad/s^2."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class RobotTask:
    """The constant data of a robot's task.

    Attributes:
        time_step: The time between two updates of the trial, in seconds.
        obstacles: The walls; none by default.
        humans: The people around it; nobody by default.
        human_starts: Shape (n, 2) or more columns: their start positions, in W,
            in meters. By default those of their configurations.
        robots: The other robots; none by default.
    """

    time_step: float = 0.05
    obstacles: Obstacles = field(
        default_factory=lambda: Obstacles.from_shapes([], solid=[])
    )
    humans: Sequence[HumanConfig] = ()
    human_starts: Array | None = None
    robots: Sequence["RobotConfig"] = ()

    @property
    def starts(self) -> Array:
        """The start positions of people, shape (n, 2), in meters."""
        if self.human_starts is not None:
            return np.asarray(self.human_starts)[:, :2]
        poses = [human.pose[:2] for human in self.humans]
        return np.array(poses, dtype=float).reshape(-1, 2)


@explain
@dataclass(kw_only=True, config=CONFIG)
class RobotConfig(ABC):
    """Base class of robot configurations."""

    physical: ClassVar[bool] = False
    """Whether people and walls stop the robot physically, as bodies of a plant.
    """

    radius: BodyRadius = 0.35
    """Radius of the robot's disc, in meters. The metrics of the paper use 0.35.
    """

    limits: RobotLimits = field(default_factory=RobotLimits)
    """Limits of the robot's speed and acceleration."""

    start: Pose = (0.0, 0.0, 0.0)
    """Start pose (x, y, yaw) in W, in meters and radians."""

    goal: Pose | None = None
    """Goal pose (x, y, yaw) in W, in meters and radians. None: the robot does
    not move."""

    goal_tolerance: Tolerance = 0.25
    """Distance from the goal at which it counts as reached, in meters."""

    goal_yaw_tolerance: YawTolerance = 0.25
    """Tolerance of the heading at the goal, in radians; pi or more allows any
    final heading."""

    command_delay: Annotated[StrictFloat, within(0, 5, "s")] = 0.0
    """Time from a command of the planner until the robot gets it, in seconds; a
    multiple of the trial's time step. Planners do not know of it."""

    @abstractmethod
    def MakeSystem(self, task: RobotTask) -> Any:
        """Makes the robot: a LeafSystem or a Diagram with these ports.

        Input ``velocity_command`` takes (v, omega), in m/s and rad/s; output
        ``robot_state`` gives the row (x, y, yaw, vx, vy, omega, radius) in W.
        An optional input ``human_states`` takes such rows of all people, and
        an optional input ``other_robot_states`` those of `RobotTask.robots`. An
        optional output ``contacts``, n rows of `layout.Contact`, replaces the
        contacts that a trial counts otherwise. An optional output
        ``wall_contact`` gives one such row for all walls.
        """

    def AddToBuilder(
        self, builder: Any, task: RobotTask, *, name: str = "robot"
    ) -> Any:
        """Adds the robot to a DiagramBuilder and returns it.

        Raises:
            TypeError: If it lacks a port: see `MakeSystem`.
        """
        # Imported here, so that reading a scenario does not load Drake.
        from hunav_drake.systems.common.ports import CheckPorts

        system = self.MakeSystem(task)
        what = f"the robot {type(self).__name__}"
        inputs = {"velocity_command": 2}
        outputs = {"robot_state": STATE_SIZE}
        CheckPorts(system, what, inputs=inputs, outputs=outputs)
        n, m = len(task.humans), len(task.robots)
        if system.HasInputPort("other_robot_states"):
            inputs["other_robot_states"] = STATE_SIZE * m
        if system.HasInputPort("human_states"):
            inputs["human_states"] = STATE_SIZE * n
        if system.HasOutputPort("contacts"):
            outputs["contacts"] = CONTACT_SIZE * n
        if system.HasOutputPort("wall_contact"):
            outputs["wall_contact"] = CONTACT_SIZE
        CheckPorts(system, what, inputs=inputs, outputs=outputs)
        return builder.AddNamedSystem(name, system)

    def AddFigure(self, plant: Any, name: str) -> Any:
        """Adds the robot's own figure to a plant for display only.

        The MultibodyPlant is registered with a SceneGraph and not finalized
        yet; the figure is the model instance `name`. Its body `MOUNT`, or
        without one its first body, carries cameras: its frame is on the floor.

        Returns:
            The joints whose positions, in this order, are x, y and yaw; None,
            the default, for a generic figure.
        """
        return None

    def find_faults(self) -> Iterator[tuple[tuple[str, ...], str]]:
        """Finds faults beyond the ranges of single settings.

        Yields:
            The path of a setting and the description of the fault.
        """
        return iter(())

    def find_doubts(self) -> Iterator[tuple[tuple[str, ...], str]]:
        """Finds valid settings that are probably not intended.

        Yields:
            The same as `find_faults`.
        """
        return iter(())


# The robots by name.
ROBOTS = Registry(
    "robot",
    RobotConfig,
    default="differential_drive",
    home="hunav_drake.systems.robot.robots",
)

register_robot = ROBOTS.register
