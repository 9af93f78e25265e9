"""The command `hunav render`."""

import argparse
import os
from pathlib import Path
import re
from typing import TYPE_CHECKING

from hunav_drake.commands.errors import DONE, check_output, input_errors
from hunav_drake.commands.options import (
    add_import_option,
    overlay_names,
    progress_bar,
    whole_number,
)
from hunav_drake.systems.common.input_error import InputError

if TYPE_CHECKING:
    from hunav_drake.systems.scene.scene_config import Overlay

_VIEWS = ("perspective", "top", "follow", "plot")


def add_render_options(render: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav render`."""
    render.description = (
        "Renders a film of a recorded run, as .mp4 or .gif, or a picture of one"
        " instant, as .png. It needs no browser."
    )
    render.set_defaults(function=_render)
    render.add_argument(
        "run",
        type=Path,
        help="the folder of a run (see `hunav run --out`), or a recording",
    )
    render.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        help="the film to write: its name ends in .mp4, .gif or .png",
    )
    render.add_argument(
        "--force", action="store_true", help="overwrite an existing file"
    )
    render.add_argument(
        "--view",
        choices=_VIEWS,
        default="perspective",
        help="the position of the camera; plot: a drawing from above (default:"
        " perspective)",
    )
    render.add_argument(
        "--size",
        type=_size,
        metavar="WxH",
        help="width and height in pixels (default: 1280x720, of a .gif"
        " 736x414)",
    )
    render.add_argument(
        "--fps",
        type=float,
        help="frames per second (default: 25, of a .gif 15)",
    )
    render.add_argument(
        "--speed",
        type=float,
        default=1.0,
        help="the speed relative to real time (default: 1)",
    )
    render.add_argument(
        "--from",
        dest="start",
        type=float,
        metavar="T",
        help="the time of the first frame, in seconds",
    )
    render.add_argument(
        "--to",
        dest="end",
        type=float,
        metavar="T",
        help="the time of the last frame, in seconds",
    )
    render.add_argument(
        "--at",
        type=float,
        metavar="T",
        help="for .png: the time of the picture, in seconds (default: the"
        " start)",
    )
    render.add_argument(
        "--overlays",
        type=_film_overlays,
        metavar="NAMES",
        help="the overlays to draw, separated by commas, or all, or none"
        " (default: those of the scenario)",
    )
    render.add_argument(
        "--no-shadows", action="store_true", help="draw no shadows: faster"
    )
    render.add_argument(
        "--workers",
        type=whole_number(1),
        help="the number of processes; it does not change the film (default:"
        " one per processor)",
    )
    render.add_argument(
        "--quiet", action="store_true", help="show no progress bar"
    )
    add_import_option(render)


def _size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text)
    if not match:
        raise argparse.ArgumentTypeError(
            f"must be width x height in pixels, as in 640x360, got {text!r}"
        )
    return int(match[1]), int(match[2])


def _film_overlays(text: str) -> list["Overlay"]:
    from hunav_drake.systems.scene.scene_config import NOT_RECORDED

    names = overlay_names(text)
    return [it for it in names if text != "all" or it not in NOT_RECORDED]


def _render(options: argparse.Namespace) -> int:
    output: Path = options.output
    still = output.suffix.lower() == ".png"
    if still and (options.start is not None or options.end is not None):
        raise InputError(
            f"--output {output}: a .png shows one instant: use --at instead of"
            " --from and --to"
        )
    if still and (options.fps is not None or options.speed != 1.0):
        raise InputError(
            f"--output {output}: a .png shows one instant, without --fps and"
            " --speed; leave them out, or write a .gif or .mp4"
        )
    if not still and options.at is not None:
        raise InputError(
            f"--at {options.at:g}: is only for a .png, got --output {output};"
            " films have --from and --to"
        )
    check_output(output, options.force)
    if not options.run.exists():
        raise InputError(
            f"{options.run}: there is no such file or folder; `hunav run"
            " SCENARIO --out DIR` writes one"
        )
    from hunav_drake.views.film import FilmConfig, RenderFilm

    config = FilmConfig(
        view=options.view,
        size=options.size,
        fps=options.fps,
        speed=options.speed,
        start=options.at if still else options.start,
        end=options.end,
        overlays=options.overlays,
        shadows=not options.no_shadows,
    )
    with (
        progress_bar("frames", options.quiet) as (_, show),
        input_errors(ValueError),
    ):
        path = RenderFilm(
            options.run,
            output,
            config,
            progress=show,
            workers=options.workers or os.cpu_count() or 1,
            imports=getattr(options, "imports", ()),
        )
    print(f"Wrote {path}")
    return DONE
