"""The file of a recording: a .npz archive of plain arrays, without pickle."""

from pathlib import Path
from typing import Any

import numpy as np

from hunav_drake.systems.common.files import atomic_write
from hunav_drake.systems.world.obstacles import Obstacles

FORMAT = "hunav_drake recording 1"
_TEXTS = ("human_names", "behaviors")
_NUMBERS = ("human_ids", "group_ids")
_ARRAYS = ("times", "robot", "humans", "behavior_status")
_OPTIONAL_ARRAYS = ("nearest_walls", "reference_path")
_SCALARS = ("goal_tolerance", "goal_yaw_tolerance")
_OBSTACLES = ("segments", "first", "solid")


def write(path: str | Path, values: dict[str, Any]) -> None:
    """Writes the fields of a recording to a file.

    Raises:
        OSError: If the file cannot be written.
    """
    arrays = {name: values[name] for name in _ARRAYS + _SCALARS}
    arrays["walls_known"] = np.array(values["walls_known"])
    arrays |= {name: np.array(values[name], dtype=str) for name in _TEXTS}
    arrays |= {name: np.array(values[name], dtype=int) for name in _NUMBERS}
    # An optional field is left out where it is None.
    for name in ("goal", *_OPTIONAL_ARRAYS):
        if values[name] is not None:
            arrays[name] = np.array(values[name], dtype=float)
    for name in _OBSTACLES:
        arrays[f"obstacles.{name}"] = getattr(values["obstacles"], name)
    with atomic_write(path) as file:
        np.savez(file, allow_pickle=False, format=FORMAT, **arrays)


def read(path: str | Path) -> dict[str, Any]:
    """Reads the fields of a recording from a file.

    Raises:
        OSError: If the file cannot be read.
        ValueError: If the file is not a recording.
    """
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
    except OSError:
        raise
    # A damaged archive may fail anywhere in the unpacking.
    except Exception as error:
        raise ValueError(f"{path}: is not a recording: {error}") from error
    if str(arrays.get("format")) != FORMAT:
        raise ValueError(
            f"{path}: is not a recording of this version; expected the format"
            f" {FORMAT!r}, got {str(arrays.get('format'))!r}"
        )
    try:
        values: dict[str, Any] = {name: arrays[name] for name in _ARRAYS}
        values |= {name: float(arrays[name]) for name in _SCALARS}
        values |= {
            name: tuple(arrays[name].tolist()) for name in _TEXTS + _NUMBERS
        }
        values["obstacles"] = Obstacles(
            **{name: arrays[f"obstacles.{name}"] for name in _OBSTACLES}
        )
    except KeyError as error:
        raise ValueError(f"{path}: is not complete: {error}") from error
    if "goal" in arrays:
        values["goal"] = tuple(arrays["goal"].tolist())
    values |= {name: arrays.get(name) for name in _OPTIONAL_ARRAYS}
    # Files that do not tell are of trials, which know their walls.
    values["walls_known"] = bool(arrays.get("walls_known", True))
    return values
