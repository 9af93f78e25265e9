"""What the robot of a trial is, where it starts, and where it goes."""

from dataclasses import field
from typing import Annotated, Literal

from pydantic import StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.schema import (
    CONFIG,
    BodyRadius,
    Pose,
    PositiveSpeed,
    within,
)

Acceleration = Annotated[StrictFloat, within(0, 100, "m/s^2", low_open=True)]
TurnRate = Annotated[StrictFloat, within(0, 100, "rad/s", low_open=True)]
TurnAcceleration = Annotated[
    StrictFloat, within(0, 1e3, "rad/s^2", low_open=True)
]


@dataclass(kw_only=True, slots=True, config=CONFIG)
class RobotLimits:
    """How fast a robot moves. The defaults are those of PAL's PMB2."""

    # The largest speed forwards and the largest backwards, in m/s.
    max_speed: PositiveSpeed = 1.0
    max_reverse_speed: Annotated[StrictFloat, within(0, 10, "m/s")] = 0.2

    # The largest change of speed, in m/s^2.
    max_acceleration: Acceleration = 1.0

    # The largest turn rate, in rad/s, and its change, in rad/s^2.
    max_turn_rate: TurnRate = 2.09
    max_turn_acceleration: TurnAcceleration = 2.09


@dataclass(kw_only=True, slots=True, config=CONFIG)
class RobotConfig:
    """The robot of a trial."""

    # How it moves: "differential_drive" follows (v, omega) within its limits.
    model: Literal["differential_drive"] = "differential_drive"

    # The radius of its disc, in meters. (The metrics of the paper use 0.35.)
    radius: BodyRadius = 0.35

    limits: RobotLimits = field(default_factory=RobotLimits)

    # The first pose (x, y, yaw) in W, in meters and radians.
    start: Pose = (0.0, 0.0, 0.0)

    # The pose to reach; without one the robot stays where it is.
    goal: Pose | None = None

    # How near to the goal is at the goal, in meters and radians. A tolerance
    # of pi or more leaves the final heading free.
    goal_tolerance: Annotated[
        StrictFloat, within(0, 10, "m", low_open=True)
    ] = 0.25
    goal_yaw_tolerance: Annotated[
        StrictFloat, within(0, 10, "rad", low_open=True)
    ] = 0.25
