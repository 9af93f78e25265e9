"""Draws `generated.png`: generated scenarios from easy to hard.

python docs/draw_generated.py
"""

from io import BytesIO
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

from hunav_drake import GenerateScenario
from hunav_drake.systems.scene.plan_walls import draw_walls

FILE = Path(__file__).parent / "generated.png"
KINDS = ("field", "corridors", "rooms", "office")
DIFFICULTIES = (0.0, 0.5, 1.0)
SEED = 2
BLUE, ORANGE, GREEN = "#0072b2", "#d55e00", "#009e73"


def draw(axes, kind: str, difficulty: float) -> None:
    """Draws a scenario from above, with the ways of people."""
    scenario = GenerateScenario(kind, seed=SEED, difficulty=difficulty)
    draw_walls(axes, scenario.world.obstacles())
    for human in scenario.humans:
        way = np.array([human.pose[:2], *human.goals])
        axes.plot(*way.T, ":", color=BLUE, lw=0.5)
        axes.plot(*way[0], "o", color=BLUE, ms=4, mew=0)
    robot = scenario.robot
    axes.plot(*robot.start[:2], "s", color=ORANGE, ms=6, mew=0)
    axes.plot(*robot.goal[:2], "*", color=GREEN, ms=10, mew=0)
    axes.set_aspect("equal")
    axes.tick_params(labelsize=7, length=2)
    axes.set_title(f"{kind}, difficulty {difficulty:g}", size=9)


def main() -> None:
    """Draws each kind at three difficulties."""
    figure, grid = plt.subplots(
        len(DIFFICULTIES),
        len(KINDS),
        figsize=(12, 8.5),
        layout="constrained",
        width_ratios=(0.55, 1.3, 1.2, 1.5),
    )
    for row, difficulty in zip(grid, DIFFICULTIES, strict=True):
        for axes, kind in zip(row, KINDS, strict=True):
            draw(axes, kind, difficulty)
    stream = BytesIO()
    figure.savefig(stream, dpi=90)
    # Some colors are enough, and half of the size.
    picture = Image.open(stream).convert("RGB").quantize(64)
    picture.save(FILE, optimize=True)


if __name__ == "__main__":
    main()
