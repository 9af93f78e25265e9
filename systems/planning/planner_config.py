"""Which planner drives the robot, and how it is set."""

from dataclasses import field
from typing import Annotated, Any

from pydantic import StrictFloat, StrictStr
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.schema import CONFIG, within


@dataclass(kw_only=True, slots=True, config=CONFIG)
class PlannerConfig:
    """The choice of a local planner."""

    # The name of a registered planner: see
    # `hunav_drake.systems.planning.PLANNERS`.
    name: StrictStr = "pursuit"

    # The time between two commands, in seconds: a multiple of the step.
    period: Annotated[StrictFloat, within(0, 10, "s", low_open=True)] = 0.05

    # What differs from the defaults of that planner's own dataclass.
    parameters: dict[str, Any] = field(default_factory=dict)
