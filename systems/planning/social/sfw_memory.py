"""The memory of SFW: an immutable value in the Context."""

from typing import NamedTuple


class SfwMemory(NamedTuple):
    """The spot where the robot is held, and the direction of its odometry.

    Attributes:
        x: The spot's x, in W, in meters.
        y: The spot's y.
        cycles: The number of cycles there; 0 before the first.
        odometry_yaw: The direction of the odometry's x axis in W, in radians;
            None if it is not needed or not known yet.
    """

    x: float = 0.0
    y: float = 0.0
    cycles: int = 0
    odometry_yaw: float | None = None

    def anew(self, x: float = 0.0, y: float = 0.0) -> "SfwMemory":
        """Returns the memory of a robot that has just reached a spot."""
        return SfwMemory(x, y, 0, self.odometry_yaw)
