"""Reads recordings from tables with a row per body and sample."""

import csv
import io
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.layout import (
    OMEGA,
    RADIUS,
    STATE_FIELDS,
    STATE_SIZE,
    VX,
    VY,
    YAW,
    X,
    Y,
)
from hunav_drake.systems.common.suggest import nearest
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.recording_checks import LARGEST

Array = NDArray[np.float64]

ROBOT = "robot"
_NEEDED = ("time", "agent", "x", "y")
_TEXTS = ("agent", "behavior")
_WHOLE = ("group_id", "behavior_status")
_COLUMNS = ("time", "agent", *STATE_FIELDS, *_WHOLE, "behavior")

# The radius of a body that has none in the table, in meters.
_RADIUS = 0.35

# Times that are no farther apart are one, in seconds: clocks of different
# bodies, which add up their steps, differ by rounding.
_SAME_TIME = 1e-6

# Below this speed a body keeps its heading, in m/s.
_STILL = 0.01


def parse_csv(text: str) -> Recording:
    """Makes a recording of a table: see `ReadRecording`.

    Args:
        text: The table, with a header.

    Raises:
        ValueError: If it is not such a table. The text names the line.
    """
    columns, lines = _columns(text)
    times, sample = _merge_times(columns["time"])
    agents = list(dict.fromkeys(columns["agent"]))
    if ROBOT not in agents:
        raise ValueError(f"no row has the agent {ROBOT!r}")
    agents.remove(ROBOT)
    agents.insert(0, ROBOT)
    index = {name: i for i, name in enumerate(agents)}
    body = np.array([index[name] for name in columns["agent"]])
    _check_rows(times, sample, body, agents, lines)

    states = np.full((len(times), len(agents), STATE_SIZE), np.nan)
    for i, name in enumerate(STATE_FIELDS):
        if name in columns:
            states[sample, body, i] = columns[name]
    for i, agent in enumerate(agents):
        _complete(times, states[:, i], set(STATE_FIELDS) - set(columns))
        _check_speeds(times, states[:, i], agent)

    status = np.zeros((len(times), len(agents)), dtype=int)
    if "behavior_status" in columns:
        status[sample, body] = columns["behavior_status"]
    settings: dict[str, Any] = {}
    for column, field in (("behavior", "behaviors"), ("group_id", "group_ids")):
        if column in columns:
            settings[field] = _constants(
                column, columns[column], body, agents, lines
            )
    return Recording(
        times=times,
        robot=states[:, 0],
        humans=states[:, 1:],
        behavior_status=status[:, 1:],
        human_names=tuple(agents[1:]),
        walls_known=False,
        **settings,
    )


def _merge_times(times: Array) -> tuple[Array, NDArray[np.intp]]:
    """Returns the instants of all rows, and the instant of each row."""
    instants, which = np.unique(times, return_inverse=True)
    new = np.diff(instants, prepend=-np.inf) > _SAME_TIME
    return instants[new], (np.cumsum(new) - 1)[which]


def _constants(
    name: str,
    cells: Any,
    body: NDArray[np.intp],
    agents: list[str],
    lines: list[int],
) -> tuple[Any, ...]:
    """Returns what a column tells of each person, which must not change."""
    values = []
    for i in range(1, len(agents)):
        first, *others = np.flatnonzero(body == i)
        values.append(cells[first])
        for k in others:
            if cells[k] != cells[first]:
                raise ValueError(
                    f"line {lines[k]}: the {name} of {agents[i]!r} must not"
                    f" change, but is {cells[k]} here and {cells[first]} in"
                    f" line {lines[first]}"
                )
    return tuple(values)


def _columns(text: str) -> tuple[dict[str, Any], list[int]]:
    """Returns the columns by name, and the line of each row."""
    header_line = text.split("\n", 1)[0]
    reader = csv.reader(
        io.StringIO(text, newline=""),
        delimiter=max(",;\t", key=header_line.count),
        strict=True,
    )
    try:
        header = [name.strip() for name in next(reader, [])]
        _check_header(header)
        rows, lines = [], []
        for row in reader:
            if not row:
                continue
            if len(row) != len(header):
                raise ValueError(
                    f"line {reader.line_num}: has {len(row)} cells, but the"
                    f" header has {len(header)}"
                )
            rows.append(row)
            lines.append(reader.line_num)
    except csv.Error as error:
        raise ValueError(f"line {reader.line_num}: {error}") from error
    if not rows:
        raise ValueError("the table has no rows")
    columns: dict[str, Any] = {}
    for name, cells in zip(header, zip(*rows, strict=True), strict=True):
        if name in _TEXTS:
            columns[name] = [cell.strip() for cell in cells]
        else:
            columns[name] = _numbers(name, cells, lines)
    return columns, lines


def _check_header(header: list[str]) -> None:
    for name in _NEEDED:
        if name not in header:
            raise ValueError(f"line 1: the table has no column {name!r}")
    for i, name in enumerate(header):
        if name in header[:i]:
            raise ValueError(f"line 1: the column {name!r} comes twice")
        if name not in _COLUMNS:
            near = nearest(name, _COLUMNS)
            raise ValueError(
                f"line 1: there is no column {name!r}; "
                + (f"did you mean {near!r}? " if near else "")
                + f"The columns are {', '.join(_COLUMNS)}"
            )


def _numbers(name: str, cells: tuple[str, ...], lines: list[int]) -> Array:
    values = np.empty(len(cells))
    for i, cell in enumerate(cells):
        try:
            values[i] = float(cell)
        except ValueError:
            values[i] = np.nan
    good = np.abs(values) <= LARGEST
    what = f"a finite number, at most {LARGEST:g} in size"
    if name in _WHOLE:
        what = "a whole number"
        good &= values == np.trunc(values)
    elif name == "radius":
        what += ", not negative"
        good &= values >= 0
    if not good.all():
        i = int(np.argmin(good))
        raise ValueError(
            f"line {lines[i]}: {name} must be {what}, got {cells[i]!r}"
        )
    return values.astype(int) if name in _WHOLE else values


def _check_rows(
    times: Array,
    sample: NDArray[np.intp],
    body: NDArray[np.intp],
    agents: list[str],
    lines: list[int],
) -> None:
    count = np.zeros((len(times), len(agents)), dtype=int)
    np.add.at(count, (sample, body), 1)
    if (count > 1).any():
        k, i = np.argwhere(count > 1)[0]
        twice = np.flatnonzero((sample == k) & (body == i))
        raise ValueError(
            f"line {lines[twice[1]]}: {agents[i]!r} has a row for"
            f" {times[k]:g} s already, in line {lines[twice[0]]}"
        )
    if not count[:, 0].all():
        k = int(np.argmin(count[:, 0]))
        raise ValueError(f"{ROBOT!r} has no row for {times[k]:g} s")


def _complete(times: Array, states: Array, missing: set[str]) -> None:
    """Works out what a table does not tell of a body, in place.

    Args:
        times: Shape (N + 1,), in seconds.
        states: Shape (N + 1, 7); NaN at all samples at which it is missing.
        missing: The fields that are not known.
    """
    there = np.flatnonzero(~np.isnan(states[:, X]))
    # Nothing is known of the time in which it is away.
    for part in np.split(there, np.flatnonzero(np.diff(there) > 1) + 1):
        t = times[part]
        for field, velocity, position in (("vx", VX, X), ("vy", VY, Y)):
            if field in missing:
                states[part, velocity] = _slope(t, states[part, position])
        if "yaw" in missing:
            states[part, YAW] = _headings(states[part][:, [VX, VY]])
        if "omega" in missing:
            states[part, OMEGA] = _slope(t, np.unwrap(states[part, YAW]))
        if "radius" in missing:
            states[part, RADIUS] = _RADIUS


def _check_speeds(times: Array, states: Array, agent: str) -> None:
    """Refuses speeds, worked out of positions, that are too large."""
    bad = np.argwhere(np.abs(states) > LARGEST)
    if len(bad):
        k, column = bad[0].tolist()
        raise ValueError(
            f"{agent!r} at {times[k]:g} s: {STATE_FIELDS[column]}, worked out"
            f" from the rows before and after, must be at most {LARGEST:g} in"
            f" size, got {states[k, column]:g}; are times and positions right?"
        )


def _slope(times: Array, values: Array) -> Array:
    if len(times) == 1:
        return np.zeros(1)
    slope: Array = np.gradient(values, times)
    return slope


def _headings(velocities: Array) -> Array:
    """Returns the directions of velocities (m, 2), held while at rest."""
    moving = np.flatnonzero(np.hypot(*velocities.T) >= _STILL)
    if not len(moving):
        return np.zeros(len(velocities))
    last = np.searchsorted(moving, np.arange(len(velocities)), side="right") - 1
    source = velocities[moving[np.maximum(last, 0)]]
    headings: Array = np.arctan2(source[:, 1], source[:, 0])
    return headings
