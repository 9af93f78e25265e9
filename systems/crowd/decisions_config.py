"""The configuration of people's random decisions."""

from typing import Annotated

from pydantic import Field, StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import CONFIG, within


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class DecisionsConfig:
    """Random decisions of people who walk: see `HumanDecisions`."""

    period: Annotated[StrictFloat, within(0, 60, "s", low_open=True)] = 0.25
    """Time between two decisions, in seconds: a multiple of the time step."""

    sigma_heading: Annotated[StrictFloat, within(0, 0.5, "rad")] = 0.2
    """Standard deviation of the angle between the way that a person takes and
    the one that its behavior wants, in radians."""

    rho: Annotated[StrictFloat, Field(ge=0, lt=1)] = 0.85
    """Correlation of that angle with the one of the decision before."""
