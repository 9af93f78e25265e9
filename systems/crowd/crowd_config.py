"""What holds for the crowd as a whole."""

from typing import Annotated

from pydantic import Field, StrictInt
from pydantic.dataclasses import dataclass

from hunav_drake.systems.schema import CONFIG, PositiveLength


@dataclass(kw_only=True, config=CONFIG)
class CrowdConfig:
    """How people take in the world."""

    # Walls whose nearest point is farther than this are not felt, in meters.
    obstacle_range: PositiveLength = 5.0

    # How many walls are felt at most, the nearest first; 0 for all in range.
    max_obstacles: Annotated[StrictInt, Field(ge=0, le=10**6)] = 0
