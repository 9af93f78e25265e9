"""What holds for the crowd as a whole."""

from dataclasses import field
from typing import Annotated, Any

from pydantic import Field, StrictInt, StrictStr
from pydantic.dataclasses import dataclass

from hunav_drake.systems.schema import CONFIG, PositiveLength


@dataclass(kw_only=True, config=CONFIG)
class CrowdConfig:
    """How people move, and how they take in the world."""

    # The name of a registered model of motion: see
    # `hunav_drake.systems.crowd.MOTION_MODELS`.
    model: StrictStr = "social_force"

    # What differs from the defaults of that model's own dataclass.
    parameters: dict[str, Any] = field(default_factory=dict)

    # Walls whose nearest point is farther than this are not felt, in meters.
    obstacle_range: PositiveLength = 5.0

    # How many walls are felt at most, the nearest first; 0 for all in range.
    max_obstacles: Annotated[StrictInt, Field(ge=0, le=10**6)] = 0
