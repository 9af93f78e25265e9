"""A recorded trial as arrays: the input of metrics."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
import math
from pathlib import Path
from typing import Any, Self

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import WHO, Contact, X, Y
from hunav_drake.systems.common.suggest import did_you_mean
from hunav_drake.systems.evaluation import recording_file
from hunav_drake.systems.evaluation.encounter_features import EncounterFeatures
from hunav_drake.systems.evaluation.features import Features
from hunav_drake.systems.evaluation.path_features import PathFeatures
from hunav_drake.systems.evaluation.recorded_arrays import RecordedArrays
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.names import people_ids, people_names

# The default yaw tolerance of a goal with a heading, in radians.
GOAL_YAW_TOLERANCE = 0.25


# The fields with a row per sample.
_PER_SAMPLE = (
    *("times", "robot", "humans", "behavior_status", "nearest_walls"),
    *("contacts", "wall_contact", "told_velocities", "replay"),
    "social_signals",
)


def _with_rows(signals: Array, rows: Sequence[int]) -> Array:
    """Returns signals, (..., 22), in which only some row codes are left.

    These become 0, 1, ... in order; others become -1, for nobody.
    """
    told = signals[..., WHO].astype(np.int64)
    codes = np.full(max(int(told.max(initial=0)), *rows) + 1, -1)
    codes[rows] = np.arange(len(rows))
    result = signals.copy()
    result[..., WHO] = np.where(told < 0, told, codes[told])
    return result


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Recording(RecordedArrays):
    """The record of a trial with a robot and n people at N + 1 instants.

    All values are in SI units and radians, in the world frame W; the rows of
    states are those of `common.layout.STATE_FIELDS`. A recording is immutable:
    its arrays are read-only, so copies share them.

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
        group_ids: n integers, -1 (the default) for people without a group.
        goal: The goal pose (x, y, yaw) of the robot, or None.
        goal_tolerance: The distance at which the goal counts as reached, in
            meters; by default HuNavSim's 0.2.
        goal_yaw_tolerance: The same for the heading, in radians. By default any
            heading counts.
        robot_max_speed: The maximum speed of the robot, in m/s; None if it is
            unknown, as in external recordings.
        obstacles: The walls.
        walls_known: Whether `obstacles` are all walls. External recordings may
            not have them; metrics that depend on walls have no value then.
        nearest_walls: Shape (N + 1, 1 + n, k, 2), for external recordings: up
            to k nearest points of walls to the robot (row 0) and to each
            person, NaN where there are fewer. They replace `obstacles` where
            only the nearest walls count.
        reference_path: Shape (m, 3), rows (time, x, y) in seconds and meters,
            with increasing times on a separate clock: a path to compare the
            robot's path with.
        contacts: Shape (N + 1, n, 8), rows of `layout.Contact`: the contacts of
            the robot with each person, from the system that moves the robot.
            None if they are unknown, as in external recordings.
        wall_contact: Shape (N + 1, 8), such rows for all walls together. None
            if they are unknown.
        contact_forces_known: Whether contact forces are computed, as for a
            robot that is a body of a plant; otherwise they are 0.
        hunavsim_forces: Whether force metrics are computed as in HuNavSim's
            evaluator: see `EvaluatorConfig.forces`.
        told_velocities: Shape (N + 1, 1 + n, 2), for recordings of HuNavSim's
            messages, whose speeds and velocities disagree: the velocities (vx,
            vy) of the robot (row 0) and of each person, NaN for missing ones.
            HuNavSim's forces use them.
        replay: Shape (N + 1, n, 3), the rows of `layout.REPLAY_SIZE`; None
            without recorded people.
        social_signals: Shape (N + 1, n, 22), the rows of `layout.Signal`: what
            people have shown in the step before; None if nobody's behavior
            tree has social leaves.
        doors: Shape (k, 2), the centers of doors, in meters; None if none is
            known, as in external recordings.
        robot_name: The name of one of several robots; empty for a single one.
        end_time: When one of several robots ended, in seconds; None if it did
            not.
        others: The recordings of the other robots, with the same times and
            people.

    Raises:
        ValueError: If an array has a wrong shape, a number is not finite or
            beyond `LARGEST`, or times do not increase.
    """

    def __repr__(self) -> str:
        return (
            f"<Recording of {len(self)} samples from"
            f" {self.times[0]:.12g} s to {self.times[-1]:.12g} s, with"
            f" {self.num_humans} people"
            + (f" and {len(self.robots)} robots>" if self.others else ">")
        )

    @cached_property
    def features(self) -> Features:
        """Features that several metrics share, each computed once."""
        return Features(self)

    @cached_property
    def path_features(self) -> PathFeatures:
        """Features of the robot's path and the walls."""
        return PathFeatures(self, self.features)

    @cached_property
    def encounters(self) -> EncounterFeatures:
        """Features of the relative motion of robot and people."""
        return EncounterFeatures(self)

    @property
    def robots(self) -> "tuple[Recording, ...]":
        """The recording of each robot alone, over all times."""
        if not self.others:
            return (self,)
        return (replace(self, others=()), *self.others)

    @property
    def period(self) -> float:
        """The longest time between two samples, in seconds."""
        return float(np.diff(self.times).max(initial=0.0))

    def until_end(self) -> Self:
        """Returns the recording of one of several robots until its end.

        Its last sample is the first one at that time or later.
        """
        if self.end_time is None:
            return self
        return self.until(self.end_time)

    def until(self, time: float) -> Self:
        """Returns the recording until the first sample at a time or later.

        Raises:
            ValueError: If the time is NaN.
        """
        if math.isnan(time):
            raise ValueError("time must be in seconds, got nan")
        last = np.searchsorted(self.times, time - 1e-12 * abs(time))
        return self._part(slice(0, int(last) + 1))

    def since(self, time: float) -> Self:
        """Returns the recording from a time on, in seconds.

        Raises:
            ValueError: If it has no sample since then.
        """
        first = int(np.searchsorted(self.times, time - 1e-9))
        if first == len(self):
            raise ValueError(
                f"nothing is recorded since {time:g} s: the recording ends at"
                f" {self.times[-1]:g} s"
            )
        return self._part(slice(first, len(self)))

    def _part(self, samples: slice) -> Self:
        """Returns the recording of some samples."""
        if len(self.times[samples]) == len(self):
            return self
        values = self._values()
        for name in _PER_SAMPLE:
            if values[name] is not None:
                values[name] = values[name][samples]
        values["others"] = tuple(it._part(samples) for it in self.others)
        return type(self)(**values)

    def compared_with(self, reference: "Recording") -> Self:
        """Returns the same trial with another's robot path as reference.

        Of several robots, each gets the path of the one of its name, until its
        end.

        Raises:
            ValueError: If the reference has other robots.
        """
        names = [it.robot_name or "robot" for it in self.robots]
        given = {
            it.robot_name or "robot": it.until_end() for it in reference.robots
        }
        if not (self.others or reference.others):
            given = dict.fromkeys(names, reference.until_end())
        if not given.keys() >= {*names}:
            raise ValueError(
                "the reference must have the robots of the recording,"
                f" {', '.join(map(repr, names))}; it has"
                f" {', '.join(map(repr, given))}"
            )
        paths = [
            np.column_stack([it.times, it.robot[:, [X, Y]]])
            for it in (given[name] for name in names)
        ]
        others = (
            replace(it, reference_path=path)
            for it, path in zip(self.others, paths[1:], strict=True)
        )
        return replace(self, reference_path=paths[0], others=tuple(others))

    def only(self, behavior: str) -> Self:
        """Returns the same trial with only the people of one behavior.

        Raises:
            ValueError: If nobody has that behavior.
        """
        chosen = [i for i, b in enumerate(self.behaviors) if b == behavior]
        if not chosen:
            raise ValueError(
                f"nobody in the recording has the behavior {behavior!r}"
                + did_you_mean(behavior, self.behaviors)
            )

        values = self._values()
        for name in ("humans", "behavior_status"):
            values[name] = values[name][:, chosen]
        for name in ("human_names", "human_ids", "behaviors", "group_ids"):
            values[name] = tuple(values[name][i] for i in chosen)
        for name in ("contacts", "replay", "social_signals"):
            if values[name] is not None:
                values[name] = values[name][:, chosen]
        if values["social_signals"] is not None:
            robots = [self.num_humans + k for k in range(len(self.robots))]
            values["social_signals"] = _with_rows(
                values["social_signals"], [*chosen, *robots]
            )
        rows = [0, *(1 + i for i in chosen)]
        for name in ("nearest_walls", "told_velocities"):
            if values[name] is not None:
                values[name] = values[name][:, rows]
        values["others"] = tuple(it.only(behavior) for it in self.others)
        part = type(self)(**values)
        # These do not depend on people, so they are not computed again.
        part.__dict__["path_features"] = self.path_features
        return part

    def with_stale_samples(self, count: int, period: float) -> Self:
        """Returns the same trial with its last sample repeated `count` times.

        `period` is the time between them, in seconds.
        """
        if count == 0:
            return self
        values = self._values()
        later = self.times[-1] + period * np.arange(1, count + 1)
        values["times"] = np.concatenate([self.times, later])
        values["others"] = tuple(
            it.with_stale_samples(count, period) for it in self.others
        )
        for name in _PER_SAMPLE[1:]:
            rows = values[name]
            if rows is not None:
                stale = np.repeat(rows[-1:], count, axis=0)
                if "contact" in name:
                    # No step ends there. (Counts and sums do not change.)
                    stale[..., Contact.FORCE_X : Contact.FORCE_Y + 1] = 0.0
                values[name] = np.concatenate([rows, stale])
        return type(self)(**values)

    def save(self, path: str | Path) -> None:
        """Writes the recording to one .npz file, atomically.

        Raises:
            OSError: If the file cannot be written.
        """
        recording_file.write(path, self._values())

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Reads a recording written by `save`.

        Raises:
            OSError: If the file cannot be read.
            ValueError: If the file is not a recording.
        """
        values = recording_file.read(path)
        try:
            values["others"] = tuple(cls(**it) for it in values["others"])
            return cls(**values)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error

    def _values(self) -> dict[str, Any]:
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def __eq__(self, other: object) -> bool:
        """Returns whether two recordings have the same content."""
        if not isinstance(other, Recording):
            return NotImplemented
        return all(
            _same(a, b)
            for a, b in zip(
                self._values().values(), other._values().values(), strict=True
            )
        )

    # Recordings are large and compared by content, so they are not hashable.
    __hash__ = None  # type: ignore[assignment]

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: Any) -> Self:
        # It is immutable, and Drake copies values often.
        return self

    def __reduce__(self) -> Any:
        # Without the cached features, which are larger than the rest.
        return _restore, (type(self), self._values())


def describe_people(humans: Sequence[HumanConfig]) -> dict[str, Any]:
    """Returns the constant data of people in a Recording."""
    return {
        "human_names": tuple(people_names(humans)),
        "human_ids": tuple(people_ids(humans)),
        "behaviors": tuple(h.behavior_name for h in humans),
        "group_ids": tuple(h.group_id for h in humans),
    }


def _restore(cls: type[Recording], values: dict[str, Any]) -> Recording:
    return cls(**values)


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return np.array_equal(a, b, equal_nan=True)
    return bool(type(a) is type(b) and a == b)
