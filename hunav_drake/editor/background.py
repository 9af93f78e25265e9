"""A map or a picture as background, to draw walls from."""

import base64
import binascii
from collections.abc import Mapping
import dataclasses as dc
from functools import cached_property
import io
from pathlib import Path, PurePosixPath, PureWindowsPath
import tempfile
from typing import Any
import warnings

import numpy as np
from PIL import Image, UnidentifiedImageError

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.schema import MAX_COORDINATE
from hunav_drake.systems.world.maps.map_file import (
    MAX_CELLS,
    MapError,
    read_map,
)

# The default size of a pixel, in meters.
_USUAL_CELL = 0.05

# Pixels of a picture that are darker than this are walls.
_DARK = 100

# How many dark cells stand for all of them.
_SAMPLE = 500

# The maximum width and height of the image on the page, in pixels.
_MAX_SIDE = 4096


class BackgroundError(ValueError):
    """Files are neither a map nor a picture; the text says why."""


@dc.dataclass(frozen=True, eq=False)
class Background:
    """A picture in the world, and its dark cells.

    Attributes:
        name: Its name.
        image: The picture as a data URL.
        occupied: Shape (rows, columns), from the lowest row up.
        cell: The side length of a cell, in meters.
        origin: The pose (x, y, yaw) in W of the lower left corner.
        is_map: Whether it is a map, which has a size.
    """

    name: str
    image: str
    occupied: Mask
    cell: float
    origin: tuple[float, float, float]
    is_map: bool

    @cached_property
    def sample(self) -> Array:
        """Some of its dark cells: their centers (x, y), in cells."""
        cells = np.argwhere(self.occupied)
        if not len(cells):
            return np.zeros((0, 2))
        some = np.linspace(0, len(cells) - 1, _SAMPLE).astype(int)
        return np.asarray(cells[some][:, ::-1] + 0.5)

    def placed(
        self, width: float, origin: tuple[float, float, float]
    ) -> "Background":
        """Returns the background with a new width, in meters, and pose."""
        cell = width / self.occupied.shape[1]
        return dc.replace(self, cell=cell, origin=origin)

    def message(self) -> dict[str, Any]:
        """Returns the content of its message to the page."""
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
    """Returns the background of files that were dropped on the page.

    Args:
        files: The YAML file and the image of a map of ROS 2, or one image, by
            their names; each in base64.
        name: Its name.

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
                "there are several images without a YAML file; give one image"
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
    """Returns the background of a map of ROS 2.

    Args:
        filename: Its YAML file.
        name: Its name; by default that of the file.

    Raises:
        BackgroundError: If it is not a map.
    """
    path = Path(filename)
    try:
        cells = read_map(path)
    except MapError as error:
        raise BackgroundError(str(error)) from error
    # Colors as in RViz: free cells are white, unknown ones gray.
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
            # The size is checked here, before decoding.
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
            f"{name} is not a picture; use PNG, JPEG or PGM"
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
    """Returns the place of a background from a message, if it has one.

    Raises:
        BackgroundError: If it is invalid.
    """
    if width is None or origin is None:
        return None
    is_near = all(abs(it) <= MAX_COORDINATE for it in origin)
    is_pose = len(origin) == 3 and is_near
    if not (0.01 <= width <= MAX_COORDINATE and is_pose):
        raise BackgroundError(
            "a background needs a width in meters and an origin [x, y, yaw]"
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
    """Returns the last part of a path, of any operating system."""
    plain = PureWindowsPath(PurePosixPath(name).name).name
    if not plain or plain in (".", "..") or not plain.isprintable():
        raise BackgroundError(f"{name!r:.60} is not a file name")
    return plain[-200:]


def _decoded(name: str, text: str) -> bytes:
    try:
        # A data URL has its type before the comma.
        return base64.b64decode(text.rpartition(",")[2], validate=True)
    except (binascii.Error, ValueError) as error:
        raise BackgroundError(f"{name!r:.60} is not in base64") from error
