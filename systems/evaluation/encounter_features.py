"""Features of the relative motion of robot and people."""

from functools import cached_property

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import RADIUS, VX, VY, YAW, X, Y
from hunav_drake.systems.evaluation.recorded_arrays import RecordedArrays

# Half of people's field of view, in radians.
HALF_FIELD_OF_VIEW = np.pi / 3


class EncounterFeatures:
    """Features of the relative motion of a robot and n people.

    `Recording.encounters` holds it. P is the vector from the robot to the
    person, V = v_r - v_i the velocity of the robot relative to the person. NaN
    where a person is missing.
    """

    def __init__(self, recording: RecordedArrays) -> None:
        self._recording = recording

    @cached_property
    def offset(self) -> tuple[Array, Array]:
        """The components of P, shape (N + 1, n) each, in meters."""
        return self._apart(X), self._apart(Y)

    @cached_property
    def distance(self) -> Array:
        """The distance of the centers |P|, shape (N + 1, n), in meters."""
        distance: Array = np.hypot(*self.offset)
        return distance

    @cached_property
    def reach(self) -> Array:
        """The sum of the radii R, shape (N + 1, n), in meters."""
        robot = self._recording.robot[:, None]
        reach: Array = self._recording.humans[..., RADIUS] + robot[..., RADIUS]
        return reach

    @cached_property
    def approach(self) -> tuple[Array, Array]:
        """The components of V, shape (N + 1, n) each, in m/s."""
        return -self._apart(VX), -self._apart(VY)

    def _apart(self, column: int) -> Array:
        """Returns the people's values in a column minus the robot's."""
        robot = self._recording.robot[:, None, column]
        apart: Array = self._recording.humans[..., column] - robot
        return apart

    @cached_property
    def relative_speed(self) -> Array:
        """The length of V, shape (N + 1, n), in m/s."""
        speed: Array = np.hypot(*self.approach)
        return speed

    @cached_property
    def closing(self) -> Array:
        """P . V, shape (N + 1, n), in m^2/s: positive while they approach."""
        (px, py), (vx, vy) = self.offset, self.approach
        closing: Array = px * vx + py * vy
        return closing

    @cached_property
    def passing_distance(self) -> Array:
        """The distance of the centers when passing on straight lines, in m.

        |P x V| / |V|, the distance from the line of relative motion, ahead or
        behind. Shape (N + 1, n); NaN where V = 0.
        """
        (px, py), (vx, vy) = self.offset, self.approach
        speed = self.relative_speed
        passing: Array = np.abs(px * vy - py * vx) / np.where(
            speed > 0, speed, np.nan
        )
        return passing

    @cached_property
    def time_to_collision(self) -> Array:
        """The first t >= 0 with |P - V t| = R, shape (N + 1, n), in seconds.

        0 where they overlap, infinity without a collision at constant
        velocities.
        """
        a = self.relative_speed**2
        b = self.closing
        c = self.distance**2 - self.reach**2
        root = np.sqrt(np.maximum(b * b - a * c, 0.0))
        meet = (b > 0) & (b * b >= a * c)
        # This form of the smaller root avoids cancellation.
        time = np.where(meet, c / np.where(meet, b + root, 1.0), np.inf)
        time = np.where(c <= 0, 0.0, time)
        return np.where(np.isnan(c), np.nan, time)

    @cached_property
    def angle_of_view(self) -> Array:
        """The angle of the robot in people's view, shape (N + 1, n).

        It is between the person's heading and the direction to the robot, in
        [0, pi].
        """
        px, py = self.offset
        yaw = self._recording.humans[..., YAW]
        along = -(px * np.cos(yaw) + py * np.sin(yaw))
        across = px * np.sin(yaw) - py * np.cos(yaw)
        angle: Array = np.abs(np.arctan2(across, along))
        return angle

    @cached_property
    def visible(self) -> Mask:
        """Whether each person sees the robot, shape (N + 1, n).

        Walls occlude the robot, if they are known.
        """
        visible: Mask = self.angle_of_view <= HALF_FIELD_OF_VIEW
        obstacles = self._recording.obstacles
        if len(obstacles):
            # Imported here, so that only worlds with walls load compiled code.
            from hunav_drake.systems.evaluation.curves import lines_blocked

            sample, person = np.nonzero(visible)
            lines = np.hstack(
                [
                    self._recording.humans[sample, person, : Y + 1],
                    self._recording.robot[sample, : Y + 1],
                ]
            )
            visible[sample, person] = ~lines_blocked(lines, obstacles.table)
        return visible

    @cached_property
    def seen_for(self) -> Array:
        """The time since the robot came into view, (N + 1, n), in seconds.

        Infinity for people who see the robot from their first sample on: when
        it came into view is unknown. It is meaningless where `visible` is
        false.
        """
        times = self._recording.times[:, None]
        since = np.full(self.visible.shape, -np.inf)
        there = ~np.isnan(self.distance)
        entered = self.visible[1:] & ~self.visible[:-1] & there[:-1]
        since[1:] = np.where(entered, times[1:], -np.inf)
        seen: Array = times - np.maximum.accumulate(since, axis=0)
        return seen
