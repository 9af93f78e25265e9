"""What SFW remembers: an immutable value in the Context."""

from typing import NamedTuple


class SfwMemory(NamedTuple):
    """Where the robot is held.

    Attributes:
        x: The spot, in W, in meters.
        y: The same along the other axis.
        cycles: For how many cycles it has been there; 0 before the first.
    """

    x: float = 0.0
    y: float = 0.0
    cycles: int = 0
