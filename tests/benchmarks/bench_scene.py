"""What it costs to show a trial: CPU time, and the size of replays."""

from pathlib import Path
import tempfile
import time

from pydrake.geometry import Meshcat

from hunav_drake import MakeTrialDiagram, MakeTrialSimulator
from hunav_drake.scenario import LoadScenario, Scenario, draw_people
from hunav_drake.systems.scene import SceneKinematics
from hunav_drake.views.film import FilmConfig, RenderFilm
from hunav_drake.views.replay import (
    RecordReplay,
    SaveReplay,
    SetView,
    StartMeshcatLocal,
)

DURATION = 60.0

ROOM = """
world:
  walls:
    - {shape: box, center: [0, 8.1], size: [24, 0.2]}
    - {shape: box, center: [0, -8.1], size: [24, 0.2]}
population:
  cohorts:
    - name: guest
      number: %d
      start: [{rectangle: [-11, -7, 11, 7]}]
      goals: [{rectangle: [-11, -7, -6, 7]}, {rectangle: [6, -7, 11, 7]}]
      cyclic: true
robot: {start: [-10, 0, 0], goal: [10, 0, 0], goal_tolerance: 1.0e-6}
simulation: {duration: 60, stuck_time: 10000}
"""


def room(number: int) -> Scenario:
    """Returns a trial of so many people who walk to and fro for a minute."""
    return LoadScenario(data=ROOM % number)


def cpu_of_run(
    scenario: Scenario, meshcat: Meshcat | None, *, recorded: bool = False
) -> tuple[float, int]:
    """Returns the CPU seconds of a run, and the bytes of its replay, if any."""
    diagram = MakeTrialDiagram(scenario, meshcat)
    simulator = MakeTrialSimulator(diagram)
    simulator.Initialize()
    if meshcat is None or not recorded:
        started = time.process_time()
        simulator.AdvanceTo(DURATION)
        return time.process_time() - started, 0
    SetView(meshcat, scenario.world, draw_people(scenario), scenario.robot)
    scene_system = diagram.GetSubsystemByName("scene")
    visualizer = scene_system.GetSubsystemByName("meshcat_visualizer")
    started = time.process_time()
    with RecordReplay(visualizer):
        simulator.AdvanceTo(DURATION)
    spent = time.process_time() - started
    with tempfile.TemporaryDirectory() as folder:
        page = SaveReplay(meshcat, Path(folder) / "replay.html")
        return spent, page.stat().st_size


def cpu_without_scene(scenario: Scenario) -> float:
    """Returns the CPU seconds of a run whose scene does nothing."""
    advance = SceneKinematics._Advance
    SceneKinematics._Advance = lambda self, context, state: None
    try:
        return cpu_of_run(scenario, None)[0]
    finally:
        SceneKinematics._Advance = advance


def cpu_of_film(size: tuple[int, int], *, shadows: bool) -> float:
    """Returns the CPU seconds of one picture of a film."""
    from hunav_drake.runs.result_files import WriteResult
    from hunav_drake.trial.simulation import RunTrial

    with tempfile.TemporaryDirectory() as folder:
        scenario = LoadScenario(filename="passing")
        run = WriteResult(RunTrial(scenario), folder)
        config = FilmConfig(size=size, shadows=shadows, end=1.0, fps=20.0)
        started = time.process_time()
        RenderFilm(run, Path(folder) / "film.gif", config)
        return (time.process_time() - started) / 21


def main() -> None:
    print("a minute of a trial, CPU time:")
    for number in (10, 20):
        scenario = room(number)
        meshcat = StartMeshcatLocal()
        bare = cpu_without_scene(scenario)
        plain, _ = cpu_of_run(scenario, None)
        unseen, _ = cpu_of_run(scenario, meshcat)
        told, size = cpu_of_run(scenario, meshcat, recorded=True)
        print(
            f"  {number} people: without scene {bare:.2f} s, with it"
            f" {plain:.2f} s, with a Meshcat that nobody looks at"
            f" {unseen:.2f} s, recorded for a replay {told:.2f} s"
            f" ({DURATION / told:.0f} times real time), {size / 1e6:.1f} MB"
        )
    print("a picture of a film, CPU time:")
    for size in ((640, 360), (1280, 720)):
        bare, full = (cpu_of_film(size, shadows=s) for s in (False, True))
        print(f"  {size[0]}x{size[1]}: {bare:.2f} s, with shadows {full:.2f} s")


if __name__ == "__main__":
    main()
