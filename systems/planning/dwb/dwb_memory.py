"""The memory of DWB's critics between cycles."""

from typing import NamedTuple


class Trend(NamedTuple):
    """The direction of one component of the command, for Oscillation.

    Attributes:
        sign: The sign of the last command; 0 before the first.
        only: The only sign that is allowed; 0 if both are.
    """

    sign: int = 0
    only: int = 0

    def after(self, value: float) -> "Trend":
        """Returns the trend after a command; a new sign forbids the old one."""
        sign = (value > 0) - (value < 0)
        if sign == 0:
            return self
        return Trend(sign, sign if self.sign == -sign else self.only)


class DwbMemory(NamedTuple):
    """The memory of the critics; a new global plan clears it.

    Attributes:
        in_window: RotateToGoal: whether the robot has reached the goal.
        rotating: Whether it was slow enough there to turn.
        x: Oscillation: the trend of the speed.
        theta: The trend of the turn rate.
        pose: The robot's pose (x, y, yaw) when a sign last changed.
        cycles: The number of cycles since then.
    """

    in_window: bool = False
    rotating: bool = False
    x: Trend = Trend()
    theta: Trend = Trend()
    pose: tuple[float, float, float] = (0.0, 0.0, 0.0)
    cycles: int = 0
