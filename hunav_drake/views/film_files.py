"""Writes pictures as a film: .mp4, .gif, or one .png."""

from collections.abc import Iterable, Iterator
from fractions import Fraction
import importlib.util
import itertools
import math
from pathlib import Path
from typing import BinaryIO

import numpy as np
from PIL import Image

from hunav_drake.systems.common.files import atomic_write
from hunav_drake.systems.scene.palette import REACTION, ROBOT_ACCENT, TOPS

SUFFIXES = (".gif", ".mp4", ".png")

# The colors of a GIF, at most 256: their number from samples of its first
# frames, and the shades of each color of shirts and signs.
_COLORS = 200
_SHADES = (1.0, 0.6)
_FIRST_FRAMES, _SAMPLES = 64, 8

# The quality of a film: lower values give better and larger files.
_RATE_FACTOR = "21"

# The number of threads that encode a film. With more, x264 gives now and then
# other bits of the same pictures; and they are drawn by several processes.
_THREADS = 1


def check_film_file(path: Path, size: tuple[int, int]) -> None:
    """Checks that a film can be written, before pictures are drawn.

    Raises:
        ValueError: If the suffix is unknown, if its writer is not installed,
            or if the size is not possible.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise ValueError(
            f"{path}: the name of a film must end in one of"
            f" {', '.join(SUFFIXES)}, got {path.suffix or 'none'!r}"
        )
    if suffix != ".mp4":
        return
    if importlib.util.find_spec("av") is None:
        raise ValueError(
            f"{path}: PyAV, which writes .mp4, is not installed; install it"
            " by `pip install 'hunav_drake[film]'` (or `pip install av`), or"
            " write a .gif"
        )
    if size[0] % 2 or size[1] % 2:
        raise ValueError(
            f"{path}: width and height of an .mp4 must be even, got"
            f" {size[0]}x{size[1]}"
        )


def write_film(path: Path, pictures: Iterable[Image.Image], fps: float) -> None:
    """Writes pictures of one size to a film; only the last one to a .png.

    The file is written atomically. `fps` is in pictures per second.

    Raises:
        OSError: If the file cannot be written.
    """
    write = {".gif": _write_gif, ".mp4": _write_mp4, ".png": _write_png}
    with atomic_write(path) as file:
        write[path.suffix.lower()](file, pictures, fps)


def gif_period(fps: float) -> int:
    """Returns the time of a frame of a GIF in ms, a multiple of 10 ms."""
    return max(10 * round(100 / fps), 20)


def _write_png(
    file: BinaryIO, pictures: Iterable[Image.Image], fps: float
) -> None:
    for picture in pictures:
        last = picture
    last.save(file, "PNG")


def _write_gif(
    file: BinaryIO, pictures: Iterable[Image.Image], fps: float
) -> None:
    rest: Iterator[Image.Image] = iter(pictures)
    first = list(itertools.islice(rest, _FIRST_FRAMES))
    palette = _palette(first[:: math.ceil(len(first) / _SAMPLES)])
    frames = (
        picture.quantize(palette=palette, dither=Image.Dither.NONE)
        for picture in itertools.chain(first, rest)
    )
    next(frames).save(
        file,
        "GIF",
        save_all=True,
        append_images=frames,
        duration=gif_period(fps),
        loop=0,
        disposal=1,
        # Only what differs from the frame before is written.
        optimize=True,
    )


def _palette(pictures: list[Image.Image]) -> Image.Image:
    """Returns the palette of all frames: colors of samples and of all people.

    With one palette, objects at rest do not flicker.
    """
    thin = [
        np.asarray(picture)[::3, ::3].reshape(-1, 3) for picture in pictures
    ]
    colors, counts = np.unique(np.concatenate(thin), axis=0, return_counts=True)
    # The floor covers most of a picture, but must not take most colors.
    weighed = np.repeat(colors, np.ceil(counts**0.4).astype(int), axis=0)
    board = Image.fromarray(weighed[None])
    own = board.quantize(_COLORS, method=Image.Quantize.MEDIANCUT)
    values = (own.getpalette() or [])[: 3 * _COLORS]
    for color in (*TOPS, ROBOT_ACCENT, REACTION):
        for shade in _SHADES:
            rgb = (color.r(), color.g(), color.b())
            values += [round(255 * shade * c) for c in rgb]
    palette = Image.new("P", (1, 1))
    palette.putpalette(values)
    return palette


def _write_mp4(
    file: BinaryIO, pictures: Iterable[Image.Image], fps: float
) -> None:
    import av

    with av.open(file, "w", format="mp4") as container:
        stream = None
        for picture in pictures:
            if stream is None:
                rate = Fraction(fps).limit_denominator(1000)
                stream = container.add_stream("libx264", rate=rate)
                stream.width, stream.height = picture.size
                stream.pix_fmt = "yuv420p"
                stream.options = {"crf": _RATE_FACTOR, "preset": "medium"}
                stream.codec_context.thread_count = _THREADS
            frame = av.VideoFrame.from_image(picture)
            container.mux(stream.encode(frame))
        if stream is not None:
            container.mux(stream.encode())


def frame_times(start: float, end: float, step: float) -> list[float]:
    """Returns the times of frames from start to at most end, in s."""
    count = math.floor((end - start) / step + 1e-6) + 1
    return [start + k * step for k in range(count)]
