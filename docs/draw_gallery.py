"""Draws `gallery/`, a picture or a short film of each choice, and `film.gif`.

python docs/draw_gallery.py            # all of them
python docs/draw_gallery.py curious    # those of these names
python docs/draw_gallery.py film
"""

from pathlib import Path
import sys
from tempfile import TemporaryDirectory

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image, ImageSequence

from hunav_drake import FilmConfig, ReadRecording, RenderFilm
from hunav_drake.commands.cli import main as hunav
from hunav_drake.report.plots import plot_trajectories
from hunav_drake.scenarios import shipped_names
from hunav_drake.systems.behavior import BEHAVIORS
from hunav_drake.systems.planning import PLANNERS

FOLDER = Path(__file__).parent / "gallery"
SIZE = (480, 300)

# The planners drive here, and the behaviors without a scenario react here.
PLACE, REACTION = "queue", "reaction_surprised"

# Length of the films of behaviors, in seconds, and their pictures per second.
LENGTH, FPS = 6.0, 8.0


def main(names: list[str]) -> None:
    """Draws what is named, or all."""
    shipped = shipped_names()
    reactions = {
        name: [f"reaction_{name}"]
        if f"reaction_{name}" in shipped
        else [REACTION, "--set", f"humans[0].behavior={name}"]
        for name in BEHAVIORS
    }
    # (Three only do as others say.)
    planners = set(PLANNERS) - {"bridge", "external", "stand"}
    if not names or "film" in names:
        draw_film()
    draw(names, "scenarios", {it: [it] for it in shipped}, draw_scenario)
    draw(names, "behaviors", reactions, draw_behavior)
    draw(
        names,
        "planners",
        {it: [PLACE, "--planner", it] for it in planners},
        draw_planner,
    )


def draw_film() -> None:
    """Films the head of the README: a cafe, with the robot in the middle."""
    config = FilmConfig(
        view="follow",
        size=(640, 360),
        fps=10.0,
        start=4.0,
        end=16.0,
        overlays=("walked", "speech", "reactions"),
    )
    with TemporaryDirectory() as folder:
        hunav(["run", "living_cafe", "--out", folder, "--quiet"])
        (run,) = Path(folder, "runs").iterdir()
        RenderFilm(run, FOLDER.parent / "film.gif", config)


def draw(names, kind, runs, draw_run) -> None:
    """Runs each of a kind, and draws the run."""
    (FOLDER / kind).mkdir(parents=True, exist_ok=True)
    for name, options in runs.items():
        if names and name not in names:
            continue
        with TemporaryDirectory() as folder:
            hunav(["run", *options, "--out", folder, "--quiet"])
            (run,) = Path(folder, "runs").iterdir()
            file = FOLDER / kind / f"{name}.webp"
            draw_run(run, file)
        print(f"{file}: {file.stat().st_size // 1000} kB")


def draw_scenario(run: Path, file: Path) -> None:
    """Draws the instant at which most people are near the robot."""
    recording = ReadRecording(run / "recording.npz")
    away = recording.humans[:, :, :2] - recording.robot[:, None, :2]
    near = np.hypot(*np.moveaxis(away, -1, 0)) < 4.0
    best = np.argmax(near.sum(axis=1)) if near.size else len(near) // 2
    start = float(recording.times[best])
    picture = file.with_suffix(".png")
    RenderFilm(run, picture, FilmConfig(size=SIZE, start=start))
    Image.open(picture).save(file, quality=80)
    picture.unlink()


def draw_behavior(run: Path, file: Path) -> None:
    """Films the time around the closest approach."""
    recording = ReadRecording(run / "recording.npz")
    closest = recording.times[np.argmin(recording.features.closest_gap)]
    last = float(recording.times[-1]) - LENGTH
    start = float(np.clip(closest - LENGTH / 2, 0.0, last))
    config = FilmConfig(
        view="follow",
        size=SIZE,
        fps=FPS,
        start=start,
        end=start + LENGTH,
        overlays=("walked", "reactions", "speech"),
    )
    film = file.with_suffix(".gif")
    RenderFilm(run, film, config)
    with Image.open(film) as gif:
        first, *others = (
            it.convert("RGB") for it in ImageSequence.Iterator(gif)
        )
        first.save(
            file,
            save_all=True,
            append_images=others,
            duration=round(1000 / FPS),
            loop=0,
            quality=60,
        )
    film.unlink()


def draw_planner(run: Path, file: Path) -> None:
    """Draws the ways of robot and people from above."""
    figure, axes = plt.subplots(figsize=(4.8, 3.0), layout="compressed")
    plot_trajectories(ReadRecording(run / "recording.npz"), ax=axes)
    axes.get_legend().remove()
    axes.set_axis_off()
    figure.savefig(file, dpi=100)
    plt.close(figure)


if __name__ == "__main__":
    main(sys.argv[1:])
