"""Reads maps of ROS 2's map_server: the occupied and the free cells.

A map is a YAML file with the name of an image, the size of its cells and the
position of its lower left corner; and the image, in which dark is occupied. The
rules are those of nav2_map_server ("Map Server", https://docs.nav2.org).
"""

from dataclasses import dataclass
import functools
from pathlib import Path
import sys
from typing import Any, TypeGuard
import warnings

import numpy as np
from PIL import Image, UnidentifiedImageError
import yaml

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.schema import MAX_COORDINATE
from hunav_drake.systems.common.suggest import shown, suggestion
from hunav_drake.systems.world.maps.outlines import outlines
from hunav_drake.systems.world.solids import WorldFileError, turned

# The largest number of cells of a map: 250 m x 250 m in cells of 5 cm.
MAX_CELLS = 25_000_000

# The largest size of the YAML file of a map, in bytes.
_MAX_BYTES = 100_000

_MODES = ("trinary", "scale", "raw")

# The keys of map_server, and those of others who read its maps: `map_id` of
# multi_map_server, `map_type` of Nav2.
_KEYS = (
    *("image", "resolution", "origin", "negate", "occupied_thresh"),
    *("free_thresh", "mode", "map_id", "map_type"),
)


class MapError(WorldFileError):
    """A map cannot be read; the text says where and why."""


@dataclass(frozen=True, eq=False)
class CellMap:
    """A grid of cells that are occupied, free, or unknown.

    Attributes:
        occupied: Shape (rows, columns), from the lowest row up.
        free: Likewise.
        resolution: The side of a cell, in meters.
        origin: The pose (x, y, yaw) in W of the outer corner of the first
            cell, in meters and radians; columns go along its x.
    """

    occupied: Mask
    free: Mask
    resolution: float
    origin: tuple[float, float, float]


def read_map(filename: str | Path) -> CellMap:
    """Reads the cells of a map.

    The modes "trinary" and "scale" give the same occupied cells (more than
    `occupied_thresh`) and free cells (less than `free_thresh`); in the mode
    "raw", pixels are occupancies in percent. Transparent pixels are unknown.

    Args:
        filename: The YAML file of the map.

    Raises:
        MapError: If a file cannot be read, or is not a map.
    """
    path = Path(filename)
    settings = _settings(path)
    resolution = _number(path, settings, "resolution")
    if not 0 < resolution <= 10:
        raise MapError(
            f"{path}: resolution must be in (0, 10] m, got {resolution:g}"
        )
    origin = _origin(path, settings.get("origin"))
    occupied, free = _cells(path, settings)
    return CellMap(occupied, free, resolution, origin)


def map_outlines(filename: str | Path) -> tuple[Array, ...]:
    """Returns polygons around the occupied cells of a map, in W, in meters.

    Those of the maps read last are cached, as long as the files do not change.

    Raises:
        MapError: If a file cannot be read, or is not a map.
    """
    path = Path(filename).absolute()
    stamps = []
    for file in (path, path.parent / str(_settings(path).get("image"))):
        try:
            stat = file.stat()
            stamps.append((stat.st_mtime_ns, stat.st_size))
        except (OSError, ValueError):
            stamps.append((0, 0))
    return _map_outlines(path, tuple(stamps))


@functools.lru_cache(maxsize=8)
def _map_outlines(path: Path, stamps: tuple[Any, ...]) -> tuple[Array, ...]:
    try:
        return outlines_of(read_map(path))
    except ValueError as error:
        if isinstance(error, MapError):
            raise
        raise MapError(f"{path}: {error}") from error


def outlines_of(cells: CellMap) -> tuple[Array, ...]:
    """Returns polygons around the occupied cells, in W, in meters.

    Raises:
        ValueError: If they have too many sides: see `outlines`.
    """
    found = outlines(cells.occupied)
    # To the nanometer, without the digits of rounding.
    result = tuple(
        turned(outline * cells.resolution, cells.origin).round(9)
        for outline in found
    )
    for outline in result:
        outline.setflags(write=False)
    return result


def _settings(path: Path) -> dict[str, Any]:
    try:
        with path.open("rb") as file:
            content = file.read(_MAX_BYTES + 1)
        if len(content) > _MAX_BYTES:
            raise MapError(
                f"{path}: must have at most {_MAX_BYTES} bytes; give the YAML"
                " file of a map, not its image"
            )
        settings = yaml.safe_load(content)
    except OSError as error:
        raise MapError(f"{path}: {error.strerror}") from error
    except MapError:
        raise
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        line = " ".join(str(error).split())
        raise MapError(f"{path}: is not YAML: {line:.200}") from error
    if not isinstance(settings, dict):
        raise MapError(f"{path}: must be a mapping, as of a map of map_server")
    for key in settings:
        if key not in _KEYS:
            raise MapError(
                f"{path}: unknown key {shown(key)};"
                f" {suggestion(str(key), _KEYS)}"
            )
    return settings


def _is_number(value: Any) -> TypeGuard[float]:
    # An int may have too many digits for a float.
    return type(value) in (int, float) and abs(value) <= sys.float_info.max


def _number(
    path: Path, settings: dict[str, Any], key: str, default: float | None = None
) -> float:
    value = settings.get(key, default)
    if not _is_number(value):
        raise MapError(f"{path}: {key} must be a number, got {value!r:.60}")
    return float(value)


def _origin(path: Path, value: Any) -> tuple[float, float, float]:
    if (
        not isinstance(value, list)
        or len(value) not in (2, 3)
        or not all(_is_number(it) for it in value)
        or max(map(abs, value)) > MAX_COORDINATE
    ):
        raise MapError(
            f"{path}: origin must be [x, y, yaw] of the lower left corner, at"
            f" most {MAX_COORDINATE:g} m away, got {value!r:.60}"
        )
    x, y, yaw = (*map(float, value), 0.0)[:3]
    return x, y, yaw


def _thresholds(path: Path, settings: dict[str, Any]) -> tuple[float, float]:
    """Returns the thresholds of occupied and of free cells."""
    occupied = _number(path, settings, "occupied_thresh", 0.65)
    free = _number(path, settings, "free_thresh", min(0.25, occupied))
    if not 0 <= free <= occupied <= 1:
        raise MapError(
            f"{path}: must have 0 <= free_thresh <= occupied_thresh <= 1, got"
            f" {free:g} and {occupied:g}"
        )
    return occupied, free


def _cells(path: Path, settings: dict[str, Any]) -> tuple[Mask, Mask]:
    """Returns the occupied and the free cells, from the lowest row up."""
    threshold, free_threshold = _thresholds(path, settings)
    mode = settings.get("mode", "trinary")
    if str(mode).lower() not in _MODES:
        raise MapError(
            f"{path}: mode must be one of {', '.join(_MODES)}, got {mode!r:.60}"
        )
    negate = settings.get("negate", 0)
    if negate not in (0, 1):
        raise MapError(f"{path}: negate must be 0 or 1, got {negate!r:.60}")
    name = settings.get("image")
    if not isinstance(name, str) or not name:
        raise MapError(f"{path}: image must be the name of a file")
    gray, known, top = _pixels(path.parent / name)
    # The occupancy of each pixel value.
    levels = np.arange(top + 1)
    if str(mode).lower() == "raw":
        # (Like map_server, it rounds 16 bits to 8.)
        percent = np.round(levels * 255 / top)
        occupancy = np.where(percent <= 100, percent / 100, np.nan)
    else:
        occupancy = levels / top if negate else 1 - levels / top
    occupied = (occupancy > threshold)[gray] & known
    free = (occupancy < free_threshold)[gray] & known
    return occupied[::-1], free[::-1]


def _pixels(path: Path) -> tuple[np.ndarray, Mask, int]:
    """Returns gray values, which pixels are opaque, and the white value."""
    try:
        with warnings.catch_warnings():
            # Sizes are checked here, before anything is decoded.
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            opened = Image.open(path)
        with opened:
            image: Image.Image = opened
            if image.width * image.height > MAX_CELLS:
                raise Image.DecompressionBombError
            known = np.ones((image.height, image.width), dtype=bool)
            if image.mode.startswith("I"):
                deep = np.clip(np.asarray(image), 0, 65535).astype(np.uint16)
                return deep, known, 65535
            if image.has_transparency_data:
                image = image.convert("RGBA")
                known = np.asarray(image.getchannel("A")) == 255
            if image.mode in ("1", "L", "LA"):
                return np.asarray(image.convert("L")), known, 255
            # (Of colors, map_server takes the mean.)
            mean = np.asarray(image.convert("RGB")).mean(axis=2)
            return mean.round().astype(np.uint8), known, 255
    except Image.DecompressionBombError as error:
        raise MapError(
            f"{path}: must have at most {MAX_CELLS} pixels; cut it, or make"
            " its cells larger"
        ) from error
    except UnidentifiedImageError as error:
        raise MapError(f"{path}: is no image of a map") from error
    except (OSError, ValueError, SyntaxError, EOFError) as error:
        what = getattr(error, "strerror", None) or error
        raise MapError(f"{path}: {what}") from error
