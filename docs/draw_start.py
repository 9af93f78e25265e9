"""Draws the pictures of the start pages: `start_*.png` and `start_diagram.svg`.

python docs/draw_start.py

It needs Graphviz and Chromium.
"""

from pathlib import Path
import re
import shutil
import subprocess
from tempfile import TemporaryDirectory

import matplotlib

matplotlib.use("Agg")
from PIL import Image
from playwright.sync_api import sync_playwright
from pydrake.systems.framework import DiagramBuilder

from hunav_drake import (
    AddHumans,
    FilmConfig,
    HumanConfig,
    LoadScenario,
    RenderFilm,
    RunTrial,
    plot_trajectories,
)
from hunav_drake.commands.cli import main as hunav
from hunav_drake.systems.robot import DifferentialDrive, DifferentialDriveConfig

FOLDER = Path(__file__).parent


def draw_notebook() -> None:
    """Draws the paths of the trial of the page."""
    result = RunTrial(LoadScenario(filename="crossing"), seed=3)
    axes = plot_trajectories(result.recording)
    axes.figure.savefig(FOLDER / "start_notebook.png", dpi=90)


def draw_diagram() -> None:
    """Draws the diagram of the page, as Drake sees it."""
    builder = DiagramBuilder()
    robot = builder.AddNamedSystem(
        "robot", DifferentialDrive(DifferentialDriveConfig())
    )
    people = AddHumans(builder, [HumanConfig(pose=[5, 0, 0])])
    builder.Connect(robot.get_robot_state_output_port(), people.robot_states)
    port = robot.get_velocity_command_input_port()
    builder.ExportInput(port, "velocity_command")
    builder.ExportOutput(people.human_states, "human_states")
    text = builder.Build().GetGraphvizString(max_depth=1)
    subprocess.run(
        ["dot", "-Tsvg", "-Gdpi=60", "-o", FOLDER / "start_diagram.svg"],
        input=re.sub(r"(hunav_drake|pydrake)\.[\w.]*\.(\w+)", r"\2", text),
        text=True,
        check=True,
    )


def draw_benchmark() -> None:
    """Draws the head of a suite's page."""
    with TemporaryDirectory() as folder, sync_playwright() as start:
        suite = Path(folder, "mine.yaml")
        suite.write_text(
            "{name: mine, scenarios: [crossing], planners: [dwb, scl, sfw],"
            " seeds: 4}"
        )
        hunav(["bench", str(suite), "--out", folder])
        (page,) = Path(folder).rglob("report.html")
        browser = start.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        tab = browser.new_page(viewport={"width": 1000, "height": 720})
        tab.goto(page.as_uri())
        tab.screenshot(path=FOLDER / "start_benchmark.png")
        browser.close()


def draw_scenes() -> None:
    """Draws an encounter from above, and the people of HuNavSim's paper."""
    for name, scenario, config in (
        (
            "tests",
            "crossing",
            FilmConfig(view="top", start=5.0, overlays=("rings", "walked")),
        ),
        ("hunavsim", "combined", FilmConfig(view="follow", start=11.0)),
    ):
        with TemporaryDirectory() as folder:
            hunav(["run", scenario, "--out", folder, "--quiet"])
            (run,) = Path(folder, "runs").iterdir()
            picture = FOLDER / f"start_{name}.png"
            RenderFilm(run, picture, config)
            small = Image.open(picture).resize((720, 405))
            small.convert("P", palette=Image.Palette.ADAPTIVE).save(picture)


if __name__ == "__main__":
    draw_notebook()
    draw_diagram()
    draw_scenes()
    draw_benchmark()
