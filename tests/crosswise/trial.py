"""One row as a trial of three seconds, with all that it must keep."""

from contextlib import ExitStack
from functools import cache
from pathlib import Path
import tempfile
from typing import Any, get_args
import warnings

import numpy as np
from pydrake.systems.framework import Context

from hunav_drake import (
    GetTrialResult,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    SaveScenario,
    Scenario,
    ScenarioError,
    SetTrialSeed,
    TrialResult,
)
from hunav_drake.runs.result_files import LoadResults, WriteResult
from hunav_drake.views.camera import View
from hunav_drake.views.film import FilmConfig, RenderFilm
from hunav_drake.views.replay import RecordReplay, SaveReplay, StartMeshcatLocal
from tests.crosswise.factors import Row, overrides, refusal

SEED = 3
# When the Context is cloned, in seconds.
HALF = 1.5

# How many pixels of a camera may differ in a cloned Context, as a share: where
# surfaces meet, Drake's renderer draws now one and now the other. (1.6 % were
# seen in a picture of 80 x 60.) What is where is the same.
PIXELS = 5e-2


def run_row(row: Row) -> None:
    """Runs a row.

    Raises:
        AssertionError: If something does not hold that must.
        Exception: If something else fails.
    """
    words = refusal(row)
    with warnings.catch_warnings():
        # A metric that fails, numbers out of their range ...
        warnings.simplefilter("error")
        # A robot may be smaller than its disc.
        warnings.filterwarnings("ignore", "robot.radius")
        warnings.filterwarnings("ignore", ".*collision shapes of the model")
        told = ""
        try:
            scenario = LoadScenario(
                filename=row["scenario"],
                overrides=[*overrides(row), f"simulation.seed={SEED}"],
            )
        except ScenarioError as error:
            told = str(error)
        if told or words:
            assert words, f"is refused: {told}"
            assert words in told, f"should say {words!r}: {told!r}"
            return
        _run(scenario, row)


def _run(scenario: Scenario, row: Row) -> None:
    """Runs a trial through, and from a clone, and shows and writes it."""
    meshcat = _meshcat() if row["view"] == "replay" else None
    diagram = MakeTrialDiagram(scenario, meshcat)
    context = diagram.CreateDefaultContext()
    SetTrialSeed(diagram, context, SEED)
    if diagram.HasInputPort("trigger"):
        diagram.GetInputPort("trigger").FixValue(context, [1.0])
    clones: list[Context] = []

    def keep(seconds: float) -> None:
        if not clones and seconds > HALF - 1e-9:
            clones.append(simulator.get_context().Clone())

    with ExitStack() as stack:
        if meshcat is not None:
            scene = diagram.GetSubsystemByName("scene")
            shown = scene.GetSubsystemByName("meshcat_visualizer")
            stack.enter_context(RecordReplay(shown, live=False))
        simulator = MakeTrialSimulator(diagram, context, progress=keep)
        simulator.AdvanceTo(scenario.simulation.duration)
        simulator.clear_monitor()
    end = simulator.get_context()
    expected = GetTrialResult(scenario, diagram, end)
    _check_finite(expected, scenario)

    assert clones, "has no half time"
    fork = MakeTrialSimulator(diagram, clones[0])
    fork.AdvanceTo(scenario.simulation.duration)
    result = GetTrialResult(scenario, diagram, fork.get_context())
    _check_equal(result, expected)
    for i in range(diagram.num_output_ports()):
        port = diagram.get_output_port(i)
        one, other = (
            getattr(value, "data", value)
            for value in map(port.Eval, (fork.get_context(), end))
        )
        if isinstance(one, np.ndarray):
            different = np.mean(
                (one != other) & ~((one != one) & (other != other))
            )
            name = port.get_name()
            is_picture = one.ndim == 3 and "label" not in name
            assert different <= PIXELS * is_picture, f"{name} of the clone"

    with tempfile.TemporaryDirectory() as folder:
        run = WriteResult(
            expected,
            folder,
            format=row["format"],
            add=lambda it: SaveScenario(scenario, it / "scenario.yaml"),
        )
        (read,) = LoadResults(folder)
        _check_equal(read, expected)
        if meshcat is not None:
            SaveReplay(meshcat, Path(folder) / "replay.html")
            meshcat.Delete()
        elif row["view"] in get_args(View):
            at = float(expected.recording.times[-1])
            config = FilmConfig(view=row["view"], size=(96, 64), start=at)
            RenderFilm(run, Path(folder) / "film.png", config)


@cache
def _meshcat() -> Any:
    """Returns the one Meshcat of this process."""
    return StartMeshcatLocal()


def _check_finite(result: TrialResult, scenario: Scenario) -> None:
    recording = result.recording
    assert len(recording.times), "nothing is recorded"
    assert np.isfinite(recording.robot).all(), "the robot is not finite"
    people = recording.humans
    if scenario.population.sources or scenario.population.tracks:
        # Who is outside has no place.
        people = people[~np.isnan(people).all(axis=-1)]
    assert np.isfinite(people).all(), "somebody is not finite"


def _check_equal(result: TrialResult, expected: TrialResult) -> None:
    assert result.end_time == expected.end_time
    assert result.end_reason == expected.end_reason
    assert result.end_message == expected.end_message
    assert result.recording == expected.recording, "another recording"
    assert result.metrics.equals(expected.metrics), "other metrics"
