"""A shortest path, as metrics use it."""

from dataclasses import dataclass
import math
from typing import Self

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.poses import wrap_angle


@dataclass(frozen=True)
class Way:
    """A shortest path.

    Attributes:
        length: Its length, in meters.
        first_heading: Its direction at the start, in radians.
        last_heading: Its direction at the end, in radians.
        turning: Its total turn between the two, unsigned, in radians.
    """

    length: float
    first_heading: float
    last_heading: float
    turning: float

    @classmethod
    def straight(cls, start: Array, end: Array) -> Self:
        """Returns the straight path between two positions (2,), in meters."""
        x, y = (end - start).tolist()
        heading = math.atan2(y, x)
        return cls(math.hypot(x, y), heading, heading, 0.0)

    def then(self, other: Self) -> Self:
        """Returns this path followed by another."""
        if not self.length or not other.length:
            return self if self.length else other
        bend = abs(wrap_angle(other.first_heading - self.last_heading))
        return type(self)(
            self.length + other.length,
            self.first_heading,
            other.last_heading,
            self.turning + bend + other.turning,
        )
