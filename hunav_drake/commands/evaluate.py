"""Evaluates a recording for `hunav evaluate`."""

from collections.abc import Mapping, Sequence
import dataclasses
import math
from pathlib import Path
from typing import Any

from hunav_drake.runs.recording_files import ReadRecording
from hunav_drake.systems.evaluation.metric import base_name
from hunav_drake.systems.evaluation.metrics import METRICS, select_metrics
from hunav_drake.systems.evaluation.recording import (
    GOAL_YAW_TOLERANCE,
    Recording,
)
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.trial.provenance import MakeSourceProvenance
from hunav_drake.trial.result import EndReason, MakeTrialResult, TrialResult

# The value of `--walls` for an open space.
NO_WALLS = "none"


def evaluate_file(
    filename: Path,
    *,
    metric_names: Sequence[str] = ("all",),
    goal: str | None = None,
    goal_tolerance: str | None = None,
    walls: str | None = None,
    walls_name: str | None = None,
    reference: Path | None = None,
    topics: Mapping[str, str] | None = None,
) -> TrialResult:
    """Computes the metrics of a recording, with options of `hunav evaluate`.

    Raises:
        OSError: If a file cannot be read.
        ValueError: If a file is not a recording, or a name, the goal, its
            tolerance or the walls are invalid.
    """
    select_metrics(metric_names)
    recording = ReadRecording(filename, **(topics or {}))
    if recording.others and (goal is not None or goal_tolerance is not None):
        raise ValueError(
            "--goal and --goal-tolerance are for one robot, and the recording"
            " has several; leave them out"
        )
    changes: dict[str, Any] = {}
    if goal is not None:
        changes |= _goal(goal, recording)
    if goal_tolerance is not None:
        if goal is None and recording.goal is None:
            raise ValueError(
                "--goal-tolerance: the recording has no goal; add --goal X,Y"
            )
        changes |= _tolerance(goal_tolerance)
    if walls is not None:
        changes |= {"obstacles": _walls(walls, walls_name), "walls_known": True}
    # (Walls are those of all robots.)
    others = [dataclasses.replace(it, **changes) for it in recording.others]
    changes["others"] = tuple(others)
    recording = dataclasses.replace(recording, **changes)
    if reference is not None:
        recording = recording.compared_with(ReadRecording(reference))
    ends: dict[str, EndReason] = {
        it.robot_name: "goal" if it.features.at_goal[-1] else "end"
        for it in (robot.until_end() for robot in recording.robots)
    }
    at_goal = set(ends.values()) == {"goal"}
    return MakeTrialResult(
        recording,
        scenario_name=filename.name.split(".")[0],
        metric_names=metric_names,
        provenance=MakeSourceProvenance(filename),
        end_reason="goal" if at_goal else "end",
        end_message=(
            "the robot is at its goal",
            "all robots are at their goals",
        )[len(ends) > 1]
        if at_goal
        else "the recording ends",
        robot_ends=ends if recording.others else {},
        end_time=float(recording.times[-1] - recording.times[0]),
    )


def lacks_walls(result: TrialResult) -> bool:
    """Returns whether a metric has no value because walls are unknown."""
    if result.recording.walls_known:
        return False
    missing = result.metrics.index[result.metrics.isna()]
    walled = dataclasses.replace(result.recording, walls_known=True)
    names = [it for it in map(base_name, missing) if it in METRICS]
    return any(_has_value(name, walled) for name in names)


def _has_value(name: str, recording: Recording) -> bool:
    try:
        value, _ = METRICS[name].compute(recording)
    except ValueError:
        return False
    return not math.isnan(value)


def _goal(text: str, recording: Recording) -> dict[str, Any]:
    x, y, *yaw = _numbers("--goal", "X,Y", text)
    tolerance = math.pi
    if yaw:
        # A goal without a heading accepts any, so its tolerance is pi.
        known = recording.goal_yaw_tolerance
        tolerance = known if known < math.pi else GOAL_YAW_TOLERANCE
    return {"goal": (x, y, *(yaw or [0.0])), "goal_yaw_tolerance": tolerance}


def _tolerance(text: str) -> dict[str, Any]:
    distance, *yaw = _numbers("--goal-tolerance", "D", text)
    changes = {"goal_tolerance": distance}
    return changes | ({"goal_yaw_tolerance": yaw[0]} if yaw else {})


def _numbers(option: str, needed: str, text: str) -> list[float]:
    """Returns the numbers of an option: those needed, and perhaps a yaw."""
    count = needed.count(",") + 1
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (count, count + 1):
        raise ValueError(
            f"{option} must be {needed} or {needed},YAW in meters and radians,"
            f" got {text!r}"
        )
    return numbers


def _walls(text: str, name: str | None) -> Obstacles:
    if text == NO_WALLS:
        return Obstacles.from_points([])
    from hunav_drake.scenario import LoadScenario

    try:
        scenario = LoadScenario(filename=text, scenario_name=name)
        return scenario.world.obstacles()
    except ValueError as error:
        raise ValueError(f"--walls: {error}") from error
