"""Films and pictures of recorded trials, without a browser."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import lru_cache
import os
from pathlib import Path

from PIL import Image

from hunav_drake.runs.worker_pool import WorkerPool
from hunav_drake.scenario.error import path_text
from hunav_drake.scenario.geometry import find_unseen
from hunav_drake.systems.common.checks import check_choice
from hunav_drake.systems.scene.scene_config import (
    NOT_RECORDED,
    OVERLAYS,
    Overlay,
)
from hunav_drake.views.camera import VIEWS, View
from hunav_drake.views.film_files import (
    check_film_file,
    frame_times,
    gif_period,
    write_film,
)
from hunav_drake.views.recorded_trial import LoadRecordedTrial, RecordedTrial

# The limits of the size of pictures, in pixels.
_SMALLEST, _LARGEST = 64, 7680

# The usual size and pictures per second: of a .gif, which takes much room, and
# of other files.
_GIF_SIZE, _GIF_FPS = (736, 414), 15.0
_SIZE, _FPS = (1280, 720), 25.0

# A process draws so many pictures one after the other, and starts for so many.
_CHUNK, _LEAST = 4, 16

# Draws a picture of a film, by its number; numbers only rise.
_Draw = Callable[[int], Image.Image]


@dataclass(frozen=True, kw_only=True)
class FilmConfig:
    """The options of a film of a recorded trial.

    Attributes:
        view: "perspective" (the whole scene, at an angle), "top" (from
            above), "follow" (the robot, or the first one), or "plot" (a drawing
            from above).
        size: Width and height, in pixels; None for 736 x 414 in a .gif, and
            1280 x 720 otherwise.
        fps: Pictures per second of the film; None for 15 in a .gif, and 25
            otherwise.
        speed: The ratio of recorded time to time in the film.
        start: The time of the first picture, on the clock of the recording,
            in seconds; None for the beginning.
        end: That of the last picture; None for the end.
        overlays: The overlays; None for those of the scenario.
        shadows: Whether figures cast shadows, which takes longer.
    """

    view: View = "perspective"
    size: tuple[int, int] | None = None
    fps: float | None = None
    speed: float = 1.0
    start: float | None = None
    end: float | None = None
    overlays: Sequence[Overlay] | None = None
    shadows: bool = True


@dataclass(frozen=True)
class _Film:
    """What a process needs to draw the pictures of a film."""

    view: View
    size: tuple[int, int]
    overlays: tuple[Overlay, ...]
    shadows: bool
    times: tuple[float, ...]
    step: float


def RenderFilm(
    run: str | os.PathLike[str],
    filename: str | os.PathLike[str],
    config: FilmConfig | None = None,
    *,
    progress: Callable[[int, int], None] | None = None,
    workers: int = 1,
    imports: Sequence[str] = (),
) -> Path:
    """Films a recorded trial.

    The film is the same, bit for bit, for any number of processes.

    Args:
        run: See `LoadRecordedTrial`.
        filename: The film, a .mp4 or .gif file; or a .png picture of the time
            `config.start`.
        config: The options of the film.
        progress: Called after each picture with the number of pictures so far
            and the total number.
        workers: The number of processes that draw; 1 for this one alone.
        imports: Modules and files that each process imports first.

    Returns:
        The absolute path of the film.

    Raises:
        OSError: If a file cannot be read, or if the film cannot be written.
        ValueError: If there is no valid recording, if a value of the
            configuration is out of its range, if a mesh of a model cannot be
            rendered, or if a film of the file's type cannot be written.
    """
    config = config or FilmConfig()
    path = Path(filename).resolve()
    suffix = path.suffix.lower()
    size = config.size or (_GIF_SIZE if suffix == ".gif" else _SIZE)
    fps = (
        (_GIF_FPS if suffix == ".gif" else _FPS)
        if config.fps is None
        else config.fps
    )
    config = replace(config, size=size, fps=fps)
    check_film_file(path, size)
    _check_numbers(config, size, fps)
    check_choice("view", config.view, VIEWS)
    for overlay in config.overlays or ():
        check_choice("overlays", overlay, OVERLAYS)
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
    times = _times(trial, config, suffix, fps)
    film = _Film(
        config.view,
        size,
        tuple(_overlays(trial, config)),
        config.shadows,
        tuple(times),
        times[1] - times[0] if len(times) > 1 else 1.0 / fps,
    )
    workers = min(workers, len(times) // _LEAST)
    with ExitStack() as stack:
        if workers > 1:
            pool = stack.enter_context(WorkerPool(workers, imports))
            pictures = _shared(pool, workers, str(run), film)
        else:
            pictures = map(_drawing(trial, film), range(len(times)))
        if progress is not None:
            pictures = _counted(pictures, len(times), progress)
        write_film(path, pictures, fps)
    return path


def _check_numbers(
    config: FilmConfig, size: tuple[int, int], fps: float
) -> None:
    rules = [
        ("width", size[0], _SMALLEST, _LARGEST, "pixels"),
        ("height", size[1], _SMALLEST, _LARGEST, "pixels"),
        ("fps", fps, 0.1, 120.0, "pictures per second"),
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
    trial: RecordedTrial, config: FilmConfig, suffix: str, fps: float
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
    period = gif_period(fps) / 1000.0 if suffix == ".gif" else 1.0 / fps
    return frame_times(start, end, config.speed * period)


def _drawing(trial: RecordedTrial, film: _Film) -> _Draw:
    """Returns what draws the pictures of a film."""
    if film.view == "plot":
        from hunav_drake.views.plan_view import PlanView

        plan = PlanView(trial, film.overlays, film.size)
        return lambda number: plan.Draw(film.times[number])
    from hunav_drake.views.film_overlays import FilmOverlays
    from hunav_drake.views.film_scene import FilmScene

    scene = FilmScene(
        trial,
        film.view,
        film.size,
        start=film.times[0],
        step=film.step,
        shadows=film.shadows,
        single=len(film.times) == 1,
    )
    drawn = FilmOverlays(trial, film.overlays)
    return lambda number: drawn.Draw(scene.Take(number))


@lru_cache(maxsize=1)
def _drawing_of_worker(run: str, film: _Film) -> _Draw:
    return _drawing(LoadRecordedTrial(Path(run)), film)


def _chunk(run: str, film: _Film, numbers: range) -> list[Image.Image]:
    """Returns pictures of a film, in a process that draws others, too."""
    return [*map(_drawing_of_worker(run, film), numbers)]


def _shared(
    pool: WorkerPool, workers: int, run: str, film: _Film
) -> Iterator[Image.Image]:
    """Yields the pictures of a film, which several processes draw."""
    waiting: deque[Future[list[Image.Image]]] = deque()
    total = len(film.times)
    for first in range(0, total, _CHUNK):
        numbers = range(first, min(first + _CHUNK, total))
        waiting.append(pool.submit(_chunk, run, film, numbers))
        # Not too far ahead of what is written: pictures take memory.
        if len(waiting) > 2 * workers:
            yield from waiting.popleft().result()
    for future in waiting:
        yield from future.result()


def _counted(
    pictures: Iterator[Image.Image],
    total: int,
    progress: Callable[[int, int], None],
) -> Iterator[Image.Image]:
    for count, picture in enumerate(pictures, 1):
        yield picture
        progress(count, total)
