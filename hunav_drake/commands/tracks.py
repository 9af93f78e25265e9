"""The command `hunav tracks`."""

import argparse
from collections.abc import Callable
import contextlib
import math
from pathlib import Path
from typing import TYPE_CHECKING

from hunav_drake.commands.errors import DONE, check_output, input_errors
from hunav_drake.systems.common.input_error import InputError

if TYPE_CHECKING:
    from hunav_drake.systems.common.arrays import Array
    from hunav_drake.systems.people.tracks import Tracks

_PICTURES = (".png", ".svg", ".pdf")


def add_tracks_options(tracks: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav tracks`."""
    tracks.description = (
        "Prints what is in a file of recorded people, draws it, and converts"
        " it. The options apply in this order: axes, time, gaps, smoothing,"
        " period."
    )
    tracks.set_defaults(function=_tracks)
    tracks.add_argument("file", type=Path, help="the file")
    tracks.add_argument(
        "--format",
        metavar="NAME",
        default="auto",
        help="csv, petrack, jupedsim, eth, ucy, ucy_vsp or trajnet (default:"
        " its content tells)",
    )
    tracks.add_argument(
        "--fps",
        type=_number(above=0.0),
        metavar="N",
        help="frames per second, where the file does not say",
    )
    tracks.add_argument(
        "--unit", metavar="U", help="m, cm or mm, where the file does not say"
    )
    tracks.add_argument(
        "--homography",
        type=Path,
        metavar="FILE",
        help="a text of 3 x 3 numbers that take pixels to meters",
    )
    tracks.add_argument("--swap", action="store_true", help="exchange x and y")
    tracks.add_argument("--flip", action="store_true", help="mirror y")
    tracks.add_argument(
        "--rotate",
        type=_number(),
        default=0.0,
        metavar="DEG",
        help="turn the tracks counterclockwise about the origin, in degrees",
    )
    tracks.add_argument(
        "--shift",
        type=_number(),
        nargs=2,
        default=(0.0, 0.0),
        metavar=("X", "Y"),
        help="displace the tracks, in meters",
    )
    tracks.add_argument(
        "--from",
        dest="start",
        type=_number(),
        metavar="T",
        help="keep what is later, in seconds; it becomes 0 s",
    )
    tracks.add_argument(
        "--to",
        dest="end",
        type=_number(),
        default=math.inf,
        metavar="T",
        help="keep what is earlier, in seconds",
    )
    tracks.add_argument(
        "--gap",
        type=_number(above=0.0),
        default=1.0,
        metavar="S",
        help="who is missing for longer returns as another person (default: 1"
        " s)",
    )
    tracks.add_argument(
        "--smooth",
        type=_number(above=0.0),
        nargs="?",
        const=-1.0,
        metavar="SIGMA",
        help="take out noise of this standard deviation, in meters (default:"
        " as estimated)",
    )
    tracks.add_argument(
        "--period",
        type=_number(above=0.0),
        metavar="S",
        help="sample the tracks at the multiples of a period, in seconds",
    )
    tracks.add_argument(
        "--plot",
        type=Path,
        metavar="FILE",
        help="draw the paths to a .png, .svg or .pdf",
    )
    tracks.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="write the tracks"
    )
    tracks.add_argument(
        "--as",
        dest="written",
        metavar="NAME",
        default="csv",
        help="the format to write (default: csv)",
    )
    tracks.add_argument(
        "--force", action="store_true", help="overwrite existing files"
    )


def _number(above: float = -math.inf) -> Callable[[str], float]:
    """Returns a parser of finite numbers above another one."""

    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and value > above):
            rule = "" if above == -math.inf else f" above {above:g}"
            raise argparse.ArgumentTypeError(
                f"must be a finite number{rule}, got {text!r}"
            )
        return value

    return parse


def _tracks(options: argparse.Namespace) -> int:
    from hunav_drake.tracks.facts import describe_tracks, tracks_text
    from hunav_drake.tracks.files import ReadTracks, WriteTracks

    for path in (options.plot, options.output):
        if path is not None:
            check_output(path, options.force)
    if options.plot is not None and options.plot.suffix not in _PICTURES:
        raise InputError(
            f"--plot {options.plot}: must end in {', '.join(_PICTURES)}"
        )
    with input_errors(ValueError):
        homography = _matrix(options.homography)
        written = "csv" if options.output is None else options.written
        read = _format_of(options)
        # (A csv has times: then the rate is that of the file to write.)
        fps = None if written != "csv" and read == "csv" else options.fps
        # (Only one of the two files need have pixels.)
        to_pixels = written == "ucy_vsp"
        tracks = ReadTracks(
            options.file,
            options.format,
            fps=fps,
            unit=options.unit,
            homography=None if to_pixels and read != "ucy_vsp" else homography,
        ).moved(
            rotate=math.radians(options.rotate),
            shift=tuple(options.shift),
            swap=options.swap,
            flip=options.flip,
        )
        if options.start is not None or math.isfinite(options.end):
            start = -math.inf if options.start is None else options.start
            tracks = tracks.between(start, options.end)
            if not tracks.people:
                begin = "" if options.start is None else f" from {start:g} s on"
                raise ValueError(
                    f"{options.file}: nobody is there{begin} until"
                    f" {options.end:g} s"
                )
        tracks = tracks.split(options.gap)
        if options.smooth is not None:
            sigma = options.smooth
            tracks = tracks.smoothed(None if sigma < 0 else sigma)
        if options.period is not None:
            tracks = tracks.resampled(options.period)
            if not tracks.people:
                raise ValueError(
                    f"--period: nobody is there at a multiple of"
                    f" {options.period:g} s; give a shorter one"
                )
        if options.output is not None:
            WriteTracks(
                tracks,
                options.output,
                options.written,
                fps=options.fps,
                homography=homography if to_pixels else None,
            )
    print(tracks_text(describe_tracks(tracks)))
    if options.plot is not None:
        _plot(tracks, options.plot)
    for path in (options.plot, options.output):
        if path is not None:
            print(f"Wrote {path}")
    return DONE


def _format_of(options: argparse.Namespace) -> str | None:
    """Returns the format of the file that is read; None if it has none."""
    from hunav_drake.tracks.formats import find_format

    if options.format != "auto":
        return str(options.format)
    # (Reading tells what is wrong with the file.)
    with contextlib.suppress(ValueError):
        return find_format(options.file)
    return None


def _matrix(path: Path | None) -> "Array | None":
    """Returns the homography in a file, if there is one."""
    import numpy as np

    if path is None:
        return None
    try:
        numbers = [float(word) for word in path.read_text().split()]
        matrix: Array = np.array(numbers).reshape(3, 3)
    except ValueError as error:
        raise ValueError(
            f"--homography {path}: must be 3 rows of 3 numbers: {error}"
        ) from error
    return matrix


def _plot(tracks: "Tracks", path: Path) -> None:
    from hunav_drake.report.plots.tracks import plot_tracks
    from hunav_drake.systems.common.files import atomic_write

    axes = plot_tracks(tracks)
    with input_errors(place=path), atomic_write(path) as file:
        axes.figure.savefig(file, format=path.suffix[1:], dpi=200)
