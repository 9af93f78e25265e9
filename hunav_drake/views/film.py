"""Films and pictures of recorded trials, without a browser."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
import os
from pathlib import Path

from PIL import Image

from hunav_drake.scenario.error import path_text
from hunav_drake.scenario.geometry import find_unseen
from hunav_drake.systems.scene.scene_config import NOT_RECORDED, Overlay
from hunav_drake.views.camera import View
from hunav_drake.views.film_files import (
    check_film_file,
    frame_times,
    gif_period,
    write_film,
)
from hunav_drake.views.recorded_trial import LoadRecordedTrial, RecordedTrial

# The limits of the size of pictures, in pixels.
_SMALLEST, _LARGEST = 64, 7680


@dataclass(frozen=True, kw_only=True)
class FilmConfig:
    """The options of a film of a recorded trial.

    Attributes:
        view: "perspective" (the whole scene, at an angle), "top" (from
            above), "follow" (the robot, or the first one), or "plot" (a drawing
            from above).
        size: Width and height, in pixels.
        fps: Pictures per second of the film.
        speed: The ratio of recorded time to time in the film.
        start: The time of the first picture, on the clock of the recording,
            in seconds; None for the beginning.
        end: That of the last picture; None for the end.
        overlays: The overlays; None for those of the scenario.
        shadows: Whether figures cast shadows, which takes longer.
    """

    view: View = "perspective"
    size: tuple[int, int] = (1280, 720)
    fps: float = 25.0
    speed: float = 1.0
    start: float | None = None
    end: float | None = None
    overlays: Sequence[Overlay] | None = None
    shadows: bool = True


def RenderFilm(
    run: str | os.PathLike[str],
    filename: str | os.PathLike[str],
    config: FilmConfig | None = None,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Films a recorded trial.

    Args:
        run: See `LoadRecordedTrial`.
        filename: The film, a .mp4 or .gif file; or a .png picture of the time
            `config.start`.
        config: The options of the film.
        progress: Called after each picture with the number of pictures so far
            and the total number.

    Returns:
        The absolute path of the film.

    Raises:
        OSError: If there is no recording, or if the film cannot be written.
        ValueError: If the recording cannot be read, if a value of the
            configuration is out of its range, if a mesh of a model cannot be
            rendered, or if a film of the file's type cannot be written.
    """
    config = config or FilmConfig()
    path = Path(filename).resolve()
    check_film_file(path, config.size)
    _check_numbers(config)
    trial = LoadRecordedTrial(Path(run))
    # A drawing shows only outlines.
    unseen = (
        it
        for robot in trial.robots.values()
        for it in find_unseen(trial.world, robot)
    )
    for loc, fault in () if config.view == "plot" else unseen:
        raise ValueError(
            f"{run}: {path_text(None, loc)}: no film can show it: {fault};"
            " export its meshes with normals, or take --view plot"
        )
    overlays = _overlays(trial, config)
    times = _times(trial, config, path.suffix.lower())
    pictures = _pictures(trial, config, overlays, times)
    if progress is not None:
        pictures = _counted(pictures, len(times), progress)
    write_film(path, pictures, config.fps)
    return path


def _check_numbers(config: FilmConfig) -> None:
    rules = [
        ("width", config.size[0], _SMALLEST, _LARGEST, "pixels"),
        ("height", config.size[1], _SMALLEST, _LARGEST, "pixels"),
        ("fps", config.fps, 0.1, 120.0, "pictures per second"),
        ("speed", config.speed, 0.01, 1000.0, ""),
    ]
    for name, value, low, high, unit in rules:
        if not low <= value <= high:
            raise ValueError(
                f"{name}: must be in [{low:g}, {high:g}] {unit}".rstrip()
                + f", got {value:g}"
            )


def _overlays(trial: RecordedTrial, config: FilmConfig) -> list[Overlay]:
    if config.overlays is None:
        return [it for it in trial.scene.overlays if it not in NOT_RECORDED]
    for overlay in config.overlays:
        if overlay in NOT_RECORDED:
            raise ValueError(
                f"overlays: {overlay!r} is not in recordings, and so in no"
                " film; the replay and the live view show it"
            )
    return list(config.overlays)


def _times(
    trial: RecordedTrial, config: FilmConfig, suffix: str
) -> list[float]:
    """Returns the times of the pictures, on the clock of the recording."""
    first, last = (float(t) for t in trial.recording.times[[0, -1]])
    start = first if config.start is None else config.start
    end = last if config.end is None else config.end
    for name, time in (("the first picture", start), ("the last", end)):
        if not first - 1e-9 <= time <= last + 1e-9:
            raise ValueError(
                f"the time of {name} must be in the recording, [{first:g},"
                f" {last:g}] s, got {time:g} s"
            )
    if suffix == ".png":
        return [start]
    if end < start:
        raise ValueError(
            "the time of the last picture must not be before the first, got"
            f" {end:g} s and {start:g} s"
        )
    period = 1.0 / config.fps
    if suffix == ".gif":
        period = gif_period(config.fps) / 1000.0
    return frame_times(start, end, config.speed * period)


def _pictures(
    trial: RecordedTrial,
    config: FilmConfig,
    overlays: list[Overlay],
    times: list[float],
) -> Iterator[Image.Image]:
    if config.view == "plot":
        from hunav_drake.views.plan_view import PlanView

        plan = PlanView(trial, overlays, config.size)
        yield from map(plan.Draw, times)
        return
    from hunav_drake.views.film_overlays import FilmOverlays
    from hunav_drake.views.film_scene import FilmScene

    step = times[1] - times[0] if len(times) > 1 else 1.0 / config.fps
    scene = FilmScene(
        trial,
        config.view,
        config.size,
        start=times[0],
        step=step,
        shadows=config.shadows,
    )
    drawn = FilmOverlays(trial, overlays)
    for _ in times:
        yield drawn.Draw(scene.Take())


def _counted(
    pictures: Iterator[Image.Image],
    total: int,
    progress: Callable[[int, int], None],
) -> Iterator[Image.Image]:
    for count, picture in enumerate(pictures, 1):
        yield picture
        progress(count, total)
