"""The configuration of the crowd as a whole."""

from dataclasses import field
from typing import Annotated, Any

from pydantic import Field, StrictBool, StrictStr
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.schema import CONFIG, Integer, PositiveLength


@dataclass(kw_only=True, slots=True, config=CONFIG)
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
    max_obstacles: Annotated[Integer, Field(ge=0, le=10**6)] = 0

    # Whether walls stop people who are pushed into them: at the end of a step
    # nobody's center is inside a wall, or nearer to one than 0.1 m (or the
    # radius, if that is less). Who meets no wall moves as without.
    keep_out_of_walls: StrictBool = True

    # Whether people walk around walls to their goals, and let no walls push
    # them back from the doors on their way; without, straight at the goals,
    # as in HuNavSim, whose forces let nobody of 0.35 m through 0.85 m.
    route_planning: StrictBool = True
