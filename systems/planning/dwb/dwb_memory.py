"""What DWB's critics remember from one cycle to the next."""

from typing import NamedTuple


class Trend(NamedTuple):
    """Which way one part of the command went, for Oscillation.

    Attributes:
        sign: That of the last command; 0 before the first.
        only: The sign that alone is allowed; 0 if both are.
    """

    sign: int = 0
    only: int = 0

    def after(self, value: float) -> "Trend":
        """Returns the trend after a command: a change of sign forbids."""
        sign = (value > 0) - (value < 0)
        if sign == 0:
            return self
        return Trend(sign, sign if self.sign == -sign else self.only)


class DwbMemory(NamedTuple):
    """What the critics remember; a new global plan makes them forget it.

    Attributes:
        in_window: RotateToGoal: whether the robot has come to the goal.
        rotating: Whether it was slow enough there to turn.
        x: Oscillation: the trend of the speed.
        theta: That of the turn rate.
        pose: Where the robot was, (x, y, yaw), when a sign changed last.
        cycles: How many cycles ago that was.
    """

    in_window: bool = False
    rotating: bool = False
    x: Trend = Trend()
    theta: Trend = Trend()
    pose: tuple[float, float, float] = (0.0, 0.0, 0.0)
    cycles: int = 0
