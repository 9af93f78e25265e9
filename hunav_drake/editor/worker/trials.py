"""Runs of trials in a process of the worker."""

import dataclasses
from functools import partial
import math
from pathlib import Path
import time
from typing import Any

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.systems.framework import Context, Diagram

from hunav_drake.editor.worker.channel import Channel, Stopped
from hunav_drake.editor.worker.events import ends_of, events_of
from hunav_drake.editor.worker.statistics import value_text
from hunav_drake.report.writing import WriteReport
from hunav_drake.runs.result_files import WriteResult
from hunav_drake.runs.run_row import plain_number
from hunav_drake.scenario import (
    LoadScenario,
    SaveScenario,
    Scenario,
    draw_people,
)
from hunav_drake.scenario.error import ScenarioError
from hunav_drake.scenario.fleet import planners_of, robots_of
from hunav_drake.scenario.population import people_seed
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.files import as_file_name
from hunav_drake.systems.common.layout import STATE_SIZE, is_outside
from hunav_drake.systems.planning.planner_error import PlannerError
from hunav_drake.trial.diagram import MakeTrialDiagram
from hunav_drake.trial.result import TrialResult
from hunav_drake.trial.simulation import RunTrial
from hunav_drake.views.replay import (
    RecordReplay,
    SaveReplay,
    SetView,
    StartMeshcatLocal,
)

# The least time between two frames, and between two looks for messages, in
# seconds.
FRAME_TIME = 0.05

# The maximum number of instants of drawn paths, and of all their numbers.
_MAX_INSTANTS = 600
_MAX_NUMBERS = 90_000


class Trials:
    """Runs trials, one after another.

    The next run of the same scenario uses the same diagram.
    """

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self._made_for: tuple[Any, ...] = ()
        # The scenario as loaded, and with the seed of the last run.
        self._loaded: Scenario | None = None
        self._scenario: Scenario | None = None
        # Whether it has its own planner, with its parameters.
        self._own_planner = False
        self._diagram: Diagram | None = None
        self._meshcat: Meshcat | None = None

    def warm_up(self) -> None:
        """Runs a short trial, so that all code is compiled and loaded."""
        scenario = LoadScenario(
            filename="passing", overrides=["simulation.duration=0.5"]
        )
        RunTrial(scenario)

    def run(self, message: dict[str, Any]) -> None:
        """Does a run; sends frames, the result, and the folder of its files."""
        folder = None
        result: dict[str, Any]
        try:
            trial = self._simulate(message)
            result = result_message(trial)
            self._channel.send({**result, "own_planner": self._own_planner})
            folder = self._write(trial, message)
        except Stopped:
            pass
        except Exception as error:
            self._made_for = ()
            self._channel.send(
                {
                    "kind": "result",
                    "end_reason": "failed",
                    "error": _words(error),
                    "own_planner": self._own_planner,
                }
            )
        self._channel.send(
            {"kind": "idle", "folder": None if folder is None else str(folder)}
        )

    def _simulate(self, message: dict[str, Any]) -> TrialResult:
        scenario, diagram = self._made(message)
        assert self._meshcat is not None
        watch = FrameSender(
            diagram, self._channel, message["run"], scenario.simulation.duration
        )
        scene = diagram.GetSubsystemByName("scene")
        visualizer = scene.GetSubsystemByName("meshcat_visualizer")
        # RunTrial would also show it live, which takes twice as long.
        with RecordReplay(visualizer):
            result = RunTrial(
                scenario,
                diagram=diagram,
                realtime_rate=message["speed"],
                watch=watch,
            )
            diagram.ForcedPublish(watch.context)
        watch.send()
        return result

    def _made(self, message: dict[str, Any]) -> tuple[Scenario, Diagram]:
        """Returns the scenario of a run, with its seed, and its diagram."""
        keys = ("text", "folder", "filename", "name", "planner")
        made_for = tuple(message[key] for key in keys)
        if made_for != self._made_for[:-1] or self._loaded is None:
            self._made_for = ()
            self._own_planner = False
            self._loaded, self._own_planner = load_scenario(message)
        scenario = self._loaded
        if (seed := message["seed"]) is not None:
            simulation = dataclasses.replace(scenario.simulation, seed=seed)
            scenario = dataclasses.replace(scenario, simulation=simulation)
        # If each seed draws its own people, each seed needs its own diagram.
        made_for = (*made_for, people_seed(scenario))
        if made_for != self._made_for:
            self._made_for = ()
            self._channel.look()
            self._meshcat = StartMeshcatLocal()
            people = draw_people(scenario)
            robots = robots_of(scenario)
            SetView(self._meshcat, scenario.world, people, robots)
            self._diagram = MakeTrialDiagram(scenario, self._meshcat)
            self._made_for = made_for
            self._channel.look()
        self._scenario = scenario
        assert self._diagram is not None
        return scenario, self._diagram

    def _write(self, result: TrialResult, message: dict[str, Any]) -> Path:
        """Writes the files of a run to a new folder."""
        scenario, meshcat = self._scenario, self._meshcat
        assert scenario is not None

        def add_pages(folder: Path) -> None:
            self._channel.look()
            SaveScenario(scenario, folder / "scenario.yaml")
            replay = folder / "replay.html"
            SaveReplay(meshcat, replay)
            self._channel.look()
            WriteReport(result, folder / "report.html", replay=replay)

        return WriteResult(result, message["out"], add=add_pages)


def load_scenario(message: dict[str, Any]) -> tuple[Scenario, bool]:
    """Returns the scenario of a run, and whether it has its own planner.

    Its default name is that of its file.
    """
    planner = message["planner"]
    load = partial(
        LoadScenario,
        data=message["text"],
        folder=message["folder"],
        scenario_name=message["name"],
    )
    scenario = load()
    own_planner = planner in (None, planners_of(scenario))
    if not own_planner:
        scenario = load(overrides={"planner": planner})
    filename = message["filename"]
    default = message["name"] or (Path(filename).stem if filename else "")
    name = scenario.name or (as_file_name(default) if default else "")
    return dataclasses.replace(scenario, name=name), own_planner


class FrameSender:
    """Sends frames of a trial, and looks for messages."""

    def __init__(
        self, diagram: Diagram, channel: Channel, run: int, duration: float
    ) -> None:
        self.context: Context | None = None
        self._diagram = diagram
        self._channel = channel
        self._run = run
        self._duration = duration
        self._last = 0.0

    def __call__(self, context: Context) -> bool:
        """Handles a step of the trial; never stops it."""
        self.context = context
        present = time.monotonic()
        if present - self._last >= FRAME_TIME:
            self._channel.look()
            self.send()
            self._last = time.monotonic()
        return True

    def send(self) -> None:
        """Sends the current poses."""
        context = self.context
        if context is None:
            return
        several = self._diagram.HasOutputPort("robot_states")
        states, robots, status = (
            self._diagram.GetOutputPort(name).Eval(context)
            for name in (
                "human_states",
                "robot_states" if several else "robot_state",
                "behavior_status",
            )
        )
        seconds = context.get_time()
        self._channel.send(
            {
                "kind": "frame",
                "run": self._run,
                "time": round(seconds, 3),
                "robots": _poses(robots),
                "people": _poses(states),
                "activities": [int(it) for it in status],
                "progress": min(seconds / self._duration, 1.0),
            }
        )


def result_message(result: TrialResult) -> dict[str, Any]:
    """Returns the message with a result."""
    metrics = {
        str(name): float(value) for name, value in result.metrics.items()
    }
    failed = result.end_reason == "planner_failed"
    return {
        "kind": "result",
        "planner": result.provenance.get("planner"),
        "seed": result.provenance.get("seed"),
        "drawn": result.provenance.get("drawn"),
        "end_reason": result.end_reason,
        "message": result.end_message,
        "end_time": result.end_time,
        "metrics": {name: plain_number(it) for name, it in metrics.items()},
        "texts": {name: value_text(name, it) for name, it in metrics.items()},
        "paths": _paths(result),
        "events": events_of(result),
        "ends": ends_of(result),
        "error": result.end_message if failed else None,
    }


def _paths(result: TrialResult) -> dict[str, Any]:
    """Returns the poses of people and robots at some of the instants."""
    recording = result.recording
    robots = np.stack([it.robot for it in recording.robots], axis=1)
    count, people = recording.humans.shape[:2]
    bodies = people + robots.shape[1]
    most = max(min(_MAX_INSTANTS, _MAX_NUMBERS // (3 * bodies)), 2)
    every = max(-(-count // most), 1)
    chosen = sorted({*range(0, count, every), count - 1})
    return {
        "times": [round(float(recording.times[i]), 3) for i in chosen],
        "robots": [_poses(robots[i]) for i in chosen],
        "people": [_poses(recording.humans[i].ravel()) for i in chosen],
    }


def _poses(states: Array) -> list[list[float] | None]:
    """Returns (x, y, yaw) of rows of states; None for absent people."""
    rows = states.reshape(-1, STATE_SIZE)
    return [
        [round(float(number), 3) for number in row[:3]]
        if math.isfinite(row[0]) and not is_outside(row)
        else None
        for row in rows
    ]


def _words(error: Exception) -> str:
    """Returns the reason of a failed run."""
    if isinstance(error, ScenarioError):
        text = "; ".join(str(fault) for fault in error.faults[:3])
        return text.removeprefix("data: ")
    if isinstance(error, PlannerError | OSError | ValueError):
        return str(error)
    return f"{type(error).__name__}: {error}"
