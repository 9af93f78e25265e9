"""Checks of the arrays of a recording."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import RADIUS, STATE_FIELDS, STATE_SIZE

# The largest number in a recording, in SI units: sums and powers of far larger
# numbers are not finite.
LARGEST = 1e10

# The minimum interval between two samples, in seconds: speeds and accelerations
# over shorter ones would not be finite.
SHORTEST_INTERVAL = 1e-20


def checked_array(
    name: str, value: ArrayLike, shape: tuple[int | None, ...]
) -> Array:
    """Returns a read-only copy of an array after a check of its shape."""
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
    array.setflags(write=False)
    return array


def checked_path(path: ArrayLike) -> Array:
    """Returns a read-only copy of a reference path (m, 3) after its checks."""
    array = checked_array("reference_path", path, (None, 3))
    if not len(array):
        raise ValueError("recording.reference_path: must have rows")
    check_numbers("reference_path", array)
    check_increasing("reference_path: its times", array[:, 0])
    return array


def check_numbers(name: str, array: Array, *, whole: bool = False) -> None:
    """Raises ValueError unless numbers are finite and not too large."""
    good = np.abs(array) <= LARGEST
    if whole:
        good &= array == np.trunc(array)
    if not good.all():
        raise ValueError(
            f"recording.{name}: must be finite, {'whole, ' if whole else ''}"
            f"and at most {LARGEST:g} in size, got"
            f" {array[tuple(np.argwhere(~good)[0])]}"
        )


def check_increasing(name: str, times: Array) -> None:
    """Raises ValueError unless times increase by `SHORTEST_INTERVAL`."""
    check_numbers(name, times)
    late = np.flatnonzero(np.diff(times) < SHORTEST_INTERVAL)
    if late.size:
        k = int(late[0])
        raise ValueError(
            f"recording.{name}: must increase strictly, by at least"
            f" {SHORTEST_INTERVAL:g} s, but sample {k + 1} at {times[k + 1]} s"
            f" follows sample {k} at {times[k]} s"
        )


def check_states(robot: Array, humans: Array) -> None:
    """Raises ValueError unless states (N, 7), (N, n, 7) are in range.

    A row of NaN is a missing person.
    """
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


def per_human(name: str, values: Sequence[Any], default: list[Any]) -> Any:
    """Returns a tuple of a value per person; `default` if there are none."""
    try:
        values = tuple(values)
    except TypeError as error:
        raise ValueError(f"recording.{name}: is not a list: {error}") from error
    if not values:
        return tuple(default)
    if len(values) != len(default):
        raise ValueError(
            f"recording.{name}: needs one for each of {len(default)} people,"
            f" got {len(values)}"
        )
    if isinstance(default[0], str):
        return tuple(map(str, values))
    numbers = checked_array(name, values, (len(values),))
    check_numbers(name, numbers, whole=True)
    if name == "human_ids" and len(set(values)) != len(values):
        raise ValueError(f"recording.human_ids: must differ, got {values}")
    return tuple(map(int, values))


def checked_goal(goal: Any) -> tuple[float, float, float] | None:
    """Returns the goal (x, y, yaw) as floats after a check, or None."""
    if goal is None:
        return None
    array = checked_array("goal", goal, (3,))
    check_numbers("goal", array)
    x, y, yaw = array.tolist()
    return x, y, yaw
