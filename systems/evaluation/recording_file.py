"""The file of a recording: a .npz archive of plain arrays, without pickle."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.files import atomic_write, read_arrays
from hunav_drake.systems.common.suggest import shown
from hunav_drake.systems.world.obstacles import Obstacles

FORMAT = "hunav_drake recording 1"

_NUMBER, _INTEGER, _TEXT, _YES_NO = "biuf", "iu", "U", "b"

# The required arrays: the kinds of NumPy types and the number of dimensions.
_REQUIRED = {
    "times": (_NUMBER, 1),
    "robot": (_NUMBER, 2),
    "humans": (_NUMBER, 3),
    "behavior_status": (_NUMBER, 2),
    "human_names": (_TEXT, 1),
    "behaviors": (_TEXT, 1),
    "human_ids": (_INTEGER, 1),
    "group_ids": (_INTEGER, 1),
    "goal_tolerance": (_NUMBER, 0),
    "goal_yaw_tolerance": (_NUMBER, 0),
}
_OBSTACLES = {
    "obstacles.segments": (_NUMBER, 2),
    "obstacles.first": (_INTEGER, 1),
    "obstacles.solid": (_YES_NO, 1),
}

# Arrays that are left out where they are None. Files without walls_known are
# from trials, in which walls are known.
_OPTIONAL = {
    "goal": (_NUMBER, 1),
    "nearest_walls": (_NUMBER, 4),
    "reference_path": (_NUMBER, 2),
    "robot_max_speed": (_NUMBER, 0),
    "walls_known": (_YES_NO, 0),
    "contacts": (_NUMBER, 3),
    "wall_contact": (_NUMBER, 2),
    "contact_forces_known": (_YES_NO, 0),
    "hunavsim_forces": (_YES_NO, 0),
    "told_velocities": (_NUMBER, 3),
    "replay": (_NUMBER, 3),
    "social_signals": (_NUMBER, 3),
    "doors": (_NUMBER, 2),
    "robot_name": (_TEXT, 0),
    "end_time": (_NUMBER, 0),
}

# The arrays of each of several robots; those of the second and later ones have
# the prefix "others.1.", ...
_OF_ROBOT = (
    *("robot", "goal", "goal_tolerance", "goal_yaw_tolerance"),
    *("robot_max_speed", "contacts", "wall_contact", "contact_forces_known"),
    *("robot_name", "end_time", "reference_path"),
)


def write(path: str | Path, values: dict[str, Any]) -> None:
    """Writes the fields of a recording to a file.

    Raises:
        OSError: If the file cannot be written.
    """
    types = {_TEXT: str, _INTEGER: int}
    facts = _REQUIRED | _OPTIONAL
    arrays = {
        name: np.array(values[name], dtype=types.get(kinds))
        for name, (kinds, _) in facts.items()
        if values[name] is not None
    }
    for k, other in enumerate(values["others"], 1):
        arrays |= {
            f"others.{k}.{name}": np.array(
                getattr(other, name), dtype=types.get(facts[name][0])
            )
            for name in _OF_ROBOT
            if getattr(other, name) is not None
        }
    for name in _OBSTACLES:
        arrays[name] = getattr(values["obstacles"], name.split(".")[1])
    with atomic_write(path) as file:
        # (Older NumPy would write `allow_pickle` as an array, if given; mypy
        # takes the arrays for it.)
        np.savez(file, format=FORMAT, **arrays)  # type: ignore[arg-type]


def read(path: str | Path) -> dict[str, Any]:
    """Reads the fields of a recording from a file.

    Raises:
        OSError: If the file cannot be read.
        ValueError: If the file is not a recording. The message names the array,
            what it must be, and what it is.
    """
    arrays = read_arrays(path, "a recording")
    if str(arrays.get("format")) != FORMAT:
        raise ValueError(
            f"{path}: is not a recording of this version; expected the format"
            f" {FORMAT!r}, got {shown(str(arrays.get('format')))}"
        )
    values = _read(path, arrays, [*_REQUIRED, *_OBSTACLES, *_OPTIONAL])
    try:
        values["obstacles"] = _obstacles(*(values.pop(n) for n in _OBSTACLES))
    except ValueError as error:
        raise ValueError(f"{path}: is damaged: {error}") from error
    others: list[dict[str, Any]] = []
    while any(key.startswith(f"others.{len(others) + 1}.") for key in arrays):
        prefix = f"others.{len(others) + 1}."
        others.append(_read(path, arrays, _OF_ROBOT, prefix))
    shared = {k: it for k, it in values.items() if k not in _OF_ROBOT}
    return values | {"others": [shared | it for it in others]}


def _read(
    path: str | Path,
    arrays: Mapping[str, NDArray[Any]],
    names: Iterable[str],
    prefix: str = "",
) -> dict[str, Any]:
    """Returns arrays of a file by their names without a prefix.

    Raises:
        ValueError: If one is missing or not valid.
    """
    facts = _REQUIRED | _OBSTACLES | _OPTIONAL
    values: dict[str, Any] = {}
    for name in names:
        key, (kinds, dimensions) = prefix + name, facts[name]
        if key not in arrays and name not in _OPTIONAL:
            raise ValueError(f"{path}: is not complete: it has no {key}")
        if key in arrays:
            array = arrays[key]
            if array.dtype.kind not in kinds or array.ndim != dimensions:
                raise ValueError(
                    f"{path}: is damaged: {key} must have {dimensions}"
                    f" dimensions and a type of the kinds {kinds!r}, got"
                    f" {array.ndim} and {array.dtype}; record it again"
                )
            large = name in ("times", "robot", "humans", *_OBSTACLES)
            values[name] = array if large or dimensions > 1 else array.tolist()
    return values


def _obstacles(
    segments: NDArray[Any], first: NDArray[Any], solid: NDArray[Any]
) -> Obstacles:
    """Returns walls after a check of the indices, which kernels rely on."""
    if segments.shape[1] != 4 or not (np.abs(segments) <= 1e10).all():
        raise ValueError(
            "obstacles.segments must have 4 columns of finite numbers, up to"
            f" 1e10 m; it has the shape {segments.shape}"
        )
    first = first.astype(np.int64)
    ends = first[[0, -1]].tolist() if len(first) else []
    if (
        len(first) != len(solid) + 1
        or ends != [0, len(segments)]
        or (np.diff(first) < 1).any()
    ):
        raise ValueError(
            "obstacles.first must increase from 0 to the number of segments,"
            f" {len(segments)}, over {len(solid)} shapes; it is"
            f" {first.tolist()!s:.60}"
        )
    return Obstacles(
        segments=segments.astype(np.float64, copy=False),
        first=first,
        solid=solid,
    )
