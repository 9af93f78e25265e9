"""When exactly a robot came near people, crossed their ways, cut groups."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
import itertools
import math
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import Y
from hunav_drake.systems.evaluation.chords import (
    chords_within,
    nearest_on_chords,
)
from hunav_drake.systems.evaluation.metric import ENCOUNTERS_FAMILY, LEAST_GAP
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.situation_labels import MOVING
from hunav_drake.systems.evaluation.situations import robot_of

if TYPE_CHECKING:
    import pandas as pd
else:
    import lazy_loader

    pd = lazy_loader.load("pandas")

ZONES: Mapping[str, float] = MappingProxyType(
    {
        "touch": 0.0,
        "contact": 0.02,
        "intimate": 0.45,
        "personal": 1.2,
        "social": 3.6,
    }
)
"""The zones by their names: the largest gap between the discs of robot and
person, in meters. (Hall 1966 for the last three.)"""

# What is measured, besides times in zones and entries to them, and its unit.
_VALUES = {
    "first_contact_time": "s",
    LEAST_GAP: "m",
    "crossings_in_front": "-",
    "groups_cut": "-",
    "contacts_charged": "-",
}

_COLUMNS = (
    *("time", "kind", "zone", "person", "gap", "robot_speed", "person_speed"),
    *("fault", "share"),
)

# The fault is that of both where their speeds differ by less, in m/s.
_SAME_SPEED = 1e-6

# A robot is on a line, and on neither side of it, up to here, in meters.
_ON_LINE = 1e-9


class _Chords(NamedTuple):
    """The motions between samples, of shape (K, n, 2) but for times.

    Attributes:
        times: The times at which they begin, (K, 1), in seconds.
        lasts: How long they last, (K, 1), in seconds.
        first: The place of each person relative to the robot at the begin.
        last: The same at the end.
        reach: The sum of the radii, (K, n), in meters.
        robot: How far the robot moves.
        people: How far each person moves.
    """

    times: Array
    lasts: Array
    first: Array
    last: Array
    reach: Array
    robot: Array
    people: Array


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Encounters:
    """The encounters of a robot with n people.

    Between two samples, bodies move on straight lines. So they do in a trial
    whose samples are its steps: then instants are exact (a robot on an arc is
    off by less than a millimeter). With samples less often, they are as exact
    as the straight lines are.

    Attributes:
        recording: The recording of this robot, until its end.
        zones: The zones: see `ZONES`.
    """

    recording: Recording
    zones: Mapping[str, float]

    def __repr__(self) -> str:
        return f"<Encounters in the {repr(self.recording)[1:]}"

    @property
    def period(self) -> float:
        """The longest time between two samples, in seconds."""
        return self.recording.period

    def events(self) -> "pd.DataFrame":
        """Returns what happened, in the order of time.

        Returns:
            A row per event: "time", in seconds; "kind": "entry" to a "zone",
            "exit" from it, "crossing" in front of a walking person within the
            largest zone, and "cut" through the line between two members of a
            group; "person", of a cut both; "gap", in meters; and of entries the
            speeds "robot_speed" and "person_speed" at which they approach each
            other, in m/s, whose "fault" it is (the faster one's: "robot",
            "person" or "both"), and the robot's "share" of the speed. A person
            who is in a zone at the first sample, or appears in it, has not
            entered it.
        """
        return pd.DataFrame(self.event_rows(), columns=_COLUMNS)

    def event_rows(self) -> list[dict[str, Any]]:
        """Returns the rows of `events`, without the cells of NaN."""
        rows = [*self._passages(), *self._crossings(), *self._cuts()]
        return sorted(rows, key=lambda row: row["time"])

    def people(self) -> "pd.DataFrame":
        """Returns a summary for each person.

        Returns:
            A row per person: "time_in_<zone>", in seconds, and
            "entries_<zone>" of each zone; "min_gap_exact", in meters, negative
            for overlaps, at "min_gap_time", in seconds; and
            "crossings_in_front". NaN for who is never there.
        """
        names = pd.Index(self.recording.human_names, name="person")
        return pd.DataFrame(dict(self.by_person), index=names)

    @cached_property
    def by_person(self) -> Mapping[str, NDArray[Any]]:
        """The columns of `people`, of shape (n,), by their names."""
        data: dict[str, NDArray[Any]] = {}
        for zone in self.zones:
            begin, end = self._inside[zone]
            lasts = (end - begin) * self._chords.lasts
            data[f"time_in_{zone}"] = np.nansum(lasts, axis=0)
            data[f"entries_{zone}"] = (begin > 0).sum(axis=0)
        gaps, times = self._nearest
        data[LEAST_GAP], data["min_gap_time"] = gaps, times
        data["crossings_in_front"] = self._crosses[0].sum(axis=0)
        return MappingProxyType(data)

    def values(self) -> dict[str, tuple[float, str]]:
        """Returns the values for all people together, with their units.

        "time_in_<zone>" is the time with anybody in it, and "entries_<zone>"
        the number of all entries; "first_contact_time" is the first instant
        in the smallest zone that is larger than a touch (NaN for never), and
        "contacts_charged" counts the entries to a gap of 0 whose fault is not
        that of the person, whatever the zones.
        """
        found: dict[str, tuple[float, str]] = {}
        for zone in self.zones:
            begin, end = self._inside[zone]
            spans = [
                self._chords.times + it * self._chords.lasts
                for it in (begin, end)
            ]
            found[f"time_in_{zone}"] = _length_of_union(*spans), "s"
            found[f"entries_{zone}"] = float((begin > 0).sum()), "-"
        near = min(filter(None, self.zones.values()), default=math.nan)
        begin, _ = chords_within(*self._chords[2:4], self._chords.reach + near)
        times = self._chords.times + begin * self._chords.lasts
        alone = np.nonzero(self._alone <= near)[0]
        times = np.append(times, self.recording.times[alone])
        numbers = (
            np.fmin.reduce(times, initial=np.nan),
            np.fmin.reduce(self._nearest[0], initial=np.nan),
            self._crosses[0].sum(),
            len(list(self._cuts())),
            self._charged(),
        )
        for (name, unit), value in zip(_VALUES.items(), numbers, strict=True):
            found[name] = float(value), unit
        return found

    @cached_property
    def _chords(self) -> _Chords:
        run = self.recording
        robot = run.robot[:, None, : Y + 1]
        people = run.humans[..., : Y + 1]
        away = people - robot
        return _Chords(
            run.times[:-1, None],
            np.diff(run.times)[:, None],
            *(away[:-1], away[1:], run.encounters.reach[:-1]),
            *(np.diff(robot, axis=0), np.diff(people, axis=0)),
        )

    @cached_property
    def _alone(self) -> Array:
        """The gaps at samples without motions before and after, (N, n).

        They are infinite at all others.
        """
        run = self.recording
        away = run.humans[..., : Y + 1] - run.robot[:, None, : Y + 1]
        gaps = np.hypot(*np.moveaxis(away, -1, 0)) - run.encounters.reach
        here = np.isfinite(gaps)
        beside = np.pad(here[1:] & here[:-1], ((1, 1), (0, 0)))
        alone = here & ~beside[1:] & ~beside[:-1]
        return np.where(alone, gaps, np.inf)

    @cached_property
    def _inside(self) -> dict[str, tuple[Array, Array]]:
        """By zone, the part of each motion in it: see `chords_within`."""
        _, _, first, last, reach, *_ = self._chords
        return {
            zone: chords_within(first, last, reach + gap)
            for zone, gap in self.zones.items()
        }

    @cached_property
    def _nearest(self) -> tuple[Array, Array]:
        """The least gap to each person in meters, and when, (n,)."""
        it = self._chords
        u, away = nearest_on_chords(it.first, it.last)
        gaps = np.where(np.isnan(away), np.inf, away - it.reach)
        gaps = np.vstack([gaps, self._alone])
        moments = np.repeat(self.recording.times[:, None], u.shape[1], axis=1)
        times = np.vstack([it.times + u * it.lasts, moments])
        k, people = gaps.argmin(axis=0), np.arange(gaps.shape[1])
        least = gaps[k, people]
        known = np.isfinite(least)
        return (
            np.where(known, least, np.nan),
            np.where(known, times[k, people], np.nan),
        )

    def _passages(self) -> Iterator[dict[str, Any]]:
        for zone, gap in self.zones.items():
            begin, end = self._inside[zone]
            for k, i in np.argwhere((begin > 0) | (end < 1)).tolist():
                if begin[k, i] > 0:
                    row = self._row("entry", k, i, begin[k, i])
                    yield (
                        row
                        | self._fault(k, i, begin[k, i])
                        | {"zone": zone, "gap": gap}
                    )
                if end[k, i] < 1:
                    row = self._row("exit", k, i, end[k, i])
                    yield row | {"zone": zone, "gap": gap}

    def _row(self, kind: str, k: int, i: int, u: float) -> dict[str, Any]:
        it = self._chords
        place = it.first[k, i] + u * (it.last[k, i] - it.first[k, i])
        return {
            "time": float(it.times[k, 0] + u * it.lasts[k, 0]),
            "kind": kind,
            "zone": "",
            "person": self.recording.human_names[i],
            "gap": float(np.hypot(*place) - it.reach[k, i]),
            "fault": "",
        }

    def _fault(self, k: int, i: int, u: float) -> dict[str, Any]:
        """Returns who approaches how fast, and whose fault it is."""
        it = self._chords
        way = it.first[k, i] + u * (it.last[k, i] - it.first[k, i])
        away = np.hypot(*way)
        normal = way / away if away > 0 else np.zeros(2)
        # (Not by BLAS, which depends on the machine.)
        robot = float((it.robot[k, 0] * normal).sum() / it.lasts[k, 0])
        person = float(-(it.people[k, i] * normal).sum() / it.lasts[k, 0])
        both = max(robot, 0.0) + max(person, 0.0)
        who = "robot" if robot > person else "person"
        return {
            "robot_speed": robot,
            "person_speed": person,
            "fault": "both" if abs(robot - person) <= _SAME_SPEED else who,
            "share": max(robot, 0.0) / both if both > 0 else math.nan,
        }

    def _charged(self) -> int:
        """Returns how many touches are not the person's fault."""
        begin, _ = chords_within(*self._chords[2:5])
        return sum(
            self._fault(k, i, begin[k, i])["fault"] != "person"
            for k, i in np.argwhere(begin > 0).tolist()
        )

    @cached_property
    def _crosses(self) -> tuple[Mask, Array]:
        """Whether the robot crosses in front in each motion, and its u."""
        it = self._chords
        before, after = (
            _cross(it.people, -it.first),
            _cross(it.people, -it.last),
        )
        change = before - after
        u = np.clip(before / np.where(change == 0, np.nan, change), 0.0, 1.0)
        place = it.first + u[..., None] * (it.last - it.first)
        gap = np.hypot(place[..., 0], place[..., 1]) - it.reach
        way = np.hypot(it.people[..., 0], it.people[..., 1])
        ahead = -(place * it.people).sum(axis=-1) > 0
        ends = np.stack([before, after], axis=1)
        lengths = np.repeat(way, 2, axis=0)
        sides = _sides(ends.reshape(lengths.shape), lengths)
        sides = sides.reshape(ends.shape)
        crosses = sides[:, 0] * sides[:, 1] < 0
        crosses &= ahead & (way / it.lasts >= MOVING)
        crosses &= gap <= max(self.zones.values(), default=0.0)
        return crosses, u

    def _crossings(self) -> Iterator[dict[str, Any]]:
        crosses, u = self._crosses
        for k, i in np.argwhere(crosses).tolist():
            yield self._row("crossing", k, i, float(u[k, i]))

    def _cuts(self) -> Iterator[dict[str, Any]]:
        """Yields when the robot is on the line between two of a group."""
        it = self._chords
        groups = self.recording.group_ids
        people = range(self.recording.num_humans)
        for i, j in itertools.combinations(people, 2):
            if groups[i] < 0 or groups[i] != groups[j]:
                continue
            # From i to j, and from i to the robot.
            line, way = it.first[:, j] - it.first[:, i], -it.first[:, i]
            lines = np.vstack([line, (it.last[:, j] - it.last[:, i])[-1:]])
            ways = np.vstack([way, -it.last[-1:, i]])
            turn, move = np.diff(lines, axis=0), np.diff(ways, axis=0)
            sides = _sides(_cross(lines, ways), np.hypot(*lines.T))
            for u in _roots(
                _cross(turn, move),
                _cross(line, move) + _cross(turn, way),
                _cross(line, way),
                sides[:-1] * sides[1:] < 0,
            ):
                at, on = line + u[:, None] * turn, way + u[:, None] * move
                part = (at * on).sum(axis=-1)
                between = (part > 0) & (part < (at * at).sum(axis=-1))
                for k in np.flatnonzero(between).tolist():
                    row = self._row("cut", k, i, float(u[k]))
                    other = self._row("cut", k, j, float(u[k]))
                    yield row | {
                        "person": f"{row['person']}, {other['person']}",
                        "gap": min(row["gap"], other["gap"]),
                    }


def find_encounters(
    recording: Recording, zones: Mapping[str, float] = ZONES, *, robot: str = ""
) -> Encounters:
    """Finds when a robot entered and left zones around people, and more.

    Args:
        recording: The recording, which may be that of another program. A row of
            NaN, of a person who is missing, leaves no event.
        zones: The largest gap of each zone by its name, in meters.
        robot: The name of the robot, if there are several.

    Raises:
        ValueError: If there is no such robot, or a gap is not a finite number
            that is not negative.
    """
    for name, gap in zones.items():
        if not 0 <= gap < math.inf:
            raise ValueError(
                f"zones[{name!r}] must be a gap in meters, not negative, got"
                f" {gap}"
            )
    _, part = robot_of(recording, robot)
    return Encounters(recording=part, zones=dict(zones))


def encounter_values(
    recording: Recording,
) -> dict[str, tuple[float, dict[str, str]]]:
    """Returns the values of encounters of all robots, as columns of tables.

    With several robots, their names and a dot come first.

    Returns:
        By name, the value, and its "units", "families" and "directions".
    """
    found = {}
    for it in recording.robots:
        prefix = f"{it.robot_name}." if recording.others else ""
        values = find_encounters(recording, robot=it.robot_name).values()
        for name, (value, unit) in values.items():
            better = name in ("first_contact_time", LEAST_GAP)
            facts = {
                "units": unit,
                "families": ENCOUNTERS_FAMILY,
                "directions": "higher" if better else "lower",
            }
            found[prefix + name] = value, facts
    return found


def _cross(a: Array, b: Array) -> Array:
    product: Array = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product


def _sides(products: Array, lengths: Array) -> Array:
    """Returns on which side of lines points are, -1 or 1, over time.

    Who is on a line is on the side of before, 0 if there was none: then a line
    is crossed once, also exactly at a sample.

    Args:
        products: Those of the vectors along the lines and to the points, (K,
            ...), in the order of time.
        lengths: Those of the vectors along the lines.
    """
    near = np.abs(products) <= _ON_LINE * lengths
    sides = np.sign(np.where(near, 0.0, products))
    order = np.arange(len(sides)).reshape(-1, *[1] * (sides.ndim - 1))
    last = np.maximum.accumulate(np.where(sides == 0, 0, order), axis=0)
    found: Array = np.take_along_axis(sides, last, axis=0)
    return found


def _roots(a: Array, b: Array, c: Array, changes: Mask) -> tuple[Array, Array]:
    """Returns where a u^2 + b u + c changes its sign in [0, 1].

    That is once where the signs at the ends differ, which `changes` tells, and
    otherwise twice or nowhere, which is NaN.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(b * b - 4 * a * c)
        # This form of the roots avoids cancellation.
        q = -(b + np.copysign(root, b)) / 2
        roots = np.stack([q / a, c / q])
    inside = np.clip(roots, 0.0, 1.0)
    twice = ((roots > 0) & (roots < 1)).all(axis=0) & (roots[0] != roots[1])
    # (At an end, the root may miss [0, 1] by rounding.)
    off = np.abs(np.where(np.isnan(roots), np.inf, roots) - inside)
    off = np.where(np.isnan(off), np.inf, off)
    first = off[0] <= off[1]
    chosen = np.where(changes, np.stack([first, ~first]), twice)
    found = np.where(chosen, inside, np.nan)
    return found[0], found[1]


def _length_of_union(begin: Array, end: Array) -> float:
    """Returns how long any of some spans lasts; spans of NaN do not count."""
    known = ~np.isnan(begin)
    order = np.argsort(begin[known], kind="stable")
    first, last = begin[known][order], end[known][order]
    done = np.maximum.accumulate(last)
    left = np.maximum(first[1:], done[:-1])
    return float(
        (last[:1] - first[:1]).sum() + np.maximum(last[1:] - left, 0.0).sum()
    )
