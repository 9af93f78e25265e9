"""A row of the list of differences."""

from dataclasses import dataclass
from typing import Literal

Area = Literal["forces", "behaviors", "steps", "services", "metrics"]


@dataclass(frozen=True, kw_only=True)
class Difference:
    """Something that is not as in HuNavSim, on purpose.

    Attributes:
        area: What part of the program it is about.
        name: What it is called.
        original: What HuNavSim does.
        here: What is done here.
        why: The reason.
        key: What in a scenario undoes it alone; empty if nothing does.
        by_profile: Whether `crowd: {profile: hunavsim}` undoes it.
        metrics: The metrics that it is about.
        series: Whether only their series differ, and not the values.
    """

    area: Area
    name: str
    original: str
    here: str
    why: str
    key: str = ""
    by_profile: bool = False
    metrics: tuple[str, ...] = ()
    series: bool = False
