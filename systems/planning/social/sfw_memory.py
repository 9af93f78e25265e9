"""What SFW remembers: an immutable value in the Context."""

from typing import NamedTuple


class SfwMemory(NamedTuple):
    """Where the robot is held, and how its odometry lies.

    Attributes:
        x: The spot, in W, in meters.
        y: The same along the other axis.
        cycles: For how many cycles it has been there; 0 before the first.
        odometry_yaw: The direction of the odometry's x axis in W, in radians;
            None where it is not needed, or not known yet.
    """

    x: float = 0.0
    y: float = 0.0
    cycles: int = 0
    odometry_yaw: float | None = None

    def anew(self, x: float = 0.0, y: float = 0.0) -> "SfwMemory":
        """Returns the memory of a robot that has just come to a spot."""
        return SfwMemory(x, y, 0, self.odometry_yaw)
