"""Draws `hard.png`: the scenes of the suite "hard" when the robot fails.

python docs/draw_hard.py
"""

import math
from pathlib import Path

from draw_standard import draw_sheet
from matplotlib.patches import Circle
import numpy as np

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.scenarios import hard_names
from hunav_drake.systems.common.layout import RADIUS, YAW, Y
from hunav_drake.systems.evaluation.robustness import ROBUSTNESS
from hunav_drake.systems.scene.plan_walls import draw_walls

FILE = Path(__file__).parent / "hard.png"
BLUE, ORANGE, GRAY, GREEN = "#0072b2", "#d55e00", "#8c8c8c", "#009e73"

# What is seen around the middle of the failure, in meters.
AROUND = 3.2


def draw_body(axes, states: np.ndarray, color: str) -> None:
    """Draws the way of a body, and the body at its end, from above."""
    axes.plot(*states[:, : Y + 1].T, "-", color=color, lw=1.2, alpha=0.7)
    x, y = states[-1, : Y + 1]
    radius, yaw = states[-1, RADIUS], states[-1, YAW]
    axes.add_patch(Circle((x, y), radius, color=color, alpha=0.85, lw=0))
    tip = x + radius * math.cos(yaw), y + radius * math.sin(yaw)
    axes.plot(*np.transpose([(x, y), tip]), "-", color="white", lw=1.4)


def draw_scene(axes, name: str) -> None:
    """Draws walls, ways and bodies of a scene up to its failure."""
    scenario = LoadScenario(name)
    run = RunTrial(scenario).recording
    duration = scenario.simulation.duration
    each = (it.failing(run, duration) for it in ROBUSTNESS.values())
    found = next(it for it in each if it.robustness < 0)
    steps = run.times <= found.time + 1e-9
    draw_walls(axes, scenario.world.obstacles())
    for i in range(len(run.human_names)):
        draw_body(
            axes, run.humans[steps, i], GRAY if i != found.person else BLUE
        )
    draw_body(axes, run.robot[steps], ORANGE)
    axes.plot(*scenario.robot.goal[:2], "*", color=GREEN, ms=10, mew=0)
    x, y = run.robot[steps][-1, : Y + 1]
    axes.set_xlim(x - AROUND, x + AROUND)
    axes.set_ylim(y - AROUND, y + AROUND)
    axes.set_aspect("equal")
    axes.tick_params(labelsize=7, length=2)
    axes.set_title(f"{name.removeprefix('hard/')}, {found.time:.1f} s", size=9)


if __name__ == "__main__":
    draw_sheet(hard_names(), draw_scene, FILE)
