"""The growing recording: a linked list of samples.

Drake copies a context's abstract values at every update and for every clone.
Immutable nodes are shared instead of copied: a sample has constant cost, and
clones of a context share their common past.
"""

from dataclasses import dataclass, field
import math
from typing import Any, NamedTuple, Self

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import (
    CONTACT_SIZE,
    REPLAY_SIZE,
    SIGNAL_SIZE,
    STATE_SIZE,
    X,
    Y,
)
from hunav_drake.systems.evaluation.features import CONTACT_GAP, surface_gaps
from hunav_drake.systems.evaluation.recording import Recording


class Running(NamedTuple):
    """The running values of a trial."""

    # The length of the path, in meters.
    path_length: float
    # The gap to the closest person at the last sample, and the smallest so far,
    # in meters; NaN without people.
    closest_gap: float
    min_gap: float
    # The number of contacts with people so far.
    collisions: int
    # Whether each person touched the robot at the last sample, shape (n,).
    contact: Mask


# What may be recorded of people, and the length of a row.
_ROWS = {"replay": REPLAY_SIZE, "social_signals": SIGNAL_SIZE}


@dataclass(slots=True, eq=False, repr=False)
class Sample:
    """One sample with a link to the previous ones. It is immutable.

    The first node of a list is the start, which is not a sample.
    """

    previous: Self | None
    # In seconds.
    time: float
    # The robot's state, shape (7,), those of people, shape (7n,), and the
    # status of their behaviors, shape (n,), if there is any.
    robot: Array
    humans: Array
    status: Array | None
    # The rows of contacts, shape (8n,), if any, optionally followed by one row
    # of the walls. Samples share them while they do not change.
    contacts: Array | None = None
    # The rows of recorded people, shape (3n,), if any.
    replay: Array | None = None
    # The rows of what people show each other, shape (22n,), if any.
    social_signals: Array | None = None
    # The number of samples up to this one, and the time of the first.
    count: int = field(init=False, default=0)
    first_time: float = field(init=False, default=-math.inf)
    _running: Running | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        before = self.previous
        if before is not None:
            self.count = before.count + 1
            self.first_time = before.first_time if before.count else self.time
            if (
                self.contacts is not None
                and before.contacts is not None
                and self.contacts.tobytes() == before.contacts.tobytes()
            ):
                self.contacts = before.contacts

    @classmethod
    def start(cls, n: int) -> Self:
        """Returns the start of a list for n people."""
        nowhere = np.zeros(STATE_SIZE), np.zeros(STATE_SIZE * n)
        node = cls(None, -math.inf, *nowhere, None)
        nobody = np.zeros(n, dtype=np.bool_)
        node._running = Running(0.0, np.nan, np.nan, 0, nobody)
        return node

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: Any) -> Self:
        return self

    def to_arrays(self) -> dict[str, Array]:
        """Returns all samples up to this one as arrays by name."""
        nodes, n = self.nodes(), self._num_humans
        robot = np.array([node.robot for node in nodes])
        humans = np.array([node.humans for node in nodes])
        has_status = [node.status is not None for node in nodes]
        status = [node.status for node in nodes if node.status is not None]
        given: dict[str, Array] = {}
        if nodes and all(node.contacts is not None for node in nodes):
            given["contacts"] = np.array([node.contacts for node in nodes])
        for name in _ROWS:
            rows = [getattr(node, name) for node in nodes]
            if nodes and all(row is not None for row in rows):
                given[name] = np.array(rows)
        return given | {
            "times": np.array([node.time for node in nodes]),
            "robot": robot.reshape(-1, STATE_SIZE),
            "humans": humans.reshape(len(nodes), n * STATE_SIZE),
            "has_status": np.array(has_status, dtype=np.bool_),
            "status": np.array(status).reshape(len(status), n),
        }

    def from_arrays(self, arrays: dict[str, Array]) -> Self:
        """Returns the list that `to_arrays` turned into arrays.

        Raises:
            LookupError: If an array is missing.
            ValueError: If an array has another shape or type, or is not valid
                for a `Recording`.
        """
        self._check(arrays)
        node = self.start(self._num_humans)
        status = iter(arrays["status"])
        contacts = iter(arrays.get("contacts", ()))
        rows = {name: iter(arrays[name]) for name in _ROWS if name in arrays}
        for time, robot, humans, has_status in zip(
            arrays["times"].tolist(),
            arrays["robot"],
            arrays["humans"],
            arrays["has_status"],
            strict=True,
        ):
            node = type(self)(
                node,
                time,
                robot.copy(),
                humans.copy(),
                next(status).copy() if has_status else None,
                next(contacts).copy() if "contacts" in arrays else None,
                **{name: next(it).copy() for name, it in rows.items()},
            )
        return node

    @property
    def _num_humans(self) -> int:
        return self.humans.size // STATE_SIZE

    def _check(self, arrays: dict[str, Array]) -> None:
        """Checks that arrays form a list for the same number of people."""
        n = self._num_humans
        count = arrays["times"].size
        given = {
            "contacts": np.zeros((count, n * CONTACT_SIZE)),
            **{it: np.zeros((count, n * k)) for it, k in _ROWS.items()},
        } | arrays
        walls = given["contacts"].shape[1:] == ((n + 1) * CONTACT_SIZE,)
        for name, dtype, shape in (
            ("times", np.float64, (count,)),
            ("robot", np.float64, (count, STATE_SIZE)),
            ("humans", np.float64, (count, n * STATE_SIZE)),
            ("has_status", np.bool_, (count,)),
            ("status", np.float64, (np.sum(arrays["has_status"]), n)),
            ("contacts", np.float64, (count, (n + walls) * CONTACT_SIZE)),
            *((it, np.float64, (count, n * k)) for it, k in _ROWS.items()),
        ):
            got = given[name]
            if got.dtype != dtype or got.shape != shape:
                raise ValueError(
                    f"recording.{name}: must be {np.dtype(dtype)} of shape"
                    f" {shape}, got {got.dtype} of shape {got.shape}"
                )
        if not np.isfinite(arrays["status"]).all():
            raise ValueError("recording.status: must be finite")
        if count:
            Recording(**recorded(arrays, n))

    def nodes(self) -> list[Self]:
        """Returns the samples up to this one in order of time."""
        nodes = []
        node = self
        while node.previous is not None:
            nodes.append(node)
            node = node.previous
        return nodes[::-1]

    @property
    def running(self) -> Running:
        """The running values up to this sample.

        Each node computes them at the first access, from the previous node, and
        keeps them.
        """
        pending = []
        node = self
        while node._running is None:
            pending.append(node)
            if node.previous is None:
                raise RuntimeError("a start always knows its running values")
            node = node.previous
        running = node._running
        for after in reversed(pending):
            running = after._running = _advance(running, node, after)
            node = after
        return running


def recorded(arrays: dict[str, Array], n: int) -> dict[str, Any]:
    """Returns the arrays of samples of n people as fields of a Recording."""
    count = len(arrays["times"])
    fields: dict[str, Any] = {
        "times": arrays["times"],
        "robot": arrays["robot"],
        "humans": arrays["humans"].reshape(count, n, STATE_SIZE),
    }
    if arrays["has_status"][-1:].any():
        status = np.zeros((count, n))
        status[arrays["has_status"]] = arrays["status"]
        fields["behavior_status"] = status
    if "contacts" in arrays:
        rows = arrays["contacts"].reshape(count, -1, CONTACT_SIZE)
        walls = rows[:, n] if rows.shape[1] > n else None
        fields |= {"contacts": rows[:, :n], "wall_contact": walls}
    for name, size in _ROWS.items():
        if name in arrays:
            fields[name] = arrays[name].reshape(count, n, size)
    return fields


def _advance(running: Running, before: Sample, after: Sample) -> Running:
    step = 0.0
    if before.count:
        way = after.robot[: Y + 1] - before.robot[: Y + 1]
        step = float(np.hypot(way[X], way[Y]))
    gaps = surface_gaps(after.robot, after.humans.reshape(-1, STATE_SIZE))
    closest = float(np.fmin.reduce(gaps, initial=np.nan))
    contact = gaps < CONTACT_GAP
    return Running(
        path_length=running.path_length + step,
        closest_gap=closest,
        min_gap=float(np.fmin(running.min_gap, closest)),
        collisions=running.collisions
        + int(np.count_nonzero(contact & ~running.contact)),
        contact=contact,
    )
