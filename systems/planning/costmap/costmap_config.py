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

# The layers of a costmap, applied in the order of its list.
Layer = Literal["static", "obstacle", "inflation", "social"]
Layers = Annotated[list[Layer], Field(max_length=8)]

Variance = Annotated[StrictFloat, within(0, 100, "m^2", low_open=True)]
Period = Annotated[StrictFloat, within(0, 60, "s", low_open=True)]


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class ObstacleLayer:
    """Obstacle layer: the walls and people that the planner knows."""

    source: Literal["ground_truth", "lidar"] = "ground_truth"
    """Source of the obstacles: "ground_truth" (the walls and the people nearby)
    or "lidar" (the hits of the first lidar of the trial)."""

    people_in_scan: StrictBool = True
    """Whether a lidar would detect people; for source "ground_truth" only. A
    lidar at foot height does; some lidars in Gazebo do not detect its actors.
    """

    person_radius: BodyRadius = 0.2
    """Radius of the disc that represents a person's feet, in meters."""

    marking_range: PositiveLength = 2.5
    """Range within which obstacles are marked, in meters."""

    clearing_range: PositiveLength = 3.0
    """Range within which a ray clears the cells that it passes, in meters."""

    footprint_clearing: StrictBool = True
    """Whether the cells inside the robot are always cleared."""


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class SocialLayer:
    """Social layer: costs around people, as in nav2_social_costmap_plugin.

    Each person has Gaussian costs with an amplitude and with variances along
    and across the walking direction; see `social_layer`. The defaults are those
    of the example in the plugin's README.
    """

    amplitude: Annotated[StrictFloat, within(0, 255)] = 255.0
    """Cost at the position of the person."""

    cutoff: Annotated[StrictFloat, within(0, 255, low_open=True)] = 10.0
    """Costs below this are set to 0."""

    covariance_when_still: Variance = 0.25
    """Variance around a standing person, in m^2."""

    covariance_front_height: Variance = 0.4
    """Variance in front of a walking person, along the direction, in m^2."""

    covariance_front_width: Variance = 0.25
    """Variance in front of a walking person, across the direction, in m^2."""

    covariance_rear_height: Variance = 0.25
    """Variance behind a walking person, along the direction, in m^2."""

    covariance_rear_width: Variance = 0.25
    """Variance behind a walking person, across the direction, in m^2."""

    covariance_right_height: Variance = 0.3
    """Variance to the right of a walking person, across the direction, in m^2.
    """

    covariance_right_width: Variance = 0.2
    """Variance to the right of a walking person, along the direction, in m^2.
    """

    use_passing: StrictBool = True
    """Whether to add costs to the right, so that others pass on the left."""

    use_vel_factor: StrictBool = True
    """Whether the variance in front grows with the speed."""

    speed_factor_multiplier: Annotated[StrictFloat, within(0, 100, "s/m")] = 5.0
    """Growth of that variance per unit of speed, in s/m."""


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class LocalCostmap:
    """Local costmap: it moves with the robot by whole cells.

    None: the value of the planner's profile.
    """

    size: Annotated[StrictFloat, within(0, 50, "m", low_open=True)] | None = (
        None
    )
    """Side length of the square map, in meters. None: the value of the profile.
    """

    resolution: Annotated[StrictFloat, within(0.01, 10, "m")] | None = None
    """Side length of a cell, in meters. None: the value of the profile."""

    update_period: Period | None = None
    """Time between two updates, in seconds. None: the value of the profile."""

    layers: Layers = field(default_factory=lambda: ["obstacle", "inflation"])
    """Layers of the map, in this order."""


@plain_errors
@dataclass(kw_only=True, config=CONFIG)
class GlobalCostmap:
    """Global costmap of the whole world, on which global paths are planned."""

    resolution: Annotated[StrictFloat, within(0.005, 10, "m")] = 0.05
    """Side length of a cell, in meters."""

    margin: Length = 3.0
    """Margin of the map beyond walls, robot and goal, in meters, where no walls
    close the world."""

    layers: Layers = field(
        default_factory=lambda: ["static", "obstacle", "inflation"]
    )
    """Layers of the map, in this order."""
