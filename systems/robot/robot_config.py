"""The robots of trials: each has a body, limits, a start and a goal."""

from abc import ABC, abstractmethod
from dataclasses import field
from typing import Annotated, Any

from pydantic import StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.common.schema import (
    CONFIG,
    BodyRadius,
    Pose,
    PositiveSpeed,
    Speed,
    within,
)

Acceleration = Annotated[StrictFloat, within(0, 100, "m/s^2", low_open=True)]
TurnRate = Annotated[StrictFloat, within(0, 100, "rad/s", low_open=True)]
TurnAcceleration = Annotated[
    StrictFloat, within(0, 1e3, "rad/s^2", low_open=True)
]
Tolerance = Annotated[StrictFloat, within(0, 10, "m", low_open=True)]
YawTolerance = Annotated[StrictFloat, within(0, 10, "rad", low_open=True)]


@dataclass(kw_only=True, slots=True, config=CONFIG)
class RobotLimits:
    """How fast a robot moves. The defaults are those of PAL's PMB2."""

    # The largest speed forwards and the largest backwards, in m/s.
    max_speed: PositiveSpeed = 1.0
    max_reverse_speed: Speed = 0.2

    # The largest change of speed, in m/s^2.
    max_acceleration: Acceleration = 1.0

    # The largest turn rate, in rad/s, and its change, in rad/s^2.
    max_turn_rate: TurnRate = 2.09
    max_turn_acceleration: TurnAcceleration = 2.09


@dataclass(kw_only=True, config=CONFIG)
class RobotConfig(ABC):
    """What all robots have; which one it is, a derived class tells."""

    # The radius of its disc, in meters. (The metrics of the paper use 0.35.)
    radius: BodyRadius = 0.35

    limits: RobotLimits = field(default_factory=RobotLimits)

    # The first pose (x, y, yaw) in W, in meters and radians.
    start: Pose = (0.0, 0.0, 0.0)

    # The pose to reach; without one the robot stays where it is.
    goal: Pose | None = None

    # How near to the goal is at the goal, in meters and radians. A tolerance
    # of pi or more leaves the final heading free.
    goal_tolerance: Tolerance = 0.25
    goal_yaw_tolerance: YawTolerance = 0.25

    @abstractmethod
    def MakeSystem(self, *, time_step: float) -> Any:
        """Makes the robot: a LeafSystem or a Diagram with these ports.

        Input ``velocity_command`` takes (v, omega), in m/s and rad/s; output
        ``robot_state`` gives the row (x, y, yaw, vx, vy, omega, radius) in W.

        Args:
            time_step: The time between two updates of a trial, in seconds.
        """

    def AddToBuilder(
        self, builder: Any, *, time_step: float, name: str = "robot"
    ) -> Any:
        """Adds the robot to a builder, and returns it.

        Args:
            builder: A DiagramBuilder.
            time_step: The time between two updates, in seconds.
            name: What the system is called.

        Raises:
            TypeError: If it lacks a port: see `MakeSystem`.
        """
        # Reading a scenario does without Drake.
        from hunav_drake.systems.common.ports import CheckPorts

        system = self.MakeSystem(time_step=time_step)
        CheckPorts(
            system,
            f"the robot {type(self).__name__}",
            inputs={"velocity_command": 2},
            outputs={"robot_state": STATE_SIZE},
        )
        return builder.AddNamedSystem(name, system)


# The robots by name.
ROBOTS = Registry(
    "robot", RobotConfig, tag="model", default="differential_drive"
)

register_robot = ROBOTS.register


@register_robot("differential_drive")
@dataclass(kw_only=True, config=CONFIG)
class DifferentialDriveConfig(RobotConfig):
    """A kinematic robot that follows (v, omega) within its limits."""

    def MakeSystem(self, *, time_step: float) -> Any:
        """Makes a `DifferentialDrive`."""
        # Reading a scenario does without Drake.
        from hunav_drake.systems.robot.differential_drive import (
            DifferentialDrive,
        )

        return DifferentialDrive(self, time_step=time_step)
