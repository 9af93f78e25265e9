"""A map or a picture under the scenario, to draw walls after it."""

import base64
import binascii
from collections.abc import Mapping
import dataclasses as dc
import io
from pathlib import Path, PurePosixPath, PureWindowsPath
import tempfile
from typing import Any
import warnings

import numpy as np
from PIL import Image, UnidentifiedImageError

from hunav_drake.systems.common.arrays import Mask
from hunav_drake.systems.common.schema import MAX_COORDINATE
from hunav_drake.systems.world.maps.map_file import (
    MAX_CELLS,
    MapError,
    read_map,
)

# How large a pixel of a picture is until somebody says so, in meters.
_USUAL_CELL = 0.05

# What is darker is a wall, in pictures that are no maps.
_DARK = 100

# What the page shows has at most so many pixels along a side.
_MAX_SIDE = 4096


class BackgroundError(ValueError):
    """Files are no map and no picture; the text says why."""


@dc.dataclass(frozen=True, eq=False)
class Background:
    """A picture in the world, and its dark cells.

    Attributes:
        name: What it is called.
        image: The picture as an URL of data.
        occupied: Shape (rows, columns), from the lowest row up.
        cell: The length of a side of a cell, in meters.
        origin: The pose (x, y, yaw) in W of the lower left corner.
        is_map: Whether a map says how large it is.
    """

    name: str
    image: str
    occupied: Mask
    cell: float
    origin: tuple[float, float, float]
    is_map: bool

    def placed(
        self, width: float, origin: tuple[float, float, float]
    ) -> "Background":
        """Returns it with another width, in meters, and another pose."""
        cell = width / self.occupied.shape[1]
        return dc.replace(self, cell=cell, origin=origin)

    def message(self) -> dict[str, Any]:
        """Returns what the page needs to show it."""
        rows, columns = self.occupied.shape
        return {
            "image": self.image,
            "width_m": columns * self.cell,
            "height_m": rows * self.cell,
            "origin": list(self.origin),
            "name": self.name,
            "is_map": self.is_map,
        }


def read_background(files: Mapping[str, str], name: str = "") -> Background:
    """Makes a background of files that were dropped on the page.

    Args:
        files: The YAML file and the image of a map of ROS 2, or one image, by
            their names; each in base64.
        name: What it is called.

    Raises:
        BackgroundError: If they are neither.
    """
    content = {_plain_name(key): _decoded(key, files[key]) for key in files}
    maps = [key for key in content if key.lower().endswith((".yaml", ".yml"))]
    if len(maps) > 1 or not content:
        raise BackgroundError(
            "give the YAML file and the image of one map, or one image"
        )
    if not maps:
        if len(content) > 1:
            raise BackgroundError(
                "several images, and no YAML file of a map; give one image"
            )
        (key,) = content
        return _picture(name or key, content[key])
    with tempfile.TemporaryDirectory() as folder:
        for key, data in content.items():
            (Path(folder) / key).write_bytes(data)
        try:
            return map_background(Path(folder) / maps[0], name or maps[0])
        except BackgroundError as error:
            words = str(error).replace(f"{folder}/", "")
            raise BackgroundError(words) from error


def map_background(filename: str | Path, name: str = "") -> Background:
    """Makes a background of a map of ROS 2.

    Args:
        filename: Its YAML file.
        name: What it is called; by default as the file.

    Raises:
        BackgroundError: If it is no map.
    """
    path = Path(filename)
    try:
        cells = read_map(path)
    except MapError as error:
        raise BackgroundError(str(error)) from error
    # As RViz shows it: what is known free is white, what is not gray.
    gray = np.full(cells.occupied.shape, 205, np.uint8)
    gray[cells.free] = 254
    gray[cells.occupied] = 0
    return Background(
        name=name or path.name,
        image=_url(Image.fromarray(gray[::-1])),
        occupied=cells.occupied,
        cell=cells.resolution,
        origin=cells.origin,
        is_map=True,
    )


def _picture(name: str, data: bytes) -> Background:
    try:
        with warnings.catch_warnings():
            # Sizes are judged here, before anything is decoded.
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            opened = Image.open(io.BytesIO(data))
        with opened:
            if opened.width * opened.height > MAX_CELLS:
                raise BackgroundError(
                    f"{name} has more than {MAX_CELLS} pixels; make it smaller"
                )
            image = opened.convert("RGBA")
    except UnidentifiedImageError as error:
        raise BackgroundError(
            f"{name} is no picture; PNG, JPEG and PGM are read"
        ) from error
    except (OSError, ValueError, SyntaxError, EOFError) as error:
        raise BackgroundError(f"{name}: {error}") from error
    except Image.DecompressionBombError as error:
        raise BackgroundError(f"{name} is too large") from error
    white = Image.new("RGBA", image.size, "white")
    white.alpha_composite(image)
    dark = np.asarray(white.convert("L")) < _DARK
    return Background(
        name=name,
        image=_url(image),
        occupied=dark[::-1],
        cell=_USUAL_CELL,
        origin=(0.0, 0.0, 0.0),
        is_map=False,
    )


def checked_place(
    width: float | None, origin: list[float] | None
) -> tuple[float, tuple[float, float, float]] | None:
    """Returns where a view has put a background; None if it said nothing.

    Raises:
        BackgroundError: If that is no place.
    """
    if width is None or origin is None:
        return None
    is_near = all(abs(it) <= MAX_COORDINATE for it in origin)
    is_pose = len(origin) == 3 and is_near
    if not (0.01 <= width <= MAX_COORDINATE and is_pose):
        raise BackgroundError(
            "a background has a width in meters, and an origin [x, y, yaw]"
        )
    x, y, yaw = origin
    return width, (x, y, yaw)


def _url(image: Image.Image) -> str:
    image.thumbnail((_MAX_SIDE, _MAX_SIDE))
    buffer = io.BytesIO()
    image.save(buffer, "PNG")
    text = base64.b64encode(buffer.getvalue()).decode()
    return f"data:image/png;base64,{text}"


def _plain_name(name: str) -> str:
    """Returns the last part of a name, whoever's separators it has."""
    plain = PureWindowsPath(PurePosixPath(name).name).name
    if not plain or plain in (".", "..") or not plain.isprintable():
        raise BackgroundError(f"{name!r:.60} is no file name")
    return plain[-200:]


def _decoded(name: str, text: str) -> bytes:
    try:
        # An URL of data has its type before the comma.
        return base64.b64decode(text.rpartition(",")[2], validate=True)
    except (binascii.Error, ValueError) as error:
        raise BackgroundError(f"{name!r:.60} is not in base64") from error
