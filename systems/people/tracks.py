"""Recorded people: the tracks of persons, smoothed and sampled anew."""

from collections.abc import Iterable
import dataclasses
from dataclasses import dataclass
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array

# The speed above which people look where they go, in m/s.
WALKING = 0.2

# Two rows of a person that are farther apart in time are two persons, in s.
LONGEST_GAP = 1.0

# With fewer rows, or less noise than this (in meters), a path is not smoothed.
_LEAST_ROWS = 5
_NO_NOISE = 1e-6

# Times that differ by less are the same, in seconds.
_SAME = 1e-9
# The shortest period of samples, in seconds.
_SHORTEST = 1e-3


class Track(NamedTuple):
    """The path of one person over time.

    Attributes:
        id: The number of the person.
        times: Shape (k,), ascending, in seconds.
        positions: Shape (k, 2), in W, in meters.
        yaws: Shape (k,), the headings in radians; None if they are not known.
    """

    id: int
    times: Array
    positions: Array
    yaws: Array | None = None


class Motion(NamedTuple):
    """The motion of a person at some instants.

    Attributes:
        positions: Shape (k, 2), in W, in meters.
        velocities: Shape (k, 2), in W, in m/s.
        yaws: Shape (k,), the heading: as recorded, or else the direction of the
            velocity above `WALKING`, and in between the last one before (the
            next one, at the beginning), in radians.
    """

    positions: Array
    velocities: Array
    yaws: Array


@dataclass(frozen=True, eq=False)
class Tracks:
    """The paths of recorded people.

    Attributes:
        people: A track per person, in the order of their numbers.
        walls: Outlines of walkable areas and obstacles that came with them,
            shape (k, 2) each, in W, in meters.
    """

    people: tuple[Track, ...]
    walls: tuple[Array, ...] = ()

    @classmethod
    def from_rows(
        cls,
        ids: ArrayLike,
        times: ArrayLike,
        positions: ArrayLike,
        yaws: ArrayLike | None = None,
        walls: Iterable[Array] = (),
    ) -> "Tracks":
        """Makes tracks from the rows of a table, in any order.

        Args:
            ids: Shape (n,), whole numbers.
            times: Shape (n,), in seconds.
            positions: Shape (n, 2), in meters.
            yaws: Shape (n,), in radians, NaN where not known; by default, none.
            walls: See `Tracks`.

        Raises:
            ValueError: If a person has two rows of one time.
        """
        number, time = np.asarray(ids), np.asarray(times, dtype=float)
        place = np.asarray(positions, dtype=float).reshape(-1, 2)
        yaw = None if yaws is None else np.asarray(yaws, dtype=float)
        order = np.lexsort([time, number])
        number, time, place = number[order], time[order], place[order]
        twice = (np.diff(number) == 0) & (np.diff(time) == 0)
        if twice.any():
            k = int(np.argmax(twice))
            raise ValueError(
                f"person {number[k]} has two rows at {time[k]:g} s; keep one"
            )
        starts = np.flatnonzero(np.diff(number, prepend=np.nan))
        ends = [*starts[1:], len(number)]
        people = []
        for start, end in zip(starts, ends, strict=True):
            own = slice(start, end)
            heading = None if yaw is None else yaw[order][own]
            if heading is not None and not np.isfinite(heading).all():
                heading = None
            people.append(
                Track(int(number[start]), time[own], place[own], heading)
            )
        return cls(tuple(people), tuple(walls))

    @property
    def period(self) -> float:
        """The most common time between two rows of a person, in seconds.

        NaN if nobody has two rows.
        """
        steps = [np.diff(it.times) for it in self.people if len(it.times) > 1]
        if not steps:
            return math.nan
        every = np.concatenate(steps)
        values, counts = np.unique(np.round(every, 6), return_counts=True)
        # (The mean, as 30 rows a second are not 0.033333 s apart.)
        usual = float(values[np.argmax(counts)])
        mean = float(every[np.abs(every - usual) < 2e-6].mean())
        # (Stamps have noise: the nearest simple period or rate.)
        rate = max(round(1 / mean, 3), 1e-3)
        near = min((usual, 1 / rate), key=lambda it: abs(it - mean))
        return round(near if abs(near - mean) < 5e-8 else mean, 12)

    def moved(
        self,
        *,
        rotate: float = 0.0,
        shift: tuple[float, float] = (0.0, 0.0),
        swap: bool = False,
        flip: bool = False,
    ) -> "Tracks":
        """Returns the tracks in another frame.

        Args:
            rotate: The angle to turn them by about the origin, in radians,
                counterclockwise.
            shift: The displacement after that, in meters.
            swap: Whether to exchange x and y first.
            flip: Whether to mirror y first, after `swap`.
        """
        c, s = math.cos(rotate), math.sin(rotate)

        def turned(points: Array) -> Array:
            x, y = points.T[::-1] if swap else points.T
            y = -y if flip else y
            result: Array = np.column_stack([c * x - s * y, s * x + c * y])
            return result

        def headings(yaws: Array | None) -> Array | None:
            if yaws is None:
                return None
            ahead = turned(np.column_stack([np.cos(yaws), np.sin(yaws)]))
            result: Array = np.arctan2(ahead[:, 1], ahead[:, 0])
            return result

        return Tracks(
            tuple(
                it._replace(
                    positions=turned(it.positions) + shift,
                    yaws=headings(it.yaws),
                )
                for it in self.people
            ),
            tuple(turned(wall) + shift for wall in self.walls),
        )

    def between(self, start: float, end: float = math.inf) -> "Tracks":
        """Returns the part of a time window.

        `start` becomes 0 s; times stay as they are if it is infinite.
        """
        shift = start if math.isfinite(start) else 0.0
        people = []
        for it in self.people:
            own = (it.times >= start) & (it.times <= end)
            if own.any():
                yaws = None if it.yaws is None else it.yaws[own]
                people.append(
                    Track(it.id, it.times[own] - shift, it.positions[own], yaws)
                )
        return dataclasses.replace(self, people=tuple(people))

    def split(self, gap: float = LONGEST_GAP) -> "Tracks":
        """Returns the tracks, cut where a person is missing for longer.

        The part before keeps the number; later parts get new ones, from the
        largest on.
        """
        people: list[Track] = []
        more: list[Track] = []
        following = max((it.id for it in self.people), default=0)
        for it in self.people:
            cuts = np.flatnonzero(np.diff(it.times) > gap * (1 + 1e-9)) + 1
            times = np.split(it.times, cuts)
            places = np.split(it.positions, cuts)
            yaws: list[Array | None] = (
                [None] * len(times)
                if it.yaws is None
                else list(np.split(it.yaws, cuts))
            )
            people.append(Track(it.id, times[0], places[0], yaws[0]))
            for part in zip(times[1:], places[1:], yaws[1:], strict=True):
                following += 1
                more.append(Track(following, *part))
        return dataclasses.replace(self, people=(*people, *more))

    @property
    def noise(self) -> float:
        """The estimated standard deviation of a coordinate, in meters.

        It is that of white noise with the observed third differences of rows at
        equal distances: a smooth path has next to none. 0 without such rows.
        """
        found = [np.zeros(0)]
        for it in self.people:
            third = np.diff(it.positions, 3, axis=0)
            even = np.abs(np.diff(it.times, 2)) < 1e-6
            found.append(np.abs(third[even[:-1] & even[1:]]).ravel())
        sizes = np.concatenate(found)
        # (The variance of a third difference is 1 + 9 + 9 + 1 times that of the
        # noise, and half of a normal distribution is within 0.6745 deviations.)
        scale = 0.6745 * math.sqrt(20.0)
        return float(np.median(sizes)) / scale if len(sizes) else 0.0

    def smoothed(self, sigma: float | None = None) -> "Tracks":
        """Returns the tracks with less noise.

        Each coordinate becomes the smoothest cubic spline that is as far from
        its rows as the noise, in the root mean square.

        Args:
            sigma: The standard deviation of a coordinate, in meters; by
                default, `noise`.
        """
        width = self.noise if sigma is None else sigma
        return dataclasses.replace(
            self, people=tuple(_smooth(it, width) for it in self.people)
        )

    def resampled(self, period: float) -> "Tracks":
        """Returns the tracks at the multiples of a period, in seconds.

        In between, people follow cubic splines. Who has no such instant is left
        out.

        Raises:
            ValueError: If the period is below a millisecond.
        """
        if not period >= _SHORTEST:
            raise ValueError(
                f"period: must be at least {_SHORTEST:g} s, got {period:g}"
            )
        people = []
        for it in self.people:
            first = math.ceil(it.times[0] / period - 1e-9)
            last = math.floor(it.times[-1] / period + 1e-9)
            times = np.arange(first, last + 1) * period
            if len(times):
                motion = motion_at(it, times)
                yaws = None if it.yaws is None else motion.yaws
                people.append(Track(it.id, times, motion.positions, yaws))
        return dataclasses.replace(self, people=tuple(people))


def motion_at(track: Track, times: ArrayLike) -> Motion:
    """Returns the motion of a person at some instants of the track.

    Before its beginning and after its end, it stands there.
    """
    # Imported here, so that reading a scenario does not load it.
    from scipy.interpolate import CubicSpline

    at = np.asarray(times, dtype=float)
    start, end = track.times[0], track.times[-1]
    inside = np.clip(at, start, end)
    if len(track.times) < 2:
        positions = np.repeat(track.positions, len(at), axis=0)
        velocities = np.zeros_like(positions)
    else:
        ends = "not-a-knot" if len(track.times) > 3 else "natural"
        path = CubicSpline(track.times, track.positions, bc_type=ends)
        positions, velocities = path(inside), path(inside, 1)
        velocities[(at < start - _SAME) | (at > end + _SAME)] = 0.0
    if track.yaws is not None:
        yaws = np.interp(inside, track.times, np.unwrap(track.yaws))
        return Motion(positions, velocities, _wrapped(yaws))
    walks = np.hypot(*velocities.T) > WALKING
    yaws = np.arctan2(velocities[:, 1], velocities[:, 0])
    if walks.any():
        last = np.maximum.accumulate(np.where(walks, np.arange(len(at)), -1))
        yaws = yaws[np.where(last < 0, np.argmax(walks), last)]
    else:
        yaws = np.zeros(len(at))
    return Motion(positions, velocities, yaws)


def _wrapped(angles: Array) -> Array:
    wrapped: Array = np.arctan2(np.sin(angles), np.cos(angles))
    return wrapped


def _smooth(track: Track, sigma: float) -> Track:
    from scipy.interpolate import UnivariateSpline

    times, places = track.times, track.positions
    if len(times) < _LEAST_ROWS or sigma < _NO_NOISE:
        return track
    weights = np.full(len(times), 1 / sigma)
    columns = [
        UnivariateSpline(times, column, w=weights, s=len(times))(times)
        for column in places.T
    ]
    return track._replace(positions=np.column_stack(columns))
