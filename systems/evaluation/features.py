"""Features that several metrics share, computed once per recording."""

from functools import cached_property

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import OMEGA, RADIUS, VX, VY, YAW, X, Y
from hunav_drake.systems.common.poses import is_at_goal, wrap_angles
from hunav_drake.systems.crowd.social_force.numpy_forces import (
    hunavsim_pair_force,
    obstacle_force,
    pair_force,
)
from hunav_drake.systems.evaluation.recorded_arrays import RecordedArrays
from hunav_drake.systems.people.parameters import SocialForceParameters
from hunav_drake.systems.world.obstacles import nearest_points

# Bodies closer than this are in contact, in meters.
CONTACT_GAP = 0.02

# Samples closer in time than this give no acceleration, in seconds: their
# stamps are equal except for rounding.
LEAST_INTERVAL = 1e-6

# The distance of a group's common point of interest ahead of each member, in
# meters.
INTERACTION_DISTANCE = 1.5

# The constants of force metrics: those of the library of HuNavSim's metrics,
# which differ from those of its crowd.
FORCES = SocialForceParameters(social_factor=2.1, epsilon=0.0)

# The number of bodies whose forces are computed at once; they fit the cache.
_BLOCK = 8192


def surface_gaps(robot: Array, humans: Array) -> Array:
    """Returns the gaps (..., n) between discs of robots and people, in meters.

    They are 0 where discs overlap, and NaN for missing people.
    """
    dx = humans[..., X] - robot[..., None, X]
    dy = humans[..., Y] - robot[..., None, Y]
    radii = humans[..., RADIUS] + robot[..., None, RADIUS]
    gaps: Array = np.maximum(np.hypot(dx, dy) - radii, 0.0)
    return gaps


def mean_of_present(values: Array) -> Array:
    """Returns the mean over the last axis, without NaN.

    It is NaN where there are no values.
    """
    present = ~np.isnan(values)
    count = present.sum(axis=-1)
    total = np.where(present, values, 0.0).sum(axis=-1)
    mean: Array = np.where(count > 0, total, np.nan) / np.maximum(count, 1)
    return mean


class Features:
    """Features of a recording of N + 1 samples and n people.

    `Recording.features` holds it. Each property is computed at its first
    access. NaN means no value: a missing person, no goal, no group.
    """

    def __init__(self, recording: RecordedArrays) -> None:
        self._recording = recording

    @cached_property
    def intervals(self) -> Array:
        """The times between samples, shape (N,), in seconds."""
        return np.diff(self._recording.times)

    @cached_property
    def step_lengths(self) -> Array:
        """The distances between samples, shape (N,), in meters."""
        steps = np.diff(self._recording.robot[:, : Y + 1], axis=0)
        lengths: Array = np.hypot(steps[:, X], steps[:, Y])
        return lengths

    @cached_property
    def heading_changes(self) -> Array:
        """The turns between samples, shape (N,), in radians, unsigned."""
        return np.abs(wrap_angles(np.diff(self._recording.robot[:, YAW])))

    @cached_property
    def forward_speed(self) -> Array:
        """The robot's speed along its heading, shape (N + 1,), in m/s."""
        robot = self._recording.robot
        speed: Array = robot[:, VX] * np.cos(robot[:, YAW]) + robot[
            :, VY
        ] * np.sin(robot[:, YAW])
        return speed

    @cached_property
    def turn_rate(self) -> Array:
        """The robot's turn rate, shape (N + 1,), in rad/s, unsigned."""
        return np.abs(self._recording.robot[:, OMEGA])

    @cached_property
    def acceleration(self) -> Array:
        """The change of the forward speed, shape (N,), in m/s^2.

        NaN for intervals shorter than `LEAST_INTERVAL`.
        """
        dt = np.where(self.intervals < LEAST_INTERVAL, np.nan, self.intervals)
        change: Array = np.diff(self.forward_speed) / dt
        return change

    @cached_property
    def goal_distance(self) -> Array:
        """The robot's distance to the goal, shape (N + 1,), in meters."""
        goal = self._recording.goal
        robot = self._recording.robot
        if goal is None:
            return np.full(len(robot), np.nan)
        distance: Array = np.hypot(robot[:, X] - goal[0], robot[:, Y] - goal[1])
        return distance

    @cached_property
    def at_goal(self) -> Mask:
        """Whether the robot is at the goal pose, shape (N + 1,)."""
        recording = self._recording
        if recording.goal is None:
            return np.zeros(len(recording), dtype=np.bool_)
        robot = recording.robot
        return np.asarray(
            is_at_goal(
                (robot[:, X], robot[:, Y], robot[:, YAW]),
                recording.goal,
                tolerance=recording.goal_tolerance,
                yaw_tolerance=recording.goal_yaw_tolerance,
            )
        )

    @cached_property
    def present(self) -> Mask:
        """Whether each person is present, shape (N + 1, n)."""
        return ~np.isnan(self._recording.humans[..., X])

    @cached_property
    def gaps(self) -> Array:
        """The gaps between robot and people, shape (N + 1, n), in meters."""
        return surface_gaps(self._recording.robot, self._recording.humans)

    @cached_property
    def closest_gap(self) -> Array:
        """The smallest of the gaps, shape (N + 1,), in meters."""
        closest: Array = np.fmin.reduce(self.gaps, axis=1, initial=np.nan)
        return closest

    @cached_property
    def human_speed(self) -> Array:
        """The speeds of people, shape (N + 1, n), in m/s."""
        humans = self._recording.humans
        speed: Array = np.hypot(humans[..., VX], humans[..., VY])
        return speed

    @cached_property
    def closest_human_speed(self) -> Array:
        """The speed of the person with the closest center, (N + 1,), in m/s."""
        recording = self._recording
        if not recording.num_humans:
            return np.full(len(recording), np.nan)
        offset = (
            recording.humans[..., : Y + 1] - recording.robot[:, None, : Y + 1]
        )
        distance2 = offset[..., X] ** 2 + offset[..., Y] ** 2
        closest = np.where(self.present, distance2, np.inf).argmin(axis=1)
        speed: Array = np.take_along_axis(
            self.human_speed, closest[:, None], axis=1
        )[:, 0]
        return speed

    @cached_property
    def group_gap(self) -> Array:
        """The gap to the closest group's center, shape (N + 1,), in meters.

        A group is two or more present people with the same id. Its interaction
        center is the mean of the points 1.5 m ahead of them.
        """
        recording = self._recording
        humans, robot = recording.humans, recording.robot
        ids = np.array(recording.group_ids, dtype=int)
        gap = np.full(len(recording), np.nan)
        for group in np.unique(ids[ids >= 0]):
            members = humans[:, ids == group]
            count = (~np.isnan(members[..., X])).sum(axis=1)
            ahead = INTERACTION_DISTANCE
            x = members[..., X] + ahead * np.cos(members[..., YAW])
            y = members[..., Y] + ahead * np.sin(members[..., YAW])
            distance = np.hypot(
                mean_of_present(x) - robot[:, X],
                mean_of_present(y) - robot[:, Y],
            )
            to_group = np.maximum(distance - robot[:, RADIUS], 0.0)
            gap = np.fmin(gap, np.where(count >= 2, to_group, np.nan))
        return gap

    @cached_property
    def contact(self) -> Mask:
        """Whether each person touches the robot, shape (N + 1, n)."""
        touching: Mask = self.gaps < CONTACT_GAP
        return touching

    @cached_property
    def contact_begins(self) -> Mask:
        """Whether a contact begins, shape (N + 1, n); also at the start."""
        begins = self.contact.copy()
        begins[1:] &= ~self.contact[:-1]
        return begins

    @cached_property
    def social_force(self) -> Array:
        """The social force between the robot and each person, in m/s^2.

        Its magnitude, shape (N + 1, n): equal on both, since the law is
        antisymmetric. 0 for missing people.
        """
        sample, person = np.nonzero(self.present)
        humans = self._recording.humans[sample, person]
        robot = self._recording.robot[sample]
        force = np.zeros(self.present.shape)
        law = pair_force
        moving = humans[:, VX : VY + 1] - robot[:, VX : VY + 1]
        if self._recording.hunavsim_forces:
            law = hunavsim_pair_force
            told = self._recording.told_velocities
            if told is not None:
                moving = told[sample, 1 + person] - told[sample, 0]
        for part in _blocks(len(sample)):
            dx, dy = (robot[part, i] - humans[part, i] for i in (X, Y))
            dvx, dvy = moving[part].T
            length = np.hypot(*law(dx, dy, dvx, dvy, FORCES))
            force[sample[part], person[part]] = length
        return force

    @cached_property
    def obstacle_force_on_robot(self) -> Array:
        """The force of the walls on the robot, shape (N + 1,), in m/s^2.

        NaN if the walls are not known; 0 as in HuNavSim's evaluator, which does
        not get them.
        """
        if self._recording.hunavsim_forces:
            return np.zeros(len(self._recording))
        given = self._recording.nearest_walls
        points = None if given is None else given[:, 0]
        return self._obstacle_force(self._recording.robot, points)

    @cached_property
    def obstacle_force_on_humans(self) -> Array:
        """The force of the walls on people, shape (N + 1, n), in m/s^2.

        NaN for missing people, and if the walls are not known.
        """
        given = self._recording.nearest_walls
        points = None if given is None else given[:, 1:][self.present]
        force = np.full(self.present.shape, np.nan)
        force[self.present] = self._obstacle_force(
            self._recording.humans[self.present], points
        )
        return force

    def _obstacle_force(self, bodies: Array, points: Array | None) -> Array:
        """Returns the magnitudes of the forces on m bodies, shape (m,)."""
        obstacles = self._recording.obstacles
        if not self._recording.near_walls_known:
            return np.full(len(bodies), np.nan)
        if points is None and not len(obstacles):
            return np.zeros(len(bodies))
        results = []
        for part in _blocks(len(bodies)):
            p = bodies[part, : Y + 1]
            walls = (
                nearest_points(obstacles, p) if points is None else points[part]
            )
            radius = bodies[part, RADIUS, None]
            dx, dy = (p[:, None] - walls).transpose(2, 0, 1)
            force = np.stack(obstacle_force(dx, dy, radius, FORCES), axis=-1)
            results.append(np.hypot(*np.nan_to_num(force, nan=0).sum(axis=1).T))
        return np.concatenate(results)


def _blocks(size: int) -> list[slice]:
    """Returns slices that cover `size` items; at least one slice."""
    return [slice(i, i + _BLOCK) for i in range(0, max(size, 1), _BLOCK)]
