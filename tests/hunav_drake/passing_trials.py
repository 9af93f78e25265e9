"""Trials of a robot that drives past people who stand, made without a run."""

import dataclasses

import numpy as np

from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.trial.provenance import MakeProvenance
from hunav_drake.trial.result import MakeTrialResult, TrialResult


def make_recording(
    xs=(0.0, 0.0), *, y=(1.5, -1.5), samples=11, start=0.0, speed=1.0, **kwargs
) -> Recording:
    """Returns a recording of a robot that drives along the x-axis.

    Args:
        xs: Where people stand: the x of each, in meters.
        y: The y of all, or of each.
        samples: How many there are, 0.1 s apart.
        start: The x of the robot at the first one.
        speed: Of the robot, in m/s.
        kwargs: What else is recorded, or instead.
    """
    times = np.arange(samples) * 0.1
    robot = np.zeros((samples, 7))
    robot[:, 0] = start + speed * times
    robot[:, 3] = speed
    robot[:, 6] = 0.35
    humans = np.zeros((samples, len(xs), 7))
    humans[:, :, 0] = xs
    humans[:, :, 1] = y
    humans[:, :, 6] = 0.25
    states = {"times": times, "robot": robot, "humans": humans}
    return Recording(**(states | kwargs))


def make_result(
    recording=None,
    *,
    seed=0,
    planner="pursuit",
    setting="",
    speed=1.0,
    scenario_text="humans: []",
    **kwargs,
) -> TrialResult:
    """Returns the result of such a trial.

    Args:
        recording: Without one, the robot drives 0.01 m/s faster with each seed.
        seed: Of the trial.
        planner: The name of the robot's.
        setting: What was set for this run.
        speed: Of the robot with seed 0, in m/s.
        scenario_text: What of the provenance is a hash.
        kwargs: Of `MakeTrialResult`.
    """
    if recording is None:
        recording = make_recording(speed=speed + 0.01 * seed)
    settings = {
        "scenario_name": "passing",
        "metric_names": "paper",
        "provenance": MakeProvenance(
            f"{scenario_text} {seed}", seed, planner=planner
        ),
        "end_reason": "goal",
        "end_message": "the robot has reached its goal",
    }
    result = MakeTrialResult(recording, **(settings | kwargs))
    return dataclasses.replace(result, setting=setting)


def make_results(planners: tuple[str, ...], gain: float) -> list[TrialResult]:
    """Returns trials of two scenarios with three seeds and some planners.

    Args:
        planners: Their names.
        gain: By how much the robot is faster with each seed, in m/s.
    """
    return [
        make_result(
            make_recording(samples=41, speed=1 + gain * seed),
            scenario_name=scenario,
            planner=planner,
            seed=seed,
        )
        for scenario in ("passing", "crossing")
        for planner in planners
        for seed in range(3)
    ]
