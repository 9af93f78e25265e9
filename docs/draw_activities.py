"""Draws `activity_*.gif`: six seconds of each example of `activities.md`.

python docs/draw_activities.py
"""

from pathlib import Path
import re
from tempfile import TemporaryDirectory

from hunav_drake import FilmConfig, RenderFilm
from hunav_drake.commands.cli import main as hunav

FOLDER = Path(__file__).parent
EXAMPLE = re.compile(r"^## (\w+):.*?```yaml\n(.*?)```", re.M | re.S)

# When the films begin, and how long they are, in seconds.
STARTS = {"sit": 1.5, "queue": 2.0, "lunch": 3.7, "talk": 1.0, "guide": 3.7}
LENGTH = 6.0


def main() -> None:
    """Draws all films."""
    for name, text in EXAMPLE.findall((FOLDER / "activities.md").read_text()):
        start = STARTS.get(name, 0.0)
        config = FilmConfig(
            size=(480, 270),
            fps=8.0,
            start=start,
            end=start + LENGTH,
            overlays=("walked", "speech"),
            shadows=False,
        )
        with TemporaryDirectory() as folder:
            file = Path(folder, "example.yaml")
            file.write_text(text)
            hunav(["run", str(file), "--out", folder, "--quiet"])
            (run,) = Path(folder, "runs").iterdir()
            RenderFilm(run, FOLDER / f"activity_{name}.gif", config)


if __name__ == "__main__":
    main()
