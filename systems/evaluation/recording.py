"""A recorded trial, as arrays: all that a metric is computed from."""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
import math
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hunav_drake.systems.common.layout import (
    RADIUS,
    STATE_FIELDS,
    STATE_SIZE,
    X,
    Y,
)
from hunav_drake.systems.common.suggest import did_you_mean
from hunav_drake.systems.evaluation import recording_file
from hunav_drake.systems.evaluation.encounter_features import EncounterFeatures
from hunav_drake.systems.evaluation.features import Features
from hunav_drake.systems.evaluation.path_features import PathFeatures
from hunav_drake.systems.world.obstacles import Obstacles

Array = NDArray[np.float64]

# How near to the goal's heading is at the goal where the goal has one and
# nothing else is told, in radians.
GOAL_YAW_TOLERANCE = 0.25

# No number in a recording is larger, in SI units: far beyond that, sums and
# powers of them are not finite.
LARGEST = 1e10

# The times of two samples are at least as far apart, in seconds: speeds and
# accelerations of less would not be finite.
SHORTEST_INTERVAL = 1e-20


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Recording:
    """What happened in a trial, at N + 1 instants, to a robot and n people.

    Everything is in SI units and radians, in the world frame W; the rows of
    states are those of `common.layout.STATE_FIELDS`. A recording
    does not change: its arrays are read-only, so copies share them.

    Attributes:
        times: Shape (N + 1,), strictly increasing, in seconds.
        robot: Shape (N + 1, 7), the robot's states.
        humans: Shape (N + 1, n, 7), the states of people. A row of NaN is a
            person who is missing at that instant.
        behavior_status: Shape (N + 1, n), integers: 0 where a person's
            behavior does not react to the robot. Zeros by default.
        human_names: n names, "human_1", ... by default.
        human_ids: n different integers, 1, ... by default.
        behaviors: The names of n behaviors, "regular" by default.
        group_ids: n integers, -1 (the default) for who walks alone.
        goal: The pose (x, y, yaw) that the robot was to reach, or None.
        goal_tolerance: How near to it is at the goal, in meters; HuNavSim's
            0.2 by default.
        goal_yaw_tolerance: The same for the heading, in radians. By default
            any heading will do.
        obstacles: The walls.
        walls_known: Whether `obstacles` are all walls. Recordings from
            elsewhere may not tell; what depends on walls has no value then.
        nearest_walls: Shape (N + 1, 1 + n, k, 2), for recordings from
            elsewhere: up to k nearest points of walls to the robot (row 0)
            and to each person, NaN where there are fewer. They stand in for
            `obstacles` where nothing but the nearest walls counts.
        reference_path: Shape (m, 3), rows (time, x, y) in seconds and meters,
            with times that increase: a path to compare the robot's with, on
            a clock of its own.

    Raises:
        ValueError: If an array has a wrong shape, a number is not finite or
            beyond `LARGEST`, or times do not increase.
    """

    times: Array
    robot: Array
    humans: Array
    behavior_status: NDArray[np.int64] | None = None
    human_names: tuple[str, ...] = ()
    human_ids: tuple[int, ...] = ()
    behaviors: tuple[str, ...] = ()
    group_ids: tuple[int, ...] = ()
    goal: tuple[float, float, float] | None = None
    goal_tolerance: float = 0.2
    goal_yaw_tolerance: float = math.pi
    obstacles: Obstacles = field(
        default_factory=lambda: Obstacles.from_points([])
    )
    walls_known: bool = True
    nearest_walls: Array | None = None
    reference_path: Array | None = None

    def __post_init__(self) -> None:
        times = _array("times", self.times, (None,))
        samples = len(times)
        if not samples:
            raise ValueError("recording.times: needs at least one sample")
        _check_increasing("times", times)
        robot = _array("robot", self.robot, (samples, STATE_SIZE))
        humans = _array("humans", self.humans, (samples, None, STATE_SIZE))
        n = humans.shape[1]
        _check_states(robot, humans)
        status = np.zeros((samples, n), dtype=np.int64)
        if self.behavior_status is not None:
            told = _array("behavior_status", self.behavior_status, (samples, n))
            _check_numbers("behavior_status", told, whole=True)
            status[:] = told
        nearest = self.nearest_walls
        if nearest is not None:
            nearest = _array(
                "nearest_walls", nearest, (samples, n + 1, None, 2)
            )
            _check_numbers(
                "nearest_walls", nearest[~np.isnan(nearest).all(axis=-1)]
            )
            nearest.setflags(write=False)
        reference = self.reference_path
        if reference is not None:
            reference = _checked_path(reference)
        for array in (times, robot, humans, status):
            array.setflags(write=False)
        ids = range(1, n + 1)
        self._set(
            times=times,
            robot=robot,
            humans=humans,
            behavior_status=status,
            nearest_walls=nearest,
            reference_path=reference,
            human_names=_per_human(
                "human_names", self.human_names, [f"human_{i}" for i in ids]
            ),
            human_ids=_per_human("human_ids", self.human_ids, list(ids)),
            behaviors=_per_human("behaviors", self.behaviors, ["regular"] * n),
            group_ids=_per_human("group_ids", self.group_ids, [-1] * n),
            goal=_checked_goal(self.goal),
        )
        for name in ("goal_tolerance", "goal_yaw_tolerance"):
            tolerance = float(_array(name, getattr(self, name), ()))
            if not 0 < tolerance <= LARGEST:
                raise ValueError(
                    f"recording.{name}: must be positive, and at most"
                    f" {LARGEST:g}, got {tolerance}"
                )
            self._set(**{name: tolerance})

    def _set(self, **values: Any) -> None:
        # The way of dataclasses themselves to fill in a frozen one.
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        """Returns the number of samples, N + 1."""
        return len(self.times)

    def __repr__(self) -> str:
        return (
            f"<Recording of {len(self)} samples from {self.times[0]:g} s to"
            f" {self.times[-1]:g} s, with {self.num_humans} people>"
        )

    @property
    def num_humans(self) -> int:
        """The number of people, n."""
        return int(self.humans.shape[1])

    @property
    def near_walls_known(self) -> bool:
        """Whether at least the walls near to everybody are known."""
        return self.walls_known or self.nearest_walls is not None

    @cached_property
    def features(self) -> Features:
        """Quantities that several metrics share, each computed once."""
        return Features(self)

    @cached_property
    def path_features(self) -> PathFeatures:
        """The same for the robot's path and the walls."""
        return PathFeatures(self)

    @cached_property
    def encounters(self) -> EncounterFeatures:
        """The same for the motion of robot and people to each other."""
        return EncounterFeatures(self)

    def compared_with(self, reference: "Recording") -> Self:
        """Returns the same trial, with the robot's path of another to compare.

        Args:
            reference: A trial whose robot went the way it should.
        """
        robot = reference.robot
        path = np.column_stack([reference.times, robot[:, X], robot[:, Y]])
        return replace(self, reference_path=path)

    def only(self, behavior: str) -> Self:
        """Returns the same trial with no one but the people of one behavior.

        Raises:
            ValueError: If nobody has that behavior.
        """
        chosen = [i for i, b in enumerate(self.behaviors) if b == behavior]
        if not chosen:
            raise ValueError(
                f"nobody in the recording has the behavior {behavior!r}"
                + did_you_mean(behavior, self.behaviors)
            )

        def pick(values: Sequence[Any]) -> tuple[Any, ...]:
            return tuple(values[i] for i in chosen)

        values = self._values()
        values |= {
            "humans": self.humans[:, chosen],
            "behavior_status": values["behavior_status"][:, chosen],
            "human_names": pick(self.human_names),
            "human_ids": pick(self.human_ids),
            "behaviors": pick(self.behaviors),
            "group_ids": pick(self.group_ids),
        }
        if self.nearest_walls is not None:
            rows = [0, *(1 + i for i in chosen)]
            values["nearest_walls"] = self.nearest_walls[:, rows]
        part = type(self)(**values)
        # What has nothing to do with people is not computed again.
        part.__dict__["way"] = self.path_features
        return part

    def save(self, path: str | Path) -> None:
        """Writes the recording to one .npz file, in one piece or not at all.

        Raises:
            OSError: If the file cannot be written.
        """
        recording_file.write(path, self._values())

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Reads a recording that `save` has written.

        Raises:
            OSError: If the file cannot be read.
            ValueError: If the file is not a recording.
        """
        values = recording_file.read(path)
        try:
            return cls(**values)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error

    def _values(self) -> dict[str, Any]:
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def __eq__(self, other: object) -> bool:
        """Tells whether two recordings have the same content."""
        if not isinstance(other, Recording):
            return NotImplemented
        return all(
            _same(a, b)
            for a, b in zip(
                self._values().values(), other._values().values(), strict=True
            )
        )

    # Equal content, yet large: recordings are not meant for dictionaries.
    __hash__ = None  # type: ignore[assignment]

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: Any) -> Self:
        # Nothing in it can change, and Drake copies values at every turn.
        return self

    def __reduce__(self) -> Any:
        # The derived quantities stay behind: they are larger than the rest.
        return _restore, (type(self), self._values())


def _restore(cls: type[Recording], values: dict[str, Any]) -> Recording:
    return cls(**values)


def _array(name: str, value: ArrayLike, shape: tuple[int | None, ...]) -> Array:
    """Returns a copy of an array, after a check of its shape."""
    try:
        if np.iscomplexobj(value):
            raise TypeError("it has complex numbers")
        array = np.array(value, dtype=float, order="C")
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"recording.{name}: is not an array: {error}"
        ) from None
    if len(array.shape) != len(shape) or any(
        want not in (None, got)
        for want, got in zip(shape, array.shape, strict=True)
    ):
        wanted = ", ".join("any" if s is None else str(s) for s in shape)
        raise ValueError(
            f"recording.{name}: must have the shape ({wanted}), got"
            f" {array.shape}"
        )
    return array


def _checked_path(path: ArrayLike) -> Array:
    array = _array("reference_path", path, (None, 3))
    if not len(array):
        raise ValueError("recording.reference_path: must have rows")
    _check_numbers("reference_path", array)
    _check_increasing("reference_path: its times", array[:, 0])
    array.setflags(write=False)
    return array


def _check_numbers(name: str, array: Array, *, whole: bool = False) -> None:
    good = np.abs(array) <= LARGEST
    if whole:
        good &= array == np.trunc(array)
    if not good.all():
        raise ValueError(
            f"recording.{name}: must be finite, {'whole, ' if whole else ''}"
            f"and at most {LARGEST:g} in size, got"
            f" {array[tuple(np.argwhere(~good)[0])]}"
        )


def _check_increasing(name: str, times: Array) -> None:
    _check_numbers(name, times)
    late = np.flatnonzero(np.diff(times) < SHORTEST_INTERVAL)
    if late.size:
        k = int(late[0])
        raise ValueError(
            f"recording.{name}: must increase strictly, by at least"
            f" {SHORTEST_INTERVAL:g} s, but sample {k + 1} at {times[k + 1]} s"
            f" follows sample {k} at {times[k]} s"
        )


def _check_states(robot: Array, humans: Array) -> None:
    low = np.full(STATE_SIZE, -LARGEST)
    low[RADIUS] = 0
    states = np.concatenate([robot[:, None], humans], axis=1)
    missing = np.isnan(states).all(axis=2)
    missing[:, 0] = False
    bad = ~((low <= states) & (states <= LARGEST)) & ~missing[..., None]
    if bad.any():
        k, i, column = np.argwhere(bad)[0].tolist()
        who = f"humans: person {i - 1}" if i else "robot: it"
        raise ValueError(
            f"recording.{who} at sample {k}: {STATE_FIELDS[column]} must be"
            f" finite, in [{low[column]:g}, {LARGEST:g}], got"
            f" {states[k, i, column]}"
            + ("; a missing person has a row of NaN" if i else "")
        )


def _per_human(name: str, values: Sequence[Any], default: list[Any]) -> Any:
    try:
        values = tuple(values)
    except TypeError as error:
        raise ValueError(f"recording.{name}: is no list: {error}") from error
    if not values:
        return tuple(default)
    if len(values) != len(default):
        raise ValueError(
            f"recording.{name}: needs one for each of {len(default)} people,"
            f" got {len(values)}"
        )
    if isinstance(default[0], str):
        return tuple(map(str, values))
    numbers = _array(name, values, (len(values),))
    _check_numbers(name, numbers, whole=True)
    if name == "human_ids" and len(set(values)) != len(values):
        raise ValueError(f"recording.human_ids: must differ, got {values}")
    return tuple(map(int, values))


def _checked_goal(goal: Any) -> tuple[float, float, float] | None:
    if goal is None:
        return None
    array = _array("goal", goal, (3,))
    _check_numbers("goal", array)
    x, y, yaw = array.tolist()
    return x, y, yaw


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, Obstacles) and isinstance(b, Obstacles):
        return all(
            np.array_equal(getattr(a, f.name), getattr(b, f.name))
            for f in fields(Obstacles)
        )
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return np.array_equal(a, b, equal_nan=True)
    return bool(type(a) is type(b) and a == b)
