"""Reads recordings from tables with a row per agent and sample."""

from array import array
from collections.abc import Iterator, Sequence
import csv
import dataclasses
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray
import pandas as pd

from hunav_drake.systems.common.arrays import Array
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
from hunav_drake.systems.common.suggest import nearest, shown
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.evaluation.recording_checks import LARGEST

# The agent that is the robot, and the begin of the names of several ones.
ROBOT, OF_ROBOT = "robot", "robot:"
_NEEDED = ("time", "agent", "x", "y")
_TEXTS = ("agent", "behavior")
_WHOLE = ("group_id", "behavior_status")
# Columns that are constant for each person, and their names in a recording.
_CONSTANTS = {"behavior": "behaviors", "group_id": "group_ids"}
_COLUMNS = ("time", "agent", *STATE_FIELDS, *_WHOLE, "behavior")

_LINE = re.compile(r"[^\r\n]*(?:\r\n|\r|\n)|[^\r\n]+")

# The default radius, in meters.
_RADIUS = 0.35

# Times that differ by at most this, in seconds, are the same: the clocks of
# different agents differ by rounding.
_SAME_TIME = 1e-6

# Below this speed an agent keeps its heading, in m/s.
_STILL = 0.01


def parse_csv(text: str) -> Recording:
    """Returns the recording of a table with a header: see `ReadRecording`.

    Raises:
        ValueError: If the table is not valid. The message names the line.
    """
    table = _read_table(text)
    times, sample = _merge_times(table["time"].to_numpy())
    given = list(dict.fromkeys(table["agent"]))
    robots = [it for it in given if it == ROBOT or it.startswith(OF_ROBOT)]
    robots = robots or [ROBOT]
    if len(robots) > 1 and ROBOT in robots:
        raise ValueError(
            f"the agents {', '.join(map(shown, robots))} are robots: give each"
            f" of several robots a name, as in {OF_ROBOT}anna"
        )
    m = len(robots)
    agents = [*robots, *(it for it in given if it not in robots)]
    _check_rows(times, sample, table["agent"], robots)
    body = table["agent"].map({name: i for i, name in enumerate(agents)})

    states = np.full((len(times), len(agents), STATE_SIZE), np.nan)
    for i, name in enumerate(STATE_FIELDS):
        if name in table:
            states[sample, body, i] = table[name]
    for i, agent in enumerate(agents):
        complete(times, states[:, i], set(STATE_FIELDS) - set(table))
        check_speeds(times, states[:, i], agent)

    status = np.zeros((len(times), len(agents)), dtype=int)
    if "behavior_status" in table:
        status[sample, body] = table["behavior_status"]
    settings: dict[str, Any] = {
        field: tuple(_constant(table, column, agent) for agent in agents[m:])
        for column, field in _CONSTANTS.items()
        if column in table
    }
    first, *others = (
        Recording(
            times=times,
            robot=states[:, i],
            robot_name=robot.removeprefix(OF_ROBOT) if robot != ROBOT else "",
            humans=states[:, m:],
            behavior_status=status[:, m:],
            human_names=tuple(agents[m:]),
            walls_known=False,
            **settings,
        )
        for i, robot in enumerate(robots)
    )
    return dataclasses.replace(first, others=tuple(others))


def _merge_times(times: Array) -> tuple[Array, NDArray[np.intp]]:
    """Returns the distinct times, and the index of each row's time."""
    instants, which = np.unique(times, return_inverse=True)
    new = np.diff(instants, prepend=-np.inf) > _SAME_TIME
    return instants[new], (np.cumsum(new) - 1)[which]


def _constant(table: pd.DataFrame, column: str, agent: str) -> Any:
    """Returns the value of a column for a person, which must be constant."""
    cells = table.loc[table["agent"] == agent, column]
    first = cells.iloc[0]
    others = cells[cells != first]
    if len(others):
        raise ValueError(
            f"line {others.index[0]}: the {column} of {shown(agent)} must not"
            f" change, but is {others.iloc[0]!s:.60} here and"
            f" {first!s:.60} in line"
            f" {cells.index[0]}"
        )
    return first


def _read_table(text: str) -> pd.DataFrame:
    """Returns the table; its index is the line of each row."""
    reader = _rows(text)
    _, header = next(reader)
    _check_header(header)
    # Text takes much more memory than numbers.
    lines = array("q")
    columns: list[Any] = [
        [] if name in _TEXTS else array("d") for name in header
    ]
    known: dict[str, str] = {}
    for line, row in reader:
        lines.append(line)
        for name, column, cell in zip(header, columns, row, strict=True):
            if name in _TEXTS:
                cell = cell.strip()
                column.append(known.setdefault(cell, cell))
            else:
                column.append(_number(cell))
    if not lines:
        raise ValueError("the table has no rows")
    table = {}
    for i, (name, column) in enumerate(zip(header, columns, strict=True)):
        table[name] = column
        if name not in _TEXTS:
            values = np.frombuffer(column)
            good, rule = _rule(name, values)
            if not good.all():
                line = lines[np.argmin(good)]
                cell = next(row[i] for at, row in _rows(text) if at == line)
                raise ValueError(
                    f"line {line}: {name} must be {rule}, got {shown(cell)}"
                )
            table[name] = values.astype(int) if name in _WHOLE else values
    return pd.DataFrame(table, np.frombuffer(lines, dtype=np.int64))


def _rows(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yields the header and the rows, each with its last line number."""
    header_line = text.split("\n", 1)[0]
    reader = csv.reader(
        (it[0] for it in _LINE.finditer(text)),
        delimiter=max(",;\t", key=header_line.count),
        strict=True,
    )
    try:
        header = [name.strip() for name in next(reader, [])]
        yield 1, header
        for row in reader:
            if not row:
                continue
            if len(row) != len(header):
                raise ValueError(
                    f"line {reader.line_num}: has {len(row)} cells, but the"
                    f" header has {len(header)}"
                )
            yield reader.line_num, row
    except csv.Error as error:
        raise ValueError(f"line {reader.line_num}: {error}") from error


def _check_header(header: list[str]) -> None:
    for name in _NEEDED:
        if name not in header:
            raise ValueError(f"line 1: the table has no column {name!r}")
    for i, name in enumerate(header):
        if name in header[:i]:
            raise ValueError(f"line 1: there are two columns {shown(name)}")
        if name not in _COLUMNS:
            near = nearest(name, _COLUMNS)
            raise ValueError(
                f"line 1: there is no column {shown(name)}; "
                + (f"did you mean {near!r}? " if near else "")
                + f"The columns are {', '.join(_COLUMNS)}"
            )


def _rule(name: str, values: Array) -> tuple[NDArray[np.bool_], str]:
    """Returns which numbers of a column are valid, and the rule in words."""
    good = np.abs(values) <= LARGEST
    what = f"a finite number, at most {LARGEST:g} in size"
    if name in _WHOLE:
        what = "a whole number"
        good &= values == np.trunc(values)
    elif name == "radius":
        what += ", not negative"
        good &= values >= 0
    return good, what


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return np.nan


def _check_rows(
    times: Array,
    sample: NDArray[np.intp],
    agent: pd.Series,
    robots: Sequence[str],
) -> None:
    """Checks that no agent has two rows at a time, and robots have all."""
    keys = pd.DataFrame({"sample": sample, "agent": agent})
    twice = keys.duplicated()
    if twice.any():
        line = twice.idxmax()
        k, name = keys.loc[line]
        first = ((keys["sample"] == k) & (agent == name)).idxmax()
        raise ValueError(
            f"line {line}: {shown(name)} has a row for {times[k]:g} s"
            " already, in"
            f" line {first}"
        )
    for robot in robots:
        missing = np.setdiff1d(np.arange(len(times)), sample[agent == robot])
        if len(missing) == len(times):
            raise ValueError(f"no row has the agent {robot!r}")
        if len(missing):
            at = times[missing[0]]
            raise ValueError(f"{robot!r} has no row for {at:g} s")


def complete(times: Array, states: Array, missing: set[str]) -> None:
    """Computes the missing fields of an agent's states (N + 1, 7), in place.

    The states are NaN while the agent is absent.
    """
    there = np.flatnonzero(~np.isnan(states[:, X]))
    # No derivatives across times of absence.
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


def check_speeds(times: Array, states: Array, agent: str) -> None:
    """Refuses speeds that were computed from positions and are too large."""
    bad = np.argwhere(np.abs(states) > LARGEST)
    if len(bad):
        k, column = bad[0].tolist()
        raise ValueError(
            f"{shown(agent)} at {times[k]:g} s: {STATE_FIELDS[column]},"
            " worked out"
            f" from the rows before and after, must be at most {LARGEST:g} in"
            f" size, got {states[k, column]:g}; are times and positions right?"
        )


def _slope(times: Array, values: Array) -> Array:
    if len(times) == 1:
        return np.zeros(1)
    slope: Array = np.gradient(values, times)
    return slope


def _headings(velocities: Array) -> Array:
    """Returns the directions of velocities (m, 2), constant while at rest."""
    vx, vy = velocities.T
    known = np.where(np.hypot(vx, vy) >= _STILL, np.arctan2(vy, vx), np.nan)
    headings: Array = pd.Series(known).ffill().bfill().fillna(0.0).to_numpy()
    return headings
