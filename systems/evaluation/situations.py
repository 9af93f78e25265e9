"""The social situations of a robot in a recording."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
import math
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.suggest import did_you_mean
from hunav_drake.systems.evaluation.episodes import (
    describe_episode,
    edges_of,
    spans_of,
    time_lost,
)
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.situation_labels import (
    DOWN_PATHS,
    LABELS,
    PRIMARIES,
    people_by_label,
    people_near,
)

if TYPE_CHECKING:
    import pandas as pd
else:
    import lazy_loader

    pd = lazy_loader.load("pandas")

# Somebody passes on a side.
_WITH_SIDE = ("cross_path", "down_path", *DOWN_PATHS)

_COLUMNS = (
    *("label", "begin", "end", "people", "least_gap", "slowed", "side"),
    "delay",
)


class LabelShare(NamedTuple):
    """How much of the time a label holds: see `Situations.shares`."""

    share: float
    primary: float
    episodes: int
    episode_time: float


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Situations:
    """The social situations of a robot at N + 1 samples.

    Attributes:
        recording: The recording of this robot, until its end.
        people: By label, who makes it, shape (N + 1, n): who crosses the path,
            the members of the group, ...
        flags: By label, whether it holds, shape (N + 1,).
    """

    recording: Recording
    people: Mapping[str, Mask]
    flags: Mapping[str, Mask]

    def __repr__(self) -> str:
        return f"<Situations in the {repr(self.recording)[1:]}"

    @cached_property
    def primary(self) -> NDArray[np.str_]:
        """The first of `PRIMARIES` that holds, shape (N + 1,)."""
        held = np.array([self.flags[name] for name in PRIMARIES])
        return np.array(PRIMARIES)[held.argmax(axis=0)]

    @cached_property
    def edges(self) -> Array:
        """The times between which each sample counts: see `edges_of`."""
        return edges_of(self.recording.times)

    def share_of(self, mask: Mask) -> float:
        """Returns the share of the time of some samples, in [0, 1]."""
        if len(mask) == 1:
            return float(mask[0])
        weights = np.diff(self.edges)
        return float(weights[mask].sum() / weights.sum())

    def shares(self) -> "pd.DataFrame":
        """Returns how much of the time each label holds.

        Returns:
            A row per label, indexed by "label": "share" of the time, in [0, 1];
            "primary", the share in which it is the primary one (these add up to
            1; NaN for labels that cannot be); "episodes", their number; and
            "episode_time", their total length, in seconds.
        """
        return pd.DataFrame(
            list(self.by_label.values()),
            index=pd.Index(LABELS, name="label"),
            columns=LabelShare._fields,
        )

    @cached_property
    def by_label(self) -> Mapping[str, LabelShare]:
        """The rows of `shares`, by label."""
        found = {}
        for it in LABELS:
            spans = spans_of(self.flags[it], self.edges)
            is_primary = it in PRIMARIES
            found[it] = LabelShare(
                self.share_of(self.flags[it]),
                self.share_of(self.primary == it) if is_primary else math.nan,
                len(spans),
                float(np.diff(self.edges[spans]).sum()),
            )
        return MappingProxyType(found)

    def episodes(self) -> "pd.DataFrame":
        """Returns the episodes of all labels, in the order of their begins.

        An episode is a time in which a label holds. Gaps of less than 1 s are
        closed; then, episodes of less than 0.5 s are dropped.

        Returns:
            A row per episode: "label"; "begin" and "end", in seconds; "people",
            the names of those who make it; "least_gap", "slowed" and "side" as
            in `describe_episode` ("side" only for labels of paths); and
            "delay", the time that the robot loses against its median speed
            while nobody is near, in seconds: NaN if it never moves then.
        """
        lost = time_lost(self.recording, self.edges, self.flags["empty"])
        rows: list[dict[str, Any]] = []
        for name in LABELS:
            spans = spans_of(self.flags[name], self.edges)
            for first, after in spans.tolist():
                made = self.people[name][first:after]
                names = self.recording.human_names
                row = {
                    "label": name,
                    "begin": float(self.edges[first]),
                    "end": float(self.edges[after]),
                    "people": ", ".join(
                        names[i] for i in np.flatnonzero(made.any(axis=0))
                    ),
                    **describe_episode(self.recording, first, after, made),
                    "delay": float(lost[after] - lost[first]),
                }
                if name not in _WITH_SIDE:
                    row["side"] = ""
                rows.append(row)
        rows.sort(key=lambda row: row["begin"])
        return pd.DataFrame(rows, columns=_COLUMNS)


def FindSituations(
    recording: Recording, *, robot: str = "", doors: ArrayLike | None = None
) -> Situations:
    """Finds the social situations of a robot.

    Args:
        recording: The recording, which may be that of another program. If it
            has `social_signals`, these tell who talks, queues, blocks and
            accompanies; otherwise, talks are found by geometry.
        robot: The name of the robot, if there are several.
        doors: The centers of doors, shape (k, 2), in W, in meters; by default
            those of the recording, if it knows any.

    Raises:
        ValueError: If there is no such robot, or the doors have another shape.
    """
    code, part = robot_of(recording, robot)
    if doors is None:
        doors = () if part.doors is None else part.doors
    try:
        centers = np.asarray(doors, dtype=float)
    except ValueError as error:
        raise ValueError(f"doors: must be numbers: {error}") from error
    if centers.size and (centers.ndim != 2 or centers.shape[1] != 2):
        raise ValueError(
            f"doors: must have the shape (k, 2), got {centers.shape}"
        )
    if not np.isfinite(centers).all():
        raise ValueError(f"doors: must be finite, got {centers.tolist()}")
    signals = recording.social_signals
    if signals is not None:
        signals = signals[: len(part)]
    near = people_near(part)
    people = people_by_label(part, near, centers, signals, code)
    flags = {name: it.any(axis=1) for name, it in people.items()}
    flags["empty"] = ~near.any(axis=1)
    return Situations(recording=part, people=people, flags=flags)


def robot_of(recording: Recording, name: str) -> tuple[int, Recording]:
    """Returns the row code of a robot in signals, and its recording.

    Raises:
        ValueError: If there is no such robot.
    """
    robots = {it.robot_name: it for it in recording.robots}
    if not recording.others and not name:
        name = recording.robot_name
    if name not in robots:
        names = ", ".join(map(repr, robots))
        raise ValueError(
            f"robot: must be one of {names}, got {name!r}"
            f"{did_you_mean(name, robots)}"
        )
    code = recording.num_humans + list(robots).index(name)
    return code, robots[name].until_end()
