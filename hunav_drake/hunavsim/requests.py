"""Arrays from the requests of another simulator."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.common.schema import MAX_COORDINATE
from hunav_drake.systems.crowd.limits import LARGEST

# Points of shape (k, 2) for each person, or None for the walls.
ClosestObs = Sequence[ArrayLike | None]


def read_closest_obs(given: ClosestObs | None, count: int) -> list[Any]:
    """Returns the points of each person, shape (k, 2), or None.

    Args:
        given: For each person points (x, y) in W, in meters, or (x, y, z) as
            in HuNavSim's messages; None for a person at the walls.
        count: The number of people.

    Raises:
        ValueError: If the number of entries is not that of people, or a point
            is not finite or beyond 1e5 m.
    """
    if given is None:
        return [None] * count
    if isinstance(given, str) or len(given) != count:
        raise ValueError(
            f"closest_obs must have points, or None, for each of {count}"
            f" people, got {len(given)}"
        )
    return [_points(points, i) for i, points in enumerate(given)]


def _points(points: Any, index: int) -> Array | None:
    if points is None:
        return None
    try:
        rows = np.asarray(points, dtype=float)
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"closest_obs[{index}] must hold numbers: {error}"
        ) from error
    if rows.size == 0:
        return np.zeros((0, 2))
    if rows.ndim != 2 or rows.shape[1] not in (2, 3):
        raise ValueError(
            f"closest_obs[{index}] must hold rows (x, y), got shape"
            f" {rows.shape}"
        )
    rows = np.ascontiguousarray(rows[:, :2])
    if not (abs(rows) <= MAX_COORDINATE).all():
        raise ValueError(
            f"closest_obs[{index}] must be finite, and within"
            f" {MAX_COORDINATE:g} m"
        )
    return rows


def points_key(points: Sequence[Array | None]) -> bytes:
    """Returns bytes that are equal for equal points."""
    return b"".join(
        b"-" if own is None else f"{len(own)}:".encode() + own.tobytes()
        for own in points
    )


def read_rows(values: Any, count: int, name: str) -> Array:
    """Returns rows of states, shape (count, 7); the name is for messages.

    Raises:
        ValueError: If the number of rows is wrong, or they are not finite.
    """
    try:
        rows = np.asarray(values, dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{name} must hold numbers: {error}") from error
    if rows.size != count * STATE_SIZE or (
        rows.ndim > 1 and rows.shape[-1] != STATE_SIZE
    ):
        raise ValueError(
            f"{name} must hold {count} rows (x, y, yaw, vx, vy, omega,"
            f" radius), got shape {rows.shape}"
        )
    rows = np.ascontiguousarray(rows.reshape(-1, STATE_SIZE))
    rules = [
        (np.isfinite(rows), "be finite"),
        (abs(rows) <= LARGEST, f"have no numbers beyond {LARGEST:g}"),
    ]
    for mask, rule in rules:
        bad = rows[~mask.all(axis=1)]
        if len(bad):
            raise ValueError(
                f"{name} must {rule}, got the row {bad[0].tolist()}"
            )
    return rows
