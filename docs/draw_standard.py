"""Draws `standard.png`: where the trials of the standard suite begin.

python docs/draw_standard.py
"""

from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
from matplotlib.axes import Axes
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

from hunav_drake import LoadScenario
from hunav_drake.runs import LoadSuite
from hunav_drake.scenario import draw_people
from hunav_drake.scenario.fleet import robots_of
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.scene.plan_walls import draw_walls

FILE = Path(__file__).parent / "standard.png"
COLUMNS = 4
BLUE, ORANGE, GREEN = "#0072b2", "#d55e00", "#009e73"

# What is seen around the places of people and robot, in meters.
AROUND = 1.0


def first_goal(human: HumanConfig) -> np.ndarray | None:
    """Returns where a person walks first, if anywhere."""
    if not human.goals:
        return None
    return np.array(human.goals[0], dtype=float)[:2]


def draw_scenario(axes, name: str) -> None:
    """Draws walls, people and robots from above, with what they head for."""
    scenario = LoadScenario(filename=name)
    draw_walls(axes, scenario.world.obstacles())
    places = []
    for human in draw_people(scenario):
        start = np.array(human.pose[:2], dtype=float)
        goal = first_goal(human)
        axes.plot(*start, "o", color=BLUE, ms=4, mew=0)
        places.append(start)
        if goal is not None:
            axes.annotate(
                "",
                goal,
                start,
                arrowprops={
                    "arrowstyle": "->",
                    "color": BLUE,
                    "lw": 0.6,
                    "alpha": 0.6,
                },
            )
            places.append(goal)
    for robot in robots_of(scenario).values():
        start = np.array(robot.start[:2], dtype=float)
        places.append(start)
        axes.plot(*start, "s", color=ORANGE, ms=6, mew=0)
        if robot.goal is not None:
            goal = np.array(robot.goal[:2], dtype=float)
            axes.plot(*goal, "*", color=GREEN, ms=10, mew=0)
            axes.plot(*np.transpose([start, goal]), ":", color=ORANGE, lw=1)
            places.append(goal)
    low = np.min(places, axis=0) - AROUND
    high = np.max(places, axis=0) + AROUND
    # All pictures are as wide as they are high.
    half = (high - low).max() / 2
    middle = (low + high) / 2
    axes.set_xlim(middle[0] - half, middle[0] + half)
    axes.set_ylim(middle[1] - half, middle[1] + half)
    axes.set_aspect("equal")
    axes.tick_params(labelsize=7, length=2)
    axes.set_title(f"{name} ({len(draw_people(scenario))} people)", size=9)


def draw_sheet(
    names: Sequence[str], draw: Callable[[Axes, str], None], file: Path
) -> None:
    """Draws a picture for each name on one sheet."""
    rows = -(-len(names) // COLUMNS)
    figure, grid = plt.subplots(
        rows, COLUMNS, figsize=(10, 2.75 * rows), layout="constrained"
    )
    for axes in grid.flat[len(names) :]:
        axes.set_axis_off()
    for axes, name in zip(grid.flat, names, strict=False):
        draw(axes, name)
    stream = BytesIO()
    figure.savefig(stream, dpi=110)
    # Some colors are enough, and half of the size.
    picture = Image.open(stream).convert("RGB").quantize(96)
    picture.save(file, optimize=True)


if __name__ == "__main__":
    draw_sheet(LoadSuite(filename="standard").scenarios, draw_scenario, FILE)
