"""The parameters of costmaps and their layers."""

from dataclasses import field
from typing import Annotated, Literal

from pydantic import Field, StrictBool, StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import (
    CONFIG,
    BodyRadius,
    Length,
    PositiveLength,
    within,
)

# What a costmap is made of, in the order that its list tells.
Layer = Literal["static", "obstacle", "inflation", "social"]
Layers = Annotated[list[Layer], Field(max_length=8)]

Variance = Annotated[StrictFloat, within(0, 100, "m^2", low_open=True)]
Period = Annotated[StrictFloat, within(0, 60, "s", low_open=True)]


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class ObstacleLayer:
    """What the planner knows of walls and people around the robot."""

    source: Literal["ground_truth", "lidar"] = "ground_truth"
    """Where the layer learns of walls and people: "ground_truth", the walls as
    they are and the people who are near; "lidar", what the first lidar of the
    trial has hit."""

    people_in_scan: StrictBool = True
    """Whether a lidar would see people. (One at the height of the feet does;
    the actors of Gazebo are invisible to some.) For the ground truth."""

    person_radius: BodyRadius = 0.2
    """The disc that stands for the feet of a person, in meters."""

    marking_range: PositiveLength = 2.5
    """What is farther from the robot is not marked, in meters."""

    clearing_range: PositiveLength = 3.0
    """How far a ray frees the cells that it passes, in meters."""

    footprint_clearing: StrictBool = True
    """Whether nothing that the layer marks can be inside the robot."""


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class SocialLayer:
    """The costs around people: of nav2_social_costmap_plugin.

    Gaussians about each person, of an amplitude and with variances along and
    across the direction of walking; see `social_layer`. The defaults are those
    of the example in its README.
    """

    amplitude: Annotated[StrictFloat, within(0, 255)] = 255.0
    """The cost at the place of the person."""

    cutoff: Annotated[StrictFloat, within(0, 255, low_open=True)] = 10.0
    """The cost below which there is none."""

    covariance_when_still: Variance = 0.25
    """The variance around who stands, in m^2."""

    covariance_front_height: Variance = 0.4
    """The variance ahead of who walks, along the direction, in m^2."""

    covariance_front_width: Variance = 0.25
    """The variance ahead of who walks, across the direction, in m^2."""

    covariance_rear_height: Variance = 0.25
    """The variance behind who walks, along the direction, in m^2."""

    covariance_rear_width: Variance = 0.25
    """The variance behind who walks, across the direction, in m^2."""

    covariance_right_height: Variance = 0.3
    """The variance to the right of who walks, outwards, in m^2."""

    covariance_right_width: Variance = 0.2
    """The variance to the right of who walks, along the direction, in m^2."""

    use_passing: StrictBool = True
    """Whether there is more room to the right, for others to pass on the left.
    """

    use_vel_factor: StrictBool = True
    """Whether the variance ahead grows with the speed."""

    speed_factor_multiplier: Annotated[StrictFloat, within(0, 100, "s/m")] = 5.0
    """By how much it grows per speed, in s/m."""


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class LocalCostmap:
    """The map around the robot, which moves with it by whole cells.

    What is None is as the planner's profile tells.
    """

    size: Annotated[StrictFloat, within(0, 50, "m", low_open=True)] | None = (
        None
    )
    """The side of the square, in meters; by default as the profile has it."""

    resolution: Annotated[StrictFloat, within(0.01, 10, "m")] | None = None
    """The side of a cell, in meters; by default as the profile has it."""

    update_period: Period | None = None
    """The time between two updates, in seconds; by default as the profile has
    it."""

    layers: Layers = field(default_factory=lambda: ["obstacle", "inflation"])
    """What is on the map, in this order."""


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class GlobalCostmap:
    """The map of the whole world, on which ways are found."""

    resolution: Annotated[StrictFloat, within(0.005, 10, "m")] = 0.05
    """The side of a cell, in meters."""

    margin: Length = 3.0
    """How far it reaches beyond walls, robot and goal, in meters, where no
    walls close the world."""

    layers: Layers = field(
        default_factory=lambda: ["static", "obstacle", "inflation"]
    )
    """What is on the map, in this order."""
