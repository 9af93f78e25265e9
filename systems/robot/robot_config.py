"""The robots of trials: each has a body, limits, a start and a goal."""

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


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class RobotLimits:
    """How fast a robot moves. The defaults are those of PAL's PMB2."""

    max_speed: PositiveSpeed = 1.0
    """The largest speed forwards, in m/s."""

    max_reverse_speed: Speed = 0.2
    """The largest speed backwards, in m/s."""

    max_acceleration: Acceleration = 1.0
    """The largest change of speed, in m/s^2."""

    max_turn_rate: TurnRate = 2.09
    """The largest turn rate, in rad/s."""

    max_turn_acceleration: TurnAcceleration = 2.09
    """The largest change of the turn rate, in rad/s^2."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class RobotTask:
    """What stays constant around a robot.

    Attributes:
        time_step: The time between two updates of the trial, in seconds.
        obstacles: The walls; none by default.
        humans: The people whom it meets; nobody by default.
        human_starts: Shape (n, 2) or more columns: where they start, in W, in
            meters. By default as their configurations say.
    """

    time_step: float = 0.05
    obstacles: Obstacles = field(
        default_factory=lambda: Obstacles.from_shapes([], solid=[])
    )
    humans: Sequence[HumanConfig] = ()
    human_starts: Array | None = None

    @property
    def starts(self) -> Array:
        """Where people start, shape (n, 2), in meters."""
        if self.human_starts is not None:
            return np.asarray(self.human_starts)[:, :2]
        poses = [human.pose[:2] for human in self.humans]
        return np.array(poses, dtype=float).reshape(-1, 2)


@explain
@dataclass(kw_only=True, config=CONFIG)
class RobotConfig(ABC):
    """What all robots have; which one it is, a derived class tells."""

    physical: ClassVar[bool] = False
    """Whether people and walls stop it, as bodies of a plant do."""

    radius: BodyRadius = 0.35
    """The radius of its disc, in meters. The metrics of the paper use 0.35.
    """

    limits: RobotLimits = field(default_factory=RobotLimits)
    """How fast the robot moves."""

    start: Pose = (0.0, 0.0, 0.0)
    """The first pose (x, y, yaw) in W, in meters and radians."""

    goal: Pose | None = None
    """The pose (x, y, yaw) to reach, in W, in meters and radians; without one
    the robot stays where it is."""

    goal_tolerance: Tolerance = 0.25
    """How near to the goal counts as at the goal, in meters."""

    goal_yaw_tolerance: YawTolerance = 0.25
    """How near to the goal's heading counts as at the goal, in radians; pi or
    more leaves the final heading free."""

    @abstractmethod
    def MakeSystem(self, task: RobotTask) -> Any:
        """Makes the robot: a LeafSystem or a Diagram with these ports.

        Input ``velocity_command`` takes (v, omega), in m/s and rad/s; output
        ``robot_state`` gives the row (x, y, yaw, vx, vy, omega, radius) in W.
        If there is an input ``human_states``, it is given such rows of all
        people; and an output ``contacts``, of n rows of `layout.Contact`,
        stands in for the contacts that a trial counts by itself. An output
        ``wall_contact`` gives one such row of all walls.

        Args:
            task: What it is to know of the world and the people.
        """

    def AddToBuilder(
        self, builder: Any, task: RobotTask, *, name: str = "robot"
    ) -> Any:
        """Adds the robot to a builder, and returns it.

        Args:
            builder: A DiagramBuilder.
            task: What it is to know of the world and the people.
            name: What the system is called.

        Raises:
            TypeError: If it lacks a port: see `MakeSystem`.
        """
        # Reading a scenario does without Drake.
        from hunav_drake.systems.common.ports import CheckPorts

        system = self.MakeSystem(task)
        what = f"the robot {type(self).__name__}"
        inputs = {"velocity_command": 2}
        outputs = {"robot_state": STATE_SIZE}
        CheckPorts(system, what, inputs=inputs, outputs=outputs)
        n = len(task.humans)
        if system.HasInputPort("human_states"):
            inputs["human_states"] = STATE_SIZE * n
        if system.HasOutputPort("contacts"):
            outputs["contacts"] = CONTACT_SIZE * n
        if system.HasOutputPort("wall_contact"):
            outputs["wall_contact"] = CONTACT_SIZE
        CheckPorts(system, what, inputs=inputs, outputs=outputs)
        return builder.AddNamedSystem(name, system)

    def AddFigure(self, plant: Any, name: str) -> Any:
        """Adds the robot's own figure to a plant that is only looked at.

        Args:
            plant: A MultibodyPlant that is registered with a SceneGraph, and
                not finalized yet.
            name: What its model instance is to be called.

        Returns:
            The joints whose positions, in this order, are x, y and yaw; or
            None, as by default, for the figure of no particular robot.
        """
        return None

    def find_faults(self) -> Iterator[tuple[tuple[str, ...], str]]:
        """Looks for what is wrong beyond the ranges of single settings.

        Yields:
            The way to a setting, and what is wrong with it.
        """
        return iter(())

    def find_doubts(self) -> Iterator[tuple[tuple[str, ...], str]]:
        """Looks for what works, but is hardly meant.

        Yields:
            As `find_faults`.
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
