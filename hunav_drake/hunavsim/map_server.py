"""Reads maps of ROS 2's map_server: their occupied cells, as rectangles.

A map is a YAML file with the image, the size of its cells and where its lower
left corner is; an image of gray values, in which dark is occupied.
"""

from collections.abc import Iterator
import math
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError
import yaml

from hunav_drake.systems.world.shapes import Box

Mask = NDArray[np.bool_]

# A map with more cells than this is not looked at.
MAX_CELLS = 2**26

# Cells smaller than this are joined to such ones, in meters: a rugged wall is
# made of few rectangles then.
GRAIN = 0.1


class MapError(ValueError):
    """A map cannot be read; the text says where and why."""


def read_map(filename: str | Path, *, grain: float = GRAIN) -> list[Box]:
    """Reads the occupied cells of a map as rectangles, which may overlap.

    Args:
        filename: The YAML file of the map.
        grain: Cells are joined to ones of about this size, in meters, which
            are occupied if any of their parts is; 0 keeps them.

    Returns:
        Boxes in the frame of the map, in meters: the largest first.

    Raises:
        MapError: If a file cannot be read, or is no map.
    """
    path = Path(filename)
    settings = _settings(path)
    resolution = _number(path, settings, "resolution")
    if not 0 < resolution <= 10:
        raise MapError(
            f"{path}: resolution must be in (0, 10] m, got {resolution:g}"
        )
    origin = settings.get("origin")
    if not (isinstance(origin, list) and len(origin) in (2, 3)) or not all(
        _is_number(value) for value in origin
    ):
        raise MapError(
            f"{path}: origin must be [x, y, yaw] of the lower left corner,"
            f" got {origin!r:.60}"
        )
    occupied = _occupied(path, settings)
    factor = max(1, round(grain / resolution)) if grain > 0 else 1
    occupied = _joined(occupied, factor)
    size = resolution * factor
    x, y, yaw = (*map(float, origin), 0.0)[:3]
    c, s = math.cos(yaw), math.sin(yaw)
    boxes = []
    for left, bottom, right, top in rectangles(occupied):
        u, v = (left + right) / 2 * size, (bottom + top) / 2 * size
        boxes.append(
            Box(
                center=_rounded(x + c * u - s * v, y + s * u + c * v),
                size=_rounded((right - left) * size, (top - bottom) * size),
                yaw=yaw,
            )
        )
    return boxes


def rectangles(occupied: Mask) -> Iterator[tuple[int, int, int, int]]:
    """Covers cells with few rectangles, each the largest that is left.

    Args:
        occupied: Shape (rows, columns).

    Returns:
        Each as its first column and row, and the column and row behind it.
    """
    found = np.array(list(_maximal(occupied)), dtype=np.int64).reshape(-1, 4)
    left, low, right, high = found.T
    missing = occupied.astype(np.int64)
    while len(found):
        # The sums of all cells below and to the left.
        sums = np.pad(missing.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
        gains = (
            sums[high, right]
            - sums[low, right]
            - sums[high, left]
            + sums[low, left]
        )
        best = int(gains.argmax())
        if gains[best] == 0:
            return
        a, b, c, d = found[best].tolist()
        yield a, b, c, d
        missing[b:d, a:c] = 0


def _maximal(occupied: Mask) -> Iterator[tuple[int, int, int, int]]:
    """Finds the rectangles of occupied cells that do not fit into wider ones.

    For each row, those that end with it: as high as the lowest of the columns
    of cells above, and as wide as these are.
    """
    heights = np.zeros(occupied.shape[1], dtype=np.int64)
    for row, cells in enumerate(occupied):
        heights = np.where(cells, heights + 1, 0)
        if not cells.any():
            continue
        begun: list[tuple[int, int]] = []
        for column, height in enumerate([*heights.tolist(), 0]):
            first = column
            while begun and begun[-1][1] >= height:
                first, tall = begun.pop()
                if tall > height:
                    yield first, row + 1 - tall, column, row + 1
            if height:
                begun.append((first, height))


def _rounded(u: float, v: float) -> tuple[float, float]:
    """Returns lengths to the nanometer, without the digits of rounding."""
    return round(u, 9), round(v, 9)


def _joined(occupied: Mask, factor: int) -> Mask:
    """Joins cells to squares that are occupied if one of them is."""
    rows, columns = occupied.shape
    padded = np.pad(occupied, ((0, -rows % factor), (0, -columns % factor)))
    shape = (len(padded) // factor, factor, padded.shape[1] // factor, factor)
    joined: Mask = padded.reshape(shape).any(axis=(1, 3))
    return joined


def _settings(path: Path) -> dict[str, Any]:
    try:
        settings = yaml.safe_load(path.read_bytes())
    except OSError as error:
        raise MapError(f"{path}: {error.strerror}") from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        line = " ".join(str(error).split())
        raise MapError(f"{path}: is not YAML: {line:.200}") from error
    if not isinstance(settings, dict):
        raise MapError(f"{path}: must be a mapping, as of a map of map_server")
    return settings


def _is_number(value: Any) -> TypeGuard[float]:
    return type(value) in (int, float) and math.isfinite(value)


def _number(
    path: Path, settings: dict[str, Any], key: str, default: float | None = None
) -> float:
    value = settings.get(key, default)
    if not _is_number(value):
        raise MapError(f"{path}: {key} must be a number, got {value!r:.60}")
    return float(value)


def _occupied(path: Path, settings: dict[str, Any]) -> Mask:
    """Returns which cells are occupied, from the lowest row up."""
    name = settings.get("image")
    if not isinstance(name, str) or not name:
        raise MapError(f"{path}: image must be the name of a file")
    threshold = _number(path, settings, "occupied_thresh", 0.65)
    image_path = path.parent / name
    try:
        with Image.open(image_path) as image:
            if image.width * image.height > MAX_CELLS:
                raise MapError(f"{image_path}: has more than {MAX_CELLS} cells")
            # (Images of 16 bits are of mode I.)
            is_deep = image.mode.startswith("I")
            gray = np.asarray(image if is_deep else image.convert("L"))
            gray = gray / (65535 if is_deep else 255)
    except (UnidentifiedImageError, Image.DecompressionBombError) as error:
        raise MapError(f"{image_path}: is no image of a map") from error
    except MapError:
        raise
    except (OSError, ValueError) as error:
        what = getattr(error, "strerror", None) or error
        raise MapError(f"{image_path}: {what}") from error
    dark = gray if settings.get("negate") in (1, True) else 1 - gray
    occupied: Mask = (dark > threshold)[::-1]
    return occupied
