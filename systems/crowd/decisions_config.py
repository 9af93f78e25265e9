"""The configuration of people's random decisions."""

from dataclasses import field
from itertools import pairwise
from typing import Annotated

from pydantic import AfterValidator, Field, StrictFloat, StrictInt
from pydantic.dataclasses import dataclass
from pydantic_core import PydanticCustomError

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import CONFIG, within

_Redraw = tuple[
    Annotated[StrictFloat, within(0, 1e6, "s")],
    Annotated[StrictInt, Field(ge=1, lt=2**53)],
]


def _check_rising(redraws: list[_Redraw]) -> list[_Redraw]:
    for (one, _), (other, _) in pairwise(redraws):
        if not one < other:
            raise PydanticCustomError(
                "rule",
                "must be sorted by time, each later than the one before, but"
                " {other} s follows {one} s",
                {"one": f"{one:g}", "other": f"{other:g}"},
            )
    return redraws


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

    redraws: Annotated[list[_Redraw], AfterValidator(_check_rising)] = field(
        default_factory=list
    )
    """From when on other angles are drawn: pairs of a time, in seconds, and a
    whole number from 1; each number stands for other draws of the same seed.
    Up to that time, the trial is the same as without it."""
